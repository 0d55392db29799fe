//! Where a learned model was compared with the system it describes.

use rand::RngExt as _;

use crate::region::turns_freely;
use crate::whitened::Whitened;
use crate::{Channel, Dataset, Inverse, Rng, Spec};

/// What the data say of one state.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Extent {
    /// An angle that is seen only through its cosine and sine: one turn of it is all there is.
    Turning,
    /// Within declared bounds.
    Bounded { low: f64, high: f64 },
    /// As far as the data reached and as far again to both sides: `center` ± `half`.
    Seen { center: f64, half: f64 },
}

/// The support of the data in state space: the range of each state, widened by half of it at both ends, in whose half width distances from the
/// data are measured; and within it the whitened coordinates of the data, in which what lies across them is far.
///
/// Equations may hold far beyond it, but nobody has seen it. States with declared bounds are never outside, nor are angles that are seen only through
/// their cosine and sine.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    extents: Vec<Extent>,
    whitened: Whitened,
    /// The largest whitened distance of a sample or a start state.
    reach: f64,
}

/// Half widths of the support at which a model is not followed any further: equations that blow up are ended before they overflow.
const EDGE: f64 = 30.0;

/// Half width of the support, in half widths of the range of the data, and whitened distance to which it goes, in that of the farthest sample: a few steps
/// seldom go to both sides.
const AROUND: f64 = 2.0;

/// Smallest half width as a part of the centre's magnitude, for states that stood still.
const STILL: f64 = 1e-6;

impl Support {
    /// The support of `data` of the system `spec` declares, and of states `starts` (each n) in which its episodes begin.
    #[must_use]
    pub fn of(spec: &Spec, data: &Dataset, starts: &[Vec<f64>]) -> Self {
        let extent = |(i, channel): (usize, &Channel)| {
            let (low, high) = channel.prior.bounds;
            let column = spec.observation.iter().position(|o| o.name == channel.name);
            match column {
                _ if channel.is_bounded() => Extent::Bounded { low, high },
                _ if turns_freely(spec, channel) => Extent::Turning,
                _ => {
                    let shown = column
                        .into_iter()
                        .flat_map(|c| data.rollouts().map(move |r| r.observations.column(c).to_vec()));
                    let shown = shown.flatten().chain(starts.iter().map(|x| x[i]));
                    let (least, most) =
                        shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (v.min(l), v.max(h)));
                    let (least, most) = if least <= most { (least, most) } else { (0.0, 0.0) };
                    let center = 0.5 * (least + most);
                    let half = AROUND * 0.5 * (most - least);
                    Extent::Seen { center, half: half.max(STILL * (1.0 + center.abs())) }
                }
            }
        };
        let samples = samples(spec, data);
        // One turn of an angle is all there is, wherever the data are in it.
        let turning = |channel| turns_freely(spec, channel).then_some(std::f64::consts::PI / 3.0_f64.sqrt());
        let whitened = Whitened::of(&samples, &spec.state.iter().map(turning).collect::<Vec<_>>());
        let mut support = Self { extents: spec.state.iter().enumerate().map(extent).collect(), whitened, reach: 0.0 };
        support.reach = samples.iter().chain(starts).map(|x| support.distance(x)).fold(0.0, f64::max);
        support
    }

    /// Standard deviation of each state (n) over the data.
    #[must_use]
    pub fn deviations(&self) -> &[f64] {
        self.whitened.deviations()
    }

    /// Distance of `x` (n) from the middle of the data in their whitened coordinates; angles that are seen only through their cosine and sine are nowhere far.
    #[must_use]
    pub fn distance(&self, x: &[f64]) -> f64 {
        let is_turning = |extent: &Extent| matches!(extent, Extent::Turning);
        let in_turn: Vec<f64> =
            x.iter().zip(&self.extents).map(|(x, extent)| if is_turning(extent) { 0.0 } else { *x }).collect();
        self.whitened.distance(&in_turn)
    }

    /// How far `x` (n) is across the data: its whitened distance beyond twice that of the farthest sample, in units of that; 0 nearer.
    #[must_use]
    pub fn across(&self, x: &[f64]) -> f64 {
        if self.reach > 0.0 { (self.distance(x) / (AROUND * self.reach) - 1.0).max(0.0) } else { 0.0 }
    }

    /// The length of the `difference` (n) of two states in whitened coordinates: 1 is a standard deviation of the data.
    #[must_use]
    pub fn length(&self, difference: impl Iterator<Item = f64>) -> f64 {
        self.whitened.length(difference)
    }

    /// How far `x` (n) is outside of the support, in its half widths: 0 inside.
    #[must_use]
    pub fn excess(&self, x: &[f64]) -> f64 {
        let each = x.iter().zip(&self.extents).map(|(x, extent)| match *extent {
            Extent::Seen { center, half } => ((x - center).abs() / half - 1.0).max(0.0),
            _ => 0.0,
        });
        each.map(|e| e * e).sum::<f64>().sqrt()
    }

    /// Whether a model is followed to `x` (n) at all.
    #[must_use]
    pub fn contains(&self, x: &[f64]) -> bool {
        x.iter().zip(&self.extents).all(|(x, extent)| match *extent {
            Extent::Turning => true,
            Extent::Bounded { low, high } => (low..=high).contains(x),
            Extent::Seen { center, half } => (x - center).abs() <= EDGE * half,
        })
    }

    /// Moves `x` (n) to the nearest place to which a model is followed.
    pub fn clamp(&self, x: &mut [f64]) {
        for (x, extent) in x.iter_mut().zip(&self.extents) {
            match *extent {
                Extent::Turning => {}
                Extent::Bounded { low, high } => *x = x.clamp(low, high),
                Extent::Seen { center, half } => *x = x.clamp(center - EDGE * half, center + EDGE * half),
            }
        }
    }

    /// Draws a state of the support into `x` (n).
    pub fn draw(&self, rng: &mut Rng, x: &mut [f64]) {
        for (x, (middle, half)) in x.iter_mut().zip(self.ranges()) {
            *x = rng.random_range(middle - half..=middle + half);
        }
    }

    /// Middle and half width of each state (n).
    fn ranges(&self) -> impl Iterator<Item = (f64, f64)> {
        self.extents.iter().map(|extent| match *extent {
            Extent::Turning => (0.0, std::f64::consts::PI),
            Extent::Bounded { low, high } => (0.5 * (low + high), 0.5 * (high - low)),
            Extent::Seen { center, half } => (center, half),
        })
    }
}

/// The states (n each) of `data`; none where they follow from no observation.
fn samples(spec: &Spec, data: &Dataset) -> Vec<Vec<f64>> {
    let Ok(inverse) = Inverse::of(spec) else { return Vec::new() };
    let mut samples = Vec::new();
    for rollout in data.rollouts() {
        let mut x = vec![0.0; spec.state_dim()];
        for o in rollout.observations.rows() {
            let near = x.clone();
            inverse.state(&o.to_vec(), &near, &mut x);
            samples.push(x.clone());
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, Precision, Seed, Space};

    fn spec() -> Spec {
        let height = Channel::new("h", "m", Kind::Plain, 1.0);
        let v = Channel::new("v", "m/s", Kind::RateOf(0), 1.0).within(-0.07, 0.07);
        let angle = Channel::new("θ", "rad", Kind::Angle, 1.0);
        let cosine = Channel::new("cos θ", "", Kind::CosOf(2), 1.0);
        Spec {
            name: "any".into(),
            state: vec![height.clone(), v.clone(), angle],
            observation: vec![height, v, cosine],
            control: vec![],
            action_space: Space::Box { low: vec![], high: vec![] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.1,
        }
    }

    /// Heights 1.2 and 1.3 m were seen, episodes begin at 1.4 m.
    fn support() -> Support {
        let mut data = Dataset::new(3, 0, 0, 0.1);
        data.begin(&[1.2, 0.0, 1.0]).expect("finite");
        data.push(&[], &[], 0.0, &[1.3, 5.0, 1.0]).expect("finite");
        Support::of(&spec(), &data, &[vec![1.4, 0.0, 0.0]])
    }

    #[test]
    fn distances_are_measured_from_the_data_in_their_own_range() {
        let support = support();
        assert_eq!(support.excess(&[1.25, 0.0, 40.0]), 0.0, "inside, and angles that turn are never outside");
        assert!((support.excess(&[1.6, 0.0, 0.0]) - 0.5).abs() < 1e-12, "0.3 m from the middle of ±0.2 m");
        assert!((support.excess(&[1.0, 0.0, 0.0]) - 0.5).abs() < 1e-12, "a height of 0 is as far as any other");
        assert!(support.contains(&[7.0, 0.07, 40.0]) && !support.contains(&[7.5, 0.0, 0.0]));
        assert!(!support.contains(&[1.3, 0.08, 0.0]), "declared bounds hold, whatever the data show");
        let mut far = [-1e300, 0.5, 40.0];
        support.clamp(&mut far);
        assert!((far[0] + 4.7).abs() < 1e-12 && far[1..] == [0.07, 40.0]);
    }

    #[test]
    fn starts_are_drawn_around_the_data() {
        let (support, mut x, mut rng) = (support(), [0.0; 3], Seed::new(1).numpy());
        for _ in 0..100 {
            support.draw(&mut rng, &mut x);
            assert!(support.contains(&x) && support.excess(&x) == 0.0 && x[2].abs() <= std::f64::consts::PI);
        }
    }

    #[test]
    fn a_state_that_stood_still_leaves_a_range_all_the_same() {
        let mut data = Dataset::new(3, 0, 0, 0.1);
        data.begin(&[300.0, 0.0, 1.0]).expect("finite");
        let support = Support::of(&spec(), &data, &[]);
        assert!(support.excess(&[300.0, 0.0, 0.0]) == 0.0 && support.excess(&[301.0, 0.0, 0.0]).is_finite());
    }
}
