//! What a log has to offer before anything is identified in it.

use ndarray::s;
use sindyna_core::{Kind, Rollout};

use crate::Log;
use crate::response::{Signals, strongest};

/// What the samples of a log are like.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Seconds from the first to the last sample of all trajectories together.
    pub duration: f64,
    /// Shortest, median and longest step \[s\].
    pub steps: (f64, f64, f64),
    /// Observed states, then inputs.
    pub signals: Vec<Signal>,
    /// Share of the steps in which no state moves by more than its resolution.
    pub stationary: f64,
    /// From each input to each state that has no rate among the others.
    pub responses: Vec<Response>,
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Its name.
    pub name: String,
    /// Its unit; empty where none is known.
    pub unit: String,
    /// Lowest and highest value.
    pub range: (f64, f64),
    /// Shares of the rows at the lowest and at the highest value: large ones where something clips.
    pub at_ends: (f64, f64),
    /// Standard deviation of its error, as its digits, its values or the user say; `None` for none and for inputs.
    pub error: Option<f64>,
    /// Whether it is the same in every row.
    pub constant: bool,
}

/// How a derivative of a state follows an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// The input.
    pub input: String,
    /// The state.
    pub state: String,
    /// Which one: 1 for its rate; 2 for the rate of that, where it was not measured and follows the input more.
    pub order: usize,
    /// Time after which it follows the input \[s\]: where their correlation is largest; below 0 where it comes before. `None` where it is not beyond
    /// chance, or may be largest beyond the delays that are looked at.
    pub delay: Option<f64>,
    /// Two standard deviations around it \[s\].
    pub delay_range: Option<(f64, f64)>,
    /// The correlation there, of what is left of both without their linear dependence on the states and on sines and cosines of angles.
    pub correlation: f64,
}

impl Log {
    /// What the samples of the log are like.
    #[must_use]
    pub fn inspect(&self) -> Inspection {
        let steps = self.steps();
        let mut sorted: Vec<f64> = steps.iter().flatten().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(self.spec.dt)
        };
        let errors: Vec<f64> = self.spec.noise_deviations().collect();
        let states = self.spec.observation.iter().zip(&errors).enumerate();
        let states = states.map(|(i, (c, error))| {
            let values: Vec<f64> = self.data.rollouts().flat_map(|r| r.observations.column(i).to_vec()).collect();
            signal(&c.name, &c.unit, &values, Some(*error).filter(|e| *e > 0.0))
        });
        let inputs = self.spec.control.iter().enumerate().map(|(i, c)| {
            let values: Vec<f64> = self.data.rollouts().flat_map(|r| r.controls.column(i).to_vec()).collect();
            signal(&c.name, &c.unit, &values, None)
        });
        Inspection {
            duration: sorted.iter().sum(),
            steps: (at(0.0), at(0.5), at(1.0)),
            signals: states.chain(inputs).collect(),
            stationary: self.stationary(&errors),
            responses: self.responses(),
        }
    }

    /// Lengths of the steps of each trajectory \[s\].
    fn steps(&self) -> Vec<Vec<f64>> {
        let even = |r: Rollout<'_>| vec![self.spec.dt; r.controls.nrows()];
        match &self.times {
            None => self.data.rollouts().map(even).collect(),
            Some(times) => times.iter().map(|t| t.windows(2).map(|pair| pair[1] - pair[0]).collect()).collect(),
        }
    }

    /// Share of the steps in which no state moves by more than its resolution; an error of a step q has the deviation q/√12.
    fn stationary(&self, errors: &[f64]) -> f64 {
        let still = |r: &Rollout<'_>, t: usize| {
            let moved = r.observations.row(t + 1).to_owned() - r.observations.row(t);
            moved.iter().zip(errors).all(|(moved, error)| moved.abs() <= 1.01 * 12_f64.sqrt() * error)
        };
        let count: usize =
            self.data.rollouts().map(|r| (0..r.controls.nrows()).filter(|t| still(&r, *t)).count()).sum();
        count as f64 / self.data.n_steps().max(1) as f64
    }

    /// The rows after which states follow inputs most, where that stands out; each number once.
    #[must_use]
    pub fn delays(&self) -> Vec<f64> {
        let mut rows: Vec<f64> =
            self.responses().iter().filter_map(|r| Some((r.delay? / self.spec.dt).round())).collect();
        rows.sort_by(f64::total_cmp);
        rows.dedup();
        rows
    }

    fn responses(&self) -> Vec<Response> {
        let state = &self.spec.state;
        let has_rate = |i: usize| state.iter().any(|c| c.kind == Kind::RateOf(i));
        // Columns of states; an angle that is seen as cosine and sine has none.
        let column = |name: &str| self.spec.observation.iter().position(|o| o.name == name);
        let fastest: Vec<(usize, usize)> =
            (0..state.len()).filter(|i| !has_rate(*i)).filter_map(|i| Some((i, column(&state[i].name)?))).collect();
        let pairs = (0..self.spec.control_dim()).flat_map(|u| fastest.iter().map(move |(i, x)| (u, *i, *x)));
        pairs.map(|(u, i, x)| self.response(u, i, x)).collect()
    }

    /// How a derivative of state `i`, which is in column `x`, follows input `u`.
    fn response(&self, u: usize, i: usize, x: usize) -> Response {
        let signals = |r: Rollout<'_>| {
            let rows = r.controls.nrows();
            let column = |i: usize| r.observations.slice(s![..rows, i]).to_owned();
            let is_angle = |i: &usize| self.spec.observation[*i].kind == Kind::Angle;
            let turned = (0..self.spec.observation_dim()).filter(is_angle);
            let turned = turned.flat_map(|i| [column(i).mapv(f64::sin), column(i).mapv(f64::cos)]);
            Signals {
                state: column(x),
                input: r.controls.column(u).to_owned(),
                others: r
                    .controls
                    .columns()
                    .into_iter()
                    .enumerate()
                    .filter(|(j, _)| *j != u)
                    .map(|(_, c)| c.to_owned())
                    .collect(),
                beside: (0..self.spec.observation_dim()).map(column).chain(turned).collect(),
            }
        };
        let signals: Vec<Signals> = self.data.rollouts().map(signals).collect();
        // A state whose rate was not measured may be a position.
        let orders: &[usize] = if matches!(self.spec.state[i].kind, Kind::RateOf(_)) { &[1] } else { &[1, 2] };
        let found = strongest(&signals, orders);
        // Of a few hundred correlations of noise, the largest is beyond this once in ten thousand logs.
        let chance = 5.0 / (found.count.max(1) as f64).sqrt();
        // What is largest at the end of what was looked at is largest nowhere.
        let seen = found.correlation.abs() > chance && found.inside;
        let seconds = |lag: isize| lag as f64 * self.spec.dt;
        let delay = seen.then(|| seconds(found.lag));
        let delay_range = seen.then(|| (seconds(found.range.0), seconds(found.range.1)));
        let (input, state) = (self.spec.control[u].name.clone(), self.spec.state[i].name.clone());
        Response { input, state, order: found.order.max(1), delay, delay_range, correlation: found.correlation }
    }
}

fn signal(name: &str, unit: &str, values: &[f64], error: Option<f64>) -> Signal {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let share =
        |end: f64| values.iter().filter(|v| v.to_bits() == end.to_bits()).count() as f64 / values.len().max(1) as f64;
    Signal {
        name: name.to_owned(),
        unit: unit.to_owned(),
        range: (low, high),
        at_ends: (share(low), share(high)),
        error,
        constant: low >= high,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LogOptions;

    #[test]
    fn a_delay_a_clip_and_rest_are_seen() {
        // v̇ = 2 u, 3 steps late; u is clipped at ±1; nothing moves at first.
        let u = |i: usize| if i < 40 { 0.0 } else { (1.7 * ((i * i) as f64 * 0.37).sin()).clamp(-1.0, 1.0) };
        let (mut v, mut text) = (0.0, String::from("t,v,u\n"));
        for i in 0..400 {
            text += &format!("{},{v},{}\n", 0.01 * i as f64, u(i));
            v += 0.01 * 2.0 * if i < 3 { 0.0 } else { u(i - 3) };
        }
        let log = Log::parse("log.csv", text, &LogOptions::new(["v"]).with_inputs(["u"])).unwrap();
        let seen = log.inspect();
        let response = &seen.responses[0];
        assert!(response.delay.is_some_and(|d| (d - 0.03).abs() < 1e-9) && response.correlation > 0.95, "{response:?}");
        assert!((seen.stationary - 43.0 / 399.0).abs() < 0.01, "{}", seen.stationary);
        let input = &seen.signals[1];
        assert!(
            input.range == (-1.0, 1.0) && input.at_ends.0 > 0.2 && input.at_ends.1 > 0.2 && !input.constant,
            "{input:?}"
        );
        assert!((seen.duration - 3.99).abs() < 1e-9 && (seen.steps.1 - 0.01).abs() < 1e-12);
    }
}
