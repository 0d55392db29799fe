//! What a course is expected to earn, and how to go on where it was missed.

use super::course::Course;
use super::goal::Goal;
use super::plant::Plant;
use super::search::search;

/// Part of what an episode was expected to earn by which its plan may fall short before another is looked for.
const SHORT: f64 = 0.05;

/// What a course earns from here on, as it was when it was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub(super) earned: f64,
    /// The most in size that it was in the episode.
    most: f64,
}

impl Expected {
    /// Before any course was found.
    pub(super) fn none() -> Self {
        Self { earned: f64::NAN, most: 0.0 }
    }

    pub(super) fn set(&mut self, earned: f64) {
        self.earned = earned;
        self.most = if earned.is_finite() { self.most.max(earned.abs()) } else { self.most };
    }

    /// Whether `earned` is so much less that another course is to be looked for.
    pub(super) fn is_missed(self, earned: f64) -> bool {
        self.earned - earned > SHORT * self.most
    }

    /// A course from x in place of `course`, which was missed and earns `earned` from there in the next `ahead` steps: the same led back; or the `first` or another one of the `ways` of the episode from a
    /// state near x on, if it earns about what it does from that state; or one that is searched for, which is another way then. The best, and what it earns.
    pub(super) fn regained(
        self,
        (course, earned): (Course, f64),
        (first, ways): (Option<&Course>, &mut Vec<Course>),
        (plant, goals, x): (&Plant, &[Goal], &[f64]),
        ahead: usize,
    ) -> (Course, f64) {
        let mut best = (course, earned);
        if best.0.is_under_way() {
            let led = best.0.led(plant, goals, x, ahead);
            if led.1 > best.1 {
                best = led;
            }
        }
        if !self.is_missed(best.1) {
            return best;
        }
        for joined in first.into_iter().chain(ways.iter()).flat_map(|way| way.joined(plant, x)) {
            let led = joined.led(plant, goals, x, ahead);
            if led.1 > best.1 {
                best = led;
                let of_way = Self { earned: joined.planned(plant, goals, ahead), ..self };
                if !of_way.is_missed(best.1) {
                    return best;
                }
            }
        }
        let found = search(plant, goals, x, ahead, 1);
        if found.1 > best.1 {
            ways.push(found.0.clone());
            best = found;
        }
        best
    }
}
