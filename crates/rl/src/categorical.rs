//! The categorical distribution: probabilities, their logarithms, and gradients through both.

/// Probabilities of n numbered actions for rows of heads z: log π = z - log Σ exp z.
///
/// All of it follows from log π, in double precision. An action without probability then has a very negative
/// logarithm, and 0 · log 0 comes up nowhere.
///
/// # References
/// Christodoulou (2019), arXiv:1910.07207, section 3.
#[derive(Debug, Clone, Default)]
pub(crate) struct Categorical {
    n_actions: usize,
    log_probs: Vec<f64>,
    probs: Vec<f64>,
}

/// The distribution of one row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choice<'a> {
    /// π(a) (n).
    pub(crate) probs: &'a [f64],
    /// log π(a) (n).
    pub(crate) log_probs: &'a [f64],
}

impl Categorical {
    /// Overwrites the distributions with those of `heads` (B, n).
    pub(crate) fn load(&mut self, heads: &[f32], n_actions: usize) {
        self.n_actions = n_actions;
        self.log_probs.clear();
        for head in heads.chunks_exact(n_actions) {
            let normaliser = log_sum_exp(head);
            self.log_probs.extend(head.iter().map(|z| f64::from(*z) - normaliser));
        }
        self.probs.clear();
        self.probs.extend(self.log_probs.iter().map(|l| l.exp()));
    }

    /// The distributions, row by row.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Choice<'_>> {
        let rows = self.probs.chunks_exact(self.n_actions).zip(self.log_probs.chunks_exact(self.n_actions));
        rows.map(|(probs, log_probs)| Choice { probs, log_probs })
    }
}

impl Choice<'_> {
    /// -Σ π log π \[nat\].
    pub(crate) fn entropy(self) -> f64 {
        -self.probs.iter().zip(self.log_probs).map(|(p, l)| p * l).sum::<f64>()
    }

    /// V = Σ π (Q - α log π), a sum over the actions and not a mean: Q (n) are the `values`, α is the `temperature`.
    pub(crate) fn soft_value(self, values: &[f64], temperature: f64) -> f64 {
        self.probs.iter().zip(self.log_probs).zip(values).map(|((p, l), q)| p * (q - temperature * l)).sum()
    }

    /// ∂V/∂z = π (Q - α log π - V) (n): the term of ∂log π/∂z falls out, since Σ π ∂log π/∂z = ∂Σπ/∂z = 0.
    pub(crate) fn slopes(self, values: &[f64], temperature: f64) -> impl Iterator<Item = f64> {
        let value = self.soft_value(values, temperature);
        let terms = self.probs.iter().zip(self.log_probs).zip(values);
        terms.map(move |((p, l), q)| p * (q - temperature * l - value))
    }
}

/// log Σ exp z, without overflow.
fn log_sum_exp(head: &[f32]) -> f64 {
    let largest = head.iter().map(|z| f64::from(*z)).fold(f64::NEG_INFINITY, f64::max);
    largest + head.iter().map(|z| (f64::from(*z) - largest).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(head: &[f32]) -> Categorical {
        let mut c = Categorical::default();
        c.load(head, head.len());
        c
    }

    #[test]
    fn equal_actions_have_the_entropy_of_a_fair_draw() {
        for n in [2, 3, 7] {
            let c = of(&vec![1.3; n]);
            let entropy = c.rows().next().expect("one row").entropy();
            assert!((entropy - (n as f64).ln()).abs() < 1e-15, "{n}: {entropy}");
        }
    }

    #[test]
    fn values_are_summed_over_actions() {
        let c = of(&[0.0, 0.0]);
        let value = c.rows().next().expect("one row").soft_value(&[3.0, 5.0], 0.5);
        assert!((value - (4.0 + 0.5 * 2_f64.ln())).abs() < 1e-15, "{value}");
    }

    #[test]
    fn a_certain_action_leaves_every_number_finite() {
        for far in [50.0, 800.0, 1e30, f32::MAX] {
            let c = of(&[far, -far, 0.0]);
            let row = c.rows().next().expect("one row");
            let slopes: Vec<f64> = row.slopes(&[1.0, -1.0, 2.0], 0.3).collect();
            assert!(row.log_probs.iter().chain(&slopes).all(|v| v.is_finite()), "{far}: {row:?} {slopes:?}");
            assert!(row.entropy() >= 0.0 && row.entropy() < 1e-20, "{far}: {}", row.entropy());
            assert!((row.soft_value(&[1.0, -1.0, 2.0], 0.3) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn slopes_are_those_of_the_soft_value() {
        let (z, q, alpha, h) = ([0.3_f64, -1.1, 0.6], [0.5, 2.0, -1.0], 0.7, 1e-5);
        let value = |z: [f64; 3]| {
            let normaliser = z.iter().map(|z| z.exp()).sum::<f64>().ln();
            z.iter().zip(q).map(|(z, q)| (z - normaliser).exp() * (q - alpha * (z - normaliser))).sum::<f64>()
        };
        let c = of(&z.map(|z| z as f32));
        for (i, slope) in c.rows().next().expect("one row").slopes(&q, alpha).enumerate() {
            let moved = |by: f64| {
                let mut z = z;
                z[i] += by;
                value(z)
            };
            let truth = (moved(h) - moved(-h)) / (2.0 * h);
            assert!((slope - truth).abs() < 1e-7, "{i}: {slope} {truth}");
        }
    }
}
