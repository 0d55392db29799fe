//! Sines and cosines of sums of angles.

use crate::expr::{Expr, Function};

/// sin k·q or cos k·q; k = 0 is the constant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wave {
    /// k, per joint.
    pub(super) multiples: Vec<i32>,
    pub(super) is_sine: bool,
    pub(super) expr: Expr,
}

/// Waves, each once.
#[derive(Debug, Clone)]
pub(super) struct Waves {
    /// State of the position of each joint.
    positions: Vec<usize>,
    pub(super) all: Vec<Wave>,
}

impl Waves {
    /// The constant alone, number 0.
    pub(super) fn new(positions: Vec<usize>) -> Self {
        let constant = Wave { multiples: vec![0; positions.len()], is_sine: false, expr: Expr::Constant(1.0) };
        Self { positions, all: vec![constant] }
    }

    /// Numbers of the sine and the cosine of k·q. With −k they are the same but for a sign.
    pub(super) fn of(&mut self, multiples: &[i32]) -> [usize; 2] {
        let is_turned = multiples.iter().find(|k| **k != 0).is_some_and(|k| *k < 0);
        let multiples: Vec<i32> = multiples.iter().map(|k| if is_turned { -k } else { *k }).collect();
        if let Some(known) = self.all.iter().position(|w| w.multiples == multiples && w.is_sine) {
            return [known, known + 1];
        }
        let argument = self.sum(&multiples);
        for (function, is_sine) in [(Function::Sin, true), (Function::Cos, false)] {
            let expr = Expr::Call(function, Box::new(argument.clone()));
            self.all.push(Wave { multiples: multiples.clone(), is_sine, expr });
        }
        [self.all.len() - 2, self.all.len() - 1]
    }

    /// k·q.
    fn sum(&self, multiples: &[i32]) -> Expr {
        let part = |(q, k): (&usize, &i32)| {
            let times = f64::from(k.abs());
            let angle = Expr::Variable(*q);
            let angle =
                if *k == 1 || *k == -1 { angle } else { Expr::Mul(Box::new(Expr::Constant(times)), Box::new(angle)) };
            (*k != 0).then_some((angle, *k < 0))
        };
        let parts = self.positions.iter().zip(multiples).filter_map(part);
        let added = parts.reduce(|(sum, _), (next, is_less)| {
            let (sum, next) = (Box::new(sum), Box::new(next));
            (if is_less { Expr::Sub(sum, next) } else { Expr::Add(sum, next) }, false)
        });
        added.map_or(Expr::Constant(0.0), |(sum, _)| sum)
    }
}
