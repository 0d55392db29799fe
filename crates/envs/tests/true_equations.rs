//! The equations that are shown beside identified ones are those of the systems.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::HashMap;

use sindyna_core::Seed;
use sindyna_envs::System;

/// An equation as it is written, such as `0.05 cos θ v̇ + 3 u`: products are written side by side, a function takes what stands behind it.
struct Reader<'a> {
    text: Vec<char>,
    at: usize,
    values: &'a HashMap<String, f64>,
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<char> {
        while self.text.get(self.at) == Some(&' ') {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn sum(&mut self) -> f64 {
        let mut sum = 0.0;
        let mut sign = 1.0;
        while let Some(c) = self.peek().filter(|c| *c != ')') {
            match c {
                '+' | '−' => {
                    self.at += 1;
                    sign = if c == '−' { -1.0 } else { 1.0 };
                }
                _ => sum += sign * self.product(),
            }
        }
        sum
    }

    fn product(&mut self) -> f64 {
        let mut product = 1.0;
        while self.peek().is_some_and(|c| !['+', '−', ')'].contains(&c)) {
            product *= self.factor();
        }
        product
    }

    fn factor(&mut self) -> f64 {
        let value = match self.peek().unwrap() {
            '(' => self.group(),
            c if c.is_ascii_digit() => {
                let number = self.word(|c| c.is_ascii_digit() || c == '.');
                number.parse().unwrap()
            }
            _ => {
                let word = self.word(|c| !" ²()+−".contains(c));
                let function: Option<fn(f64) -> f64> = match word.as_str() {
                    "sin" => Some(f64::sin),
                    "cos" => Some(f64::cos),
                    _ => None,
                };
                let Some(function) = function else { return self.squared(self.values[&word]) };
                let is_square = self.text.get(self.at) == Some(&'²');
                self.at += usize::from(is_square);
                let argument = if self.peek() == Some('(') { self.group() } else { self.argument() };
                let value = function(argument);
                if is_square { value * value } else { value }
            }
        };
        self.squared(value)
    }

    /// `θ` or `3x` behind a function.
    fn argument(&mut self) -> f64 {
        let number = self.word(|c| c.is_ascii_digit() || c == '.');
        let name = self.word(|c| !" ²()+−".contains(c));
        number.parse().unwrap_or(1.0) * self.values[&name]
    }

    fn group(&mut self) -> f64 {
        self.at += 1;
        let value = self.sum();
        self.at += 1;
        value
    }

    fn squared(&mut self, value: f64) -> f64 {
        let is_square = self.text.get(self.at) == Some(&'²');
        self.at += usize::from(is_square);
        if is_square { value * value } else { value }
    }

    fn word(&mut self, belongs: impl Fn(char) -> bool) -> String {
        self.peek();
        let word: String = self.text[self.at..].iter().take_while(|c| belongs(**c)).collect();
        self.at += word.chars().count();
        word
    }
}

fn value(side: &str, values: &HashMap<String, f64>) -> f64 {
    Reader { text: side.chars().collect(), at: 0, values }.sum()
}

/// The name of the rate of `state`: a dot above its first letter.
fn rate_name(state: &str) -> String {
    let mut letters = state.chars();
    let first: String = letters.next().into_iter().collect();
    let dotted = match first.as_str() {
        "x" => "ẋ".to_owned(),
        "y" => "ẏ".to_owned(),
        "z" => "ż".to_owned(),
        other => format!("{other}\u{307}"),
    };
    dotted + letters.as_str()
}

/// The largest difference of the sides of the true equations of `system` over random states, over the size of the sides.
fn largest_error(system: &System) -> f64 {
    let (spec, rates) = (system.spec(), system.rates());
    let mut rng = Seed::new(7).stream("true equations", 0);
    let mut uniform = |scale: f64| {
        use rand::RngExt as _;
        scale * rng.random_range(-1.0..1.0)
    };
    let mut worst = 0.0_f64;
    for _ in 0..50 {
        let x: Vec<f64> = spec.state.iter().map(|c| uniform(c.prior.scale)).collect();
        let u: Vec<f64> = spec.control.iter().map(|c| uniform(c.prior.scale)).collect();
        let mut dx = vec![0.0; x.len()];
        rates.eval(&x, &u, &mut dx);
        let mut values = HashMap::new();
        for (i, channel) in spec.state.iter().enumerate() {
            values.insert(channel.name.clone(), x[i]);
            values.insert(format!("{}'", channel.name), x[i] + dx[i]);
            values.insert(rate_name(&channel.name), dx[i]);
        }
        values.extend(spec.control.iter().zip(&u).map(|(channel, u)| (channel.name.clone(), *u)));
        for equation in system.true_equations() {
            let (left, right) = equation.split_once(" = ").unwrap();
            let (left, right) = (value(left, &values), value(right, &values));
            let size = dx.iter().chain(&x).chain(&u).fold(1.0_f64, |size, v| size.max(v.abs()));
            worst = worst.max((left - right).abs() / size);
        }
    }
    worst
}

#[test]
fn the_true_equations_are_those_of_the_systems() {
    let all = sindyna_envs::systems().into_iter().chain(sindyna_envs::fields());
    for system in all {
        let error = largest_error(&system);
        assert!(error < 1e-4, "{}: off by {error:e}: {:?}", system.name(), system.true_equations());
    }
}

#[test]
fn another_coefficient_is_seen() {
    let values = HashMap::from([("θ".to_owned(), 0.3), ("ω".to_owned(), -2.0), ("v\u{307}".to_owned(), 1.5)]);
    let expected = 0.05 * 0.3_f64.cos() * 1.5 - 2.0 * 0.3_f64.sin().powi(2) * 4.0 + (1.0 + 0.5 * -2.0) * 0.9_f64.sin();
    assert!((value("0.05 cos θ v\u{307} − 2 sin² θ ω² + (1 + 0.5 ω) sin 3θ", &values) - expected).abs() < 1e-12);
    assert!((value("0.06 cos θ v\u{307}", &values) - 0.05 * 0.3_f64.cos() * 1.5).abs() > 1e-3);
}
