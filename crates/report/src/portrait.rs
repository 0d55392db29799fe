//! Phase portraits: where the true system goes, and where a model says that it goes.

use std::f64::consts::FRAC_PI_2;

use sindyna_core::{Dynamics, Kind, Mode, Observe as _, Policy, Region, Seed, Spec};
use sindyna_envs::System;
use sindyna_sindy::Model;

/// Start states of a portrait.
const STARTS: usize = 10;

/// Steps of a path at most: without input, and in closed loop, where paths soon come to rest.
const STEPS: usize = 120;
const CLOSED_STEPS: usize = 60;

/// One path from one start state, step by step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Path {
    pub(crate) truth: Vec<Vec<f64>>,
    pub(crate) model: Vec<Vec<f64>>,
}

/// All paths of one system.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Portrait {
    pub(crate) paths: Vec<Path>,
    /// A panel each: the state across, and the state upwards, which is its rate.
    pub(crate) panels: Vec<(usize, usize)>,
}

/// The portrait of `model` beside the `system` it is a model of, without any input, from start states about the middle of the box of
/// the system's states.
///
/// A path ends where a limit may act, since limits are no part of the equations: where a position comes to the border of the box, a
/// rate to its declared bound, or an angle that does not turn freely to a quarter turn.
pub(crate) fn portrait(system: &System, model: &Model) -> Portrait {
    let still = vec![0.0; system.spec().control_dim()];
    of(system.spec(), (&*system.dynamics(), model), &|_| still.clone(), STEPS)
}

/// The same in closed loop: `policy` acts on the true system by what its sensors show, and on the model likewise.
pub(crate) fn closed_loop(system: &System, model: &Model, policy: &dyn Policy) -> Portrait {
    let (spec, sensors) = (system.spec(), system.sensors().without_noise());
    let control = |x: &[f64]| {
        // Neither sensors without noise nor the mode draw from it.
        let mut rng = Seed::new(0).stream("portrait", 2);
        let mut observation = vec![0.0; spec.observation_dim()];
        let mut action = vec![0.0; spec.action_space.action_dim()];
        let mut control = vec![0.0; spec.control_dim()];
        sensors.observe(x, &mut rng, &mut observation);
        policy.act(&observation, Mode::Exploit, &mut rng, &mut action);
        spec.action_space.control_into(&action, &mut control);
        control
    };
    of(spec, (&*system.dynamics(), model), &control, CLOSED_STEPS)
}

/// What acts on a system in a state.
type Control<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

fn of(spec: &Spec, both: (&dyn Dynamics, &dyn Dynamics), control: Control<'_>, steps: usize) -> Portrait {
    let region = Region::of(spec);
    let mut rng = Seed::new(0).stream("portrait", 0);
    let mut draw = || {
        let mut x = vec![0.0; spec.state_dim()];
        region.sample(&mut rng, &mut x);
        x
    };
    // The mean of two draws is more often far from the border, where a path would end as soon as it has begun.
    let mut start = || draw().iter().zip(draw()).map(|(a, b)| 0.5 * (a + b)).collect();
    let starts: Vec<Vec<f64>> = (0..STARTS).map(|_| start()).collect();
    let paths = starts.into_iter().map(|x| path(spec, &region, both, (control, steps), x)).collect();
    let panel = |(i, channel): (usize, &sindyna_core::Channel)| match channel.kind {
        Kind::RateOf(of) => Some((of, i)),
        _ => None,
    };
    Portrait { paths, panels: spec.state.iter().enumerate().filter_map(panel).collect() }
}

fn path(
    spec: &Spec,
    region: &Region,
    (truth, model): (&dyn Dynamics, &dyn Dynamics),
    (control, steps): (Control<'_>, usize),
    start: Vec<f64>,
) -> Path {
    let mut path = Path { truth: vec![start.clone()], model: vec![start] };
    // Neither draws from it: both are what they are.
    let mut rng = Seed::new(0).stream("portrait", 1);
    let mut after = |dynamics: &dyn Dynamics, states: &[Vec<f64>]| {
        let mut next = vec![0.0; spec.state_dim()];
        let x = states.last()?;
        dynamics.step(x, &control(x), &mut rng, &mut next).ok()?;
        is_free(spec, region, &next).then_some(next)
    };
    for _ in 0..steps {
        let (Some(real), Some(imagined)) = (after(truth, &path.truth), after(model, &path.model)) else { break };
        path.truth.push(real);
        path.model.push(imagined);
    }
    path
}

/// Whether no limit can act in the state `x`.
fn is_free(spec: &Spec, region: &Region, x: &[f64]) -> bool {
    let clamped = |x: &[f64]| {
        let mut inside = x.to_vec();
        region.clamp(&mut inside);
        inside
    };
    // An angle that turns freely is left as it is, however far away.
    let (inside, far) = (clamped(x), clamped(&vec![f64::MAX; x.len()]));
    spec.state.iter().enumerate().all(|(i, channel)| match channel.kind {
        Kind::Angle => far[i] >= f64::MAX || x[i].abs() < FRAC_PI_2,
        Kind::RateOf(_) => channel.prior.bounds.0 < x[i] && x[i] < channel.prior.bounds.1,
        _ => inside[i].to_bits() == x[i].to_bits() && channel.prior.bounds.0 < x[i] && x[i] < channel.prior.bounds.1,
    })
}

impl Portrait {
    /// The largest distance of a state of the model from the true one, over all paths, as part of the state's scale.
    pub(crate) fn distance(&self, spec: &Spec) -> f64 {
        let pairs = self.paths.iter().flat_map(|path| path.truth.iter().zip(&path.model));
        let apart = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            let each = a.iter().zip(b).zip(&spec.state).map(|((a, b), channel)| (a - b).abs() / channel.prior.scale);
            each.fold(0.0, f64::max)
        };
        pairs.map(apart).fold(0.0, f64::max)
    }

    /// Steps of the longest path.
    pub(crate) fn steps(&self) -> usize {
        self.paths.iter().map(|path| path.truth.len() - 1).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_sindy::{Entry, Form, ModelParts};

    /// ω̇ = a sin θ + 3 u, stepped as the true pendulum is.
    fn pendulum(a: f64) -> Model {
        let parts = ModelParts {
            states: vec!["θ".into(), "ω".into()],
            controls: vec!["u".into()],
            form: Form::SemiImplicit { substeps: 1 },
            dt: 0.05,
            readings: None,
            terms: ["ω", "sin(θ)", "u"].map(String::from).to_vec(),
            equations: vec![vec![Entry::new(0, 1.0)], vec![Entry::new(1, a), Entry::new(2, 3.0)]],
            kinematic: vec![true, false],
            offsets: vec![0.0; 2],
            n_features: 3,
        };
        Model::new(parts).expect("the parts fit")
    }

    #[test]
    fn an_exact_model_goes_where_the_true_system_goes() {
        let system = sindyna_envs::find("pendulum").expect("there is one");
        let exact = portrait(&system, &pendulum(15.0));
        assert_eq!((exact.paths.len(), &exact.panels[..]), (STARTS, &[(0, 1)][..]));
        assert!(exact.distance(system.spec()) < 1e-6, "{}", exact.distance(system.spec()));
        assert!(exact.steps() == STEPS, "some path stays in the box");
        let wrong = portrait(&system, &pendulum(14.0));
        assert!(wrong.distance(system.spec()) > 0.1, "{}", wrong.distance(system.spec()));
    }

    /// Pushes against the fall of a pendulum that observes cos θ, sin θ, ω.
    struct Damper;

    impl Policy for Damper {
        fn act_batch(
            &self,
            observations: ndarray::ArrayView2<'_, f64>,
            _mode: Mode,
            _rng: &mut sindyna_core::Rng,
            mut actions: ndarray::ArrayViewMut2<'_, f64>,
        ) {
            for (o, mut action) in observations.rows().into_iter().zip(actions.rows_mut()) {
                action[0] = -10.0 * o[1] - 2.0 * o[2];
            }
        }
    }

    #[test]
    fn in_closed_loop_the_policy_acts_on_both() {
        let system = sindyna_envs::find("pendulum").expect("there is one");
        let exact = closed_loop(&system, &pendulum(15.0), &Damper);
        // Both are observed in float32, whose rounding the loop carries on.
        assert!(exact.distance(system.spec()) < 1e-4, "{}", exact.distance(system.spec()));
        let free = portrait(&system, &pendulum(15.0));
        assert_ne!(exact.paths, free.paths);
        // From the same states, with the torque that the law asks for within its bounds of 2.
        let (a, b) = (&exact.paths[0].truth, &free.paths[0].truth);
        assert_eq!(a[0], b[0]);
        let torque = (-10.0 * a[0][0].sin() - 2.0 * a[0][1]).clamp(-2.0, 2.0);
        assert!((a[1][1] - b[1][1] - 0.05 * 3.0 * torque).abs() < 1e-6, "{:?} {} {} {torque}", a[0], a[1][1], b[1][1]);
    }

    #[test]
    fn a_system_of_two_bodies_has_two_panels() {
        let system = sindyna_envs::find("inverted-pendulum").expect("there is one");
        let truth = system.dynamics();
        let found = of(system.spec(), (&*truth, &*truth), &|_| vec![0.0], STEPS);
        assert_eq!(found.panels, [(0, 2), (1, 3)]);
        assert_eq!(found.distance(system.spec()), 0.0);
    }
}
