//! Whether the intervals of one log hold the estimates of others.

use super::identified::{Coefficient, Run};

/// Standard errors on each side of a 95 % interval.
const NORMAL: f64 = 1.96;

/// How many estimates of coefficients by other logs lie in the 95 % intervals of each log, and how many there are. A coefficient counts where both logs have its term; coefficients of
/// one equation that are multiples of one parameter count once.
pub(crate) fn covered(runs: &[Run]) -> (usize, usize) {
    let (mut inside, mut all) = (0, 0);
    for (i, run) in runs.iter().enumerate() {
        let own = distinct(&run.coefficients);
        for other in runs.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other) {
            for c in &own {
                let Some(theirs) = other.coefficient(&c.state, &c.term) else { continue };
                all += 1;
                inside += usize::from((theirs.value - c.value).abs() <= NORMAL * c.standard_error);
            }
        }
    }
    (inside, all)
}

/// Of coefficients of one equation with the same relative error the first.
fn distinct(all: &[Coefficient]) -> Vec<&Coefficient> {
    let relative = |c: &Coefficient| (c.standard_error / c.value).abs();
    let mut own: Vec<&Coefficient> = Vec::new();
    for c in all.iter().filter(|c| c.standard_error > 0.0) {
        let known = |o: &&Coefficient| o.state == c.state && (relative(o) - relative(c)).abs() < 1e-9 * relative(c);
        if !own.iter().any(known) {
            own.push(c);
        }
    }
    own
}
