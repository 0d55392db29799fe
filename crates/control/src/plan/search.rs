//! The search for the best way through the rest of an episode: guesses, ways through cells, and what makes the best of them better.

use std::ops::Range;

use rayon::prelude::*;

use super::course::{ARRIVED, Course, EFFORT, NOTHING, POLISH, WIDTHS};
use super::front::Front;
use super::goal::Goal;
use super::guess;
use super::ilqr::Plan;
use super::objective::Objective;
use super::plant::Plant;

/// Widths of cells, in scales: the wider ones are sooner through.
const CELLS: [f64; 3] = [0.25, 0.15, 0.1];

/// Ways to each goal that are made smooth at a time, and how much farther from it than the nearest so far they may end.
const NEAREST: usize = 2;
const FARTHER: f64 = 1.2;

/// Iterations of that.
const ITERATIONS: usize = 20;

/// Guesses with waves for each goal and length, more of them if the first lead nowhere; lengths in states' own pace and the factor between them, and lengths that may bring nothing once a goal is
/// reached.
const WAVED: [usize; 2] = [4, 12];
const SHORTEST: f64 = 4.0;
const LONGER: f64 = 1.3;
const ENOUGH: usize = 2;

/// Factor between the lengths that are tried once a goal is reached, from that of the best way downward, and their number: of these one may need a swing less.
const SHORTER: f64 = 1.12;
const SHORTER_TRIED: i32 = 4;

/// Iterations that close the gaps of a guess, the part of the guesses of one length that is then improved further, and the iterations of that.
const CLOSING: usize = 20;
const KEPT: usize = 4;
const ARRIVING: usize = 60;

/// Rounds that may bring nothing once a goal is reached, before no longer ways are tried.
const PATIENCE: usize = 10;

/// Parts of its time in which the same way is tried; then one step less.
const PARTS: [f64; 7] = [0.5, 0.7, 0.85, 0.93, 0.97, 0.985, 0.993];

/// Steps after a plan that are improved with it, and as many as it has.
const BEYOND: usize = 30;

/// The best course from x over the next `steps` steps that is found: ways to each goal among all that the controls can do, shortest first, until
/// longer ones earn no more; made smooth and judged by what they earn.
pub(super) fn search(plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> (Course, f64) {
    let none = Course { plan: None, made: 0, goal: None };
    let mut best = Found { earned: f64::NEG_INFINITY, course: none, arrived: false };
    let plain = (0..goals.len()).map(Some).chain([None]).map(Try::Held);
    best.better(plant, goals, x, steps, plain.collect());
    if is_enough(goals, best.earned, steps) {
        return (best.course, best.earned);
    }
    let mut first = 0;
    for waved in WAVED {
        let last = guess::ways(plant) + waved;
        if !best.arrived {
            best.guess(plant, goals, x, steps, first..last);
        }
        first = last;
    }
    for width in CELLS {
        if !best.arrived {
            best.look(plant, goals, x, steps, width);
        }
    }
    best.shorten(plant, goals, x, steps);
    let mut courses = vec![(best.course, best.earned)];
    if courses[0].0.plan.is_none() {
        // Any goal can be held from here; on the way there a plan may earn more.
        let held = |goal| Course { plan: None, made: 0, goal: Some(goal) };
        let others = (0..goals.len()).filter(|goal| courses[0].0.goal != Some(*goal)).map(held);
        let others: Vec<Course> = others.collect();
        courses.extend(others.into_iter().map(|course| {
            let earned = course.earns(plant, goals, x, steps).0;
            (course, earned)
        }));
    }
    let polished = |(course, earned): (Course, f64)| {
        let length = 2 * course.length(plant, goals, x, steps) + BEYOND;
        course.polished(plant, goals, x, steps, earned, (POLISH, length, &WIDTHS))
    };
    let polished: Vec<(Course, f64)> = courses.into_par_iter().map(polished).collect();
    let best = polished.into_iter().reduce(|best, other| if other.1 > best.1 { other } else { best });
    best.unwrap_or((Course { plan: None, made: 0, goal: None }, f64::NEG_INFINITY))
}

/// The best course so far.
struct Found {
    earned: f64,
    course: Course,
    /// Whether it ends at its goal.
    arrived: bool,
}

/// Whether nothing is to be gained beside `earned`: the best place is near.
pub(super) fn is_enough(goals: &[Goal], earned: f64, steps: usize) -> bool {
    // What an end pays is not known before it was reached.
    let stays = goals.first().filter(|_| goals.iter().all(|goal| !goal.ends));
    let most = stays.map_or(f64::INFINITY, |goal| goal.pay * steps as f64);
    most.is_finite() && earned >= most - NOTHING * most.abs()
}

impl Found {
    /// Guesses ways to each goal, longer and longer ones, until longer ones earn no more; then some that are a little shorter than the best.
    fn guess(&mut self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize, numbers: Range<usize>) {
        let (mut length, mut without) = ((SHORTEST / plant.pace).max(2.0), 0);
        while without < ENOUGH && 2.0 * length <= steps as f64 && !plant.stopped() {
            let gained = self.guess_of(length as usize, plant, goals, x, steps, numbers.clone());
            without = if gained || !self.arrived { 0 } else { without + 1 };
            length = (LONGER * length).max(length + 1.0);
        }
        let planned = self.course.plan.as_ref().filter(|_| self.arrived).map_or(0, |plan| plan.u.len());
        for shorter in 1..=SHORTER_TRIED {
            let length = (planned as f64 / SHORTER.powi(shorter)) as usize;
            if length > 1 && !plant.stopped() {
                self.guess_of(length, plant, goals, x, steps, numbers.clone());
            }
        }
    }

    /// Guesses ways of `length` steps to each goal; whether one of them earns more.
    fn guess_of(
        &mut self,
        length: usize,
        plant: &Plant,
        goals: &[Goal],
        x: &[f64],
        steps: usize,
        numbers: Range<usize>,
    ) -> bool {
        let all = (0..goals.len()).flat_map(|goal| numbers.clone().map(move |number| (goal, number)));
        let all: Vec<(usize, usize)> = all.collect();
        let close = |&(goal, number): &(usize, usize)| {
            let objective = Objective { reward: 0.0, width: 0.0, effort: EFFORT, end: Some((&goals[goal], 1.0)) };
            let states = guess::between(plant, x, &goals[goal], length, number);
            let plan = Plan::through(plant, &objective, states, vec![plant.middle(); length])?;
            Some((goal, plan.improved(plant, &objective, CLOSING)))
        };
        let mut closed: Vec<(usize, Plan)> = all.par_iter().filter_map(close).collect();
        closed.retain(|(_, plan)| plan.is_closed());
        closed.sort_by(|(_, one), (_, other)| one.cost.total_cmp(&other.cost));
        closed.truncate(all.len().div_ceil(KEPT));
        let tries = closed.into_iter().map(|(goal, plan)| Try::Closed { goal, plan });
        self.better(plant, goals, x, steps, tries.collect())
    }

    /// Looks at all ways through cells so many scales wide.
    fn look(&mut self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize, width: f64) {
        let mut front = Front::new(plant, goals, x, width);
        let mut reached = vec![f64::INFINITY; goals.len()];
        let mut without = 0;
        while without < PATIENCE && front.length() < steps && front.advance() {
            let mut tries = Vec::new();
            for (goal, (place, reached)) in goals.iter().zip(&mut reached).enumerate() {
                for (distance, controls) in front.nearest(place, NEAREST, FARTHER * *reached) {
                    *reached = reached.min(distance);
                    tries.push(Try::Led { goal: Some(goal), controls });
                }
            }
            tries.extend(front.richest(true).map(|controls| Try::Led { goal: None, controls }));
            let gained = self.better(plant, goals, x, steps, tries);
            without = if gained || !self.arrived { 0 } else { without + 1 };
        }
        if !self.arrived {
            let tries = front.richest(false).map(|controls| Try::Led { goal: None, controls });
            self.better(plant, goals, x, steps, tries.into_iter().collect());
        }
    }

    /// Takes the best of `tries` if it earns more; whether it does.
    fn better(&mut self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize, tries: Vec<Try>) -> bool {
        let made = |one: &Try| {
            let course = one.made(plant, goals, x)?;
            let (earned, _, last) = course.run(plant, goals, x, steps);
            let arrived = match (course.goal, last) {
                (Some(goal), Some(last)) => goals[goal].distance(&last) < ARRIVED,
                // An end that was looked for.
                (None, None) => course.plan.is_some(),
                _ => false,
            };
            Some(Self { earned, course, arrived })
        };
        let found: Vec<Self> = tries.par_iter().filter_map(made).collect();
        let mut gained = false;
        for found in found {
            if found.earned > self.earned {
                (*self, gained) = (found, true);
            }
        }
        gained
    }

    /// Goes the same way to its goal faster, as long as that earns more.
    fn shorten(&mut self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) {
        let mut part = 0;
        while self.arrived && self.course.goal.is_some() && part <= PARTS.len() {
            let whole = self.course.length(plant, goals, x, steps);
            let length = PARTS.get(part).map_or(whole.saturating_sub(1), |part| (part * whole as f64) as usize);
            let way = self.course.earns(plant, goals, x, whole).1;
            if length == 0 || way.is_empty() {
                return;
            }
            let faster = |t: usize| way[(t * whole / length).min(way.len() - 1)].clone();
            let one = Try::Led { goal: self.course.goal, controls: (0..length).map(faster).collect() };
            part = if self.better(plant, goals, x, steps, vec![one]) { 0 } else { part + 1 };
        }
    }
}

/// A way to be tried.
enum Try {
    /// No way: only this is held.
    Held(Option<usize>),
    /// Controls that lead near a goal.
    Led { goal: Option<usize>, controls: Vec<Vec<f64>> },
    /// A plan that ends somewhere near a goal.
    Closed { goal: usize, plan: Plan },
}

impl Try {
    fn made(&self, plant: &Plant, goals: &[Goal], x: &[f64]) -> Option<Course> {
        let objective = |goal: Option<usize>| Objective {
            reward: 0.0,
            width: 0.0,
            effort: EFFORT,
            end: goal.map(|goal| (&goals[goal], 1.0)),
        };
        match self {
            Self::Held(goal) => Some(Course { plan: None, made: 0, goal: *goal }),
            Self::Led { goal, controls } => {
                let objective = objective(*goal);
                let plan = Plan::of(plant, &objective, x, controls.clone())?;
                let plan = if goal.is_some() { plan.improved(plant, &objective, ITERATIONS) } else { plan };
                Some(Course { plan: Some(plan), made: 0, goal: *goal })
            }
            Self::Closed { goal, plan } => {
                let plan = plan.clone().improved(plant, &objective(Some(*goal)), ARRIVING);
                Some(Course { plan: Some(plan), made: 0, goal: Some(*goal) })
            }
        }
    }
}
