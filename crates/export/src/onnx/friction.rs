//! Steps with dry friction as part of a graph: every sweep is written out, of one joint one.

use sindyna_sindy::export::Friction;

use super::equations::Writer;

impl<'a> Writer<'a> {
    /// `x` a time `dt` later.
    pub(super) fn rubbed(&mut self, friction: &'a Friction, dt: f64, x: &[String]) -> Vec<String> {
        let h = dt / friction.substeps as f64;
        let (system, controls) = (self.system, self.u.clone());
        self.system = &friction.held;
        let mut at = x.to_vec();
        for _ in 0..friction.substeps {
            at = self.part(friction, h, &at, &controls);
        }
        (self.system, self.u) = (system, controls);
        at
    }

    /// The rates at `x` with the signs given.
    fn with(&mut self, controls: &[String], signs: &[String]) {
        self.u = controls.iter().chain(signs).cloned().collect();
    }

    fn part(&mut self, friction: &Friction, h: f64, at: &[String], controls: &[String]) -> Vec<String> {
        let speeds: Vec<usize> = friction.speeds().collect();
        let q = speeds.len();
        let (zero, one, less) = (self.builder.number(0.0), self.builder.number(1.0), self.builder.number(-1.0));
        let signs: Vec<String> = speeds.iter().map(|i| self.op("Sign", &[&at[*i]])).collect();
        self.with(controls, &signs);
        let mut after = self.classical(at, h);
        let free: Vec<String> = speeds.iter().map(|i| after[*i].clone()).collect();
        let rests: Vec<String> = signs.iter().map(|sign| self.op("Equal", &[sign, &zero])).collect();
        let mut turns = rests[0].clone();
        for j in 0..q {
            let product = self.op("Mul", &[&free[j], &signs[j]]);
            let turned = self.op("Less", &[&product, &zero]);
            for this in [&rests[j], &turned] {
                turns = self.op("Or", &[&turns, this]);
            }
        }
        let taken = self.taken(&speeds, h, at, controls);
        let holds: Vec<String> = (0..q).map(|j| self.op("Greater", &[&taken[j][j], &zero])).collect();
        let (mut v, mut acts) = (free.clone(), signs);
        for _ in 0..if q == 1 { 1 } else { Friction::SWEEPS } {
            for j in 0..q {
                let own = self.op("Where", &[&holds[j], &taken[j][j], &one]);
                let more = self.op("Div", &[&v[j], &own]);
                let wanted = self.op("Add", &[&acts[j], &more]);
                let wanted = self.op("Max", &[&wanted, &less]);
                let wanted = self.op("Min", &[&wanted, &one]);
                let change = self.op("Sub", &[&wanted, &acts[j]]);
                let change = self.op("Where", &[&holds[j], &change, &zero]);
                acts[j] = self.op("Add", &[&acts[j], &change]);
                for (v, taken) in v.iter_mut().zip(&taken[j]) {
                    *v = self.less(v, taken, &change);
                }
            }
        }
        for j in 0..q {
            let size = self.op("Abs", &[&acts[j]]);
            let within = self.op("Less", &[&size, &one]);
            let stops = self.op("And", &[&holds[j], &within]);
            v[j] = self.op("Where", &[&stops, &zero, &v[j]]);
            after[speeds[j]] = self.op("Where", &[&turns, &v[j], &free[j]]);
        }
        for (j, i) in friction.positions() {
            let still = self.op("Equal", &[&v[j], &zero]);
            let stays = self.op("And", &[&rests[j], &still]);
            let change = self.op("Sub", &[&v[j], &free[j]]);
            let moved = self.ahead(&after[i..=i], 0.5 * h, &[change]).swap_remove(0);
            let held = self.op("Where", &[&stays, &at[i], &moved]);
            after[i] = self.op("Where", &[&turns, &held, &after[i]]);
        }
        after
    }

    /// What the friction of each joint takes from each of the speeds.
    fn taken(&mut self, speeds: &[usize], h: f64, at: &[String], controls: &[String]) -> Vec<Vec<String>> {
        let (zero, one, h) = (self.builder.number(0.0), self.builder.number(1.0), self.builder.number(h));
        let mut signs = vec![zero.clone(); speeds.len()];
        self.with(controls, &signs);
        let smooth = self.rates(at);
        let mut taken = Vec::new();
        for j in 0..speeds.len() {
            signs[j] = one.clone();
            self.with(controls, &signs);
            signs[j] = zero.clone();
            let rubbed = self.rates(at);
            let row = speeds.iter().map(|i| {
                let lost = self.op("Sub", &[&smooth[*i], &rubbed[*i]]);
                self.op("Mul", &[&h, &lost])
            });
            taken.push(row.collect());
        }
        taken
    }
}
