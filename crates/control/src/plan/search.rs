//! The search for the best way through the rest of an episode: guesses, ways through cells, and what makes the best of them better.

use std::ops::Range;

use rayon::prelude::*;

use super::course::{Course, NOTHING, POLISH, WIDTHS};
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
/// longer ones earn no more; so many `candidates` of them made faster, made smooth and judged by what they earn.
pub(super) fn search(plant: &Plant, goals: &[Goal], x: &[f64], steps: usize, candidates: usize) -> (Course, f64) {
    let none = Found { earned: f64::NEG_INFINITY, course: Course { plan: None, made: 0, goal: None }, arrived: false };
    let mut ways = Ways { plant, goals, x, steps, best: none, others: Vec::new(), guessed: false, longest: steps };
    let held = |goal| Course { plan: None, made: 0, goal };
    ways.better((0..goals.len()).map(Some).chain([None]).map(held).map(Try::Made).collect());
    if is_enough(goals, ways.best.earned, steps) {
        return (ways.best.course, ways.best.earned);
    }
    let waved = |waved: usize| guess::ways(plant) + waved;
    if !ways.best.arrived {
        ways.smooth();
        // A shorter way may yet earn more.
        ways.guess(0..waved(WAVED[0]));
    }
    if !ways.best.arrived {
        ways.guess(waved(WAVED[0])..waved(WAVED[1]));
    }
    for width in CELLS {
        if !ways.best.arrived {
            ways.look(width);
        }
    }
    let found: Vec<Found> = ways.candidates(candidates).into_par_iter().map(|found| ways.shortened(found)).collect();
    let mut courses: Vec<(Course, f64)> = found.into_iter().map(|found| (found.course, found.earned)).collect();
    if courses[0].0.plan.is_none() || !ways.best.arrived {
        // Any goal can be held from here; on the way there a plan may earn more.
        let others = (0..goals.len()).filter(|goal| courses[0].0.goal != Some(*goal)).map(|goal| held(Some(goal)));
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

/// A course that was found.
#[derive(Clone)]
struct Found {
    earned: f64,
    course: Course,
    /// Whether it ends at its goal.
    arrived: bool,
}

/// The search from x over so many steps.
struct Ways<'a> {
    plant: &'a Plant,
    goals: &'a [Goal],
    x: &'a [f64],
    steps: usize,
    best: Found,
    /// Others that arrive.
    others: Vec<Found>,
    /// Whether a way that was guessed arrives, and how long such ways are at most.
    guessed: bool,
    longest: usize,
}

/// Whether nothing is to be gained beside `earned`: the best place is near.
pub(super) fn is_enough(goals: &[Goal], earned: f64, steps: usize) -> bool {
    // What an end pays is not known before it was reached.
    let stays = goals.first().filter(|_| goals.iter().all(|goal| !goal.ends));
    let most = stays.map_or(f64::INFINITY, |goal| goal.pay * steps as f64);
    most.is_finite() && earned >= most - NOTHING * most.abs()
}

impl Ways<'_> {
    /// Improves the best for its reward as it is: where the whole episode is smooth, nothing else need be found.
    fn smooth(&mut self) {
        let (plant, goals, x, steps) = (self.plant, self.goals, self.x, self.steps);
        let course = self.best.course.clone();
        let (course, _) = course.polished(plant, goals, x, steps, self.best.earned, (ITERATIONS, steps, &WIDTHS[..1]));
        self.better(vec![Try::Made(course)]);
        if self.best.arrived {
            self.longest = self.longest.min(self.best.course.reaches(plant, goals, x, steps));
        }
    }

    /// Guesses ways to each goal, longer and longer ones, until longer ones earn no more; then some that are a little shorter than the best.
    fn guess(&mut self, numbers: Range<usize>) {
        let plant = self.plant;
        let (mut length, mut without, mut best) = ((SHORTEST / plant.pace).max(2.0), 0, false);
        while without < ENOUGH && length as usize <= self.longest && !plant.stopped() {
            let gained = self.guess_of(length as usize, numbers.clone());
            best |= gained;
            without = if gained || !self.guessed { 0 } else { without + 1 };
            length = (LONGER * length).max(length + 1.0);
        }
        let planned =
            self.best.course.plan.as_ref().filter(|_| best && self.best.arrived).map_or(0, |plan| plan.u.len());
        for shorter in 1..=SHORTER_TRIED {
            let length = (planned as f64 / SHORTER.powi(shorter)) as usize;
            if length > 1 && !plant.stopped() {
                self.guess_of(length, numbers.clone());
            }
        }
    }

    /// Guesses ways of `length` steps to each goal; whether one of them earns more.
    fn guess_of(&mut self, length: usize, numbers: Range<usize>) -> bool {
        let (plant, goals, x) = (self.plant, self.goals, self.x);
        let all = (0..goals.len()).flat_map(|goal| numbers.clone().map(move |number| (goal, number)));
        let all: Vec<(usize, usize)> = all.collect();
        let close = |&(goal, number): &(usize, usize)| {
            let objective = Objective::way(Some(&goals[goal]));
            let states = guess::between(plant, x, &goals[goal], length, number);
            let plan = Plan::through(plant, &objective, states, vec![plant.middle(); length])?;
            Some((goal, plan.improved(plant, &objective, CLOSING)))
        };
        let mut closed: Vec<(usize, Plan)> = all.par_iter().filter_map(close).collect();
        closed.retain(|(_, plan)| plan.is_closed());
        closed.sort_by(|(_, one), (_, other)| one.cost.total_cmp(&other.cost));
        closed.truncate(all.len().div_ceil(KEPT));
        let tries = closed.into_iter().map(|(goal, plan)| Try::Closed { goal, plan });
        let others = self.others.len();
        let gained = self.better(tries.collect());
        self.guessed |= self.others.len() > others || (gained && self.best.arrived);
        gained
    }

    /// Looks at all ways through cells so many scales wide.
    fn look(&mut self, width: f64) {
        let (plant, goals, x, steps) = (self.plant, self.goals, self.x, self.steps);
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
            let gained = self.better(tries);
            without = if gained || !self.best.arrived { 0 } else { without + 1 };
        }
        if !self.best.arrived {
            let tries = front.richest(false).map(|controls| Try::Led { goal: None, controls });
            self.better(tries.into_iter().collect());
        }
    }

    /// Takes the best of `tries` if it earns more; whether it does.
    fn better(&mut self, tries: Vec<Try>) -> bool {
        let found: Vec<Found> = tries.par_iter().filter_map(|one| self.tried(one)).collect();
        let mut gained = false;
        for mut found in found {
            if found.earned > self.best.earned {
                std::mem::swap(&mut self.best, &mut found);
                gained = true;
            }
            if found.arrived && found.course.plan.is_some() {
                self.others.push(found);
            }
        }
        gained
    }

    fn tried(&self, one: &Try) -> Option<Found> {
        let course = one.made(self.plant, self.goals, self.x)?;
        let run = course.run(self.plant, self.goals, self.x, self.steps);
        let arrived = match (course.goal, one) {
            (Some(goal), _) => run.arrives(&self.goals[goal]),
            // An end that was looked for.
            (None, Try::Led { .. }) if run.last.is_none() => true,
            (None, _) => self.goals.iter().any(|goal| run.arrives(goal)),
        };
        Some(Found { earned: run.earned, course, arrived })
    }

    /// The best, and those that arrive and earn most besides, so many in all.
    fn candidates(&mut self, count: usize) -> Vec<Found> {
        self.others.sort_by(|one, other| other.earned.total_cmp(&one.earned));
        let others = self.others.drain(..).take(count - 1);
        std::iter::once(self.best.clone()).chain(others).collect()
    }

    /// The same way to its goal, made faster as long as that earns more.
    fn shortened(&self, mut found: Found) -> Found {
        let (plant, goals, x, steps) = (self.plant, self.goals, self.x, self.steps);
        let mut part = 0;
        while found.arrived && found.course.goal.is_some() && part <= PARTS.len() {
            let whole = found.course.length(plant, goals, x, steps);
            // Nothing is held after it.
            if whole >= steps {
                break;
            }
            let length = PARTS.get(part).map_or(whole.saturating_sub(1), |part| (part * whole as f64) as usize);
            let way = found.course.earns(plant, goals, x, whole).1;
            if length == 0 || way.is_empty() {
                break;
            }
            let faster = |t: usize| way[(t * whole / length).min(way.len() - 1)].clone();
            let one = Try::Led { goal: found.course.goal, controls: (0..length).map(faster).collect() };
            let faster = self.tried(&one).filter(|faster| faster.earned > found.earned);
            part = if faster.is_some() { 0 } else { part + 1 };
            found = faster.unwrap_or(found);
        }
        found
    }
}

/// A way to be tried.
enum Try {
    /// One that is there already.
    Made(Course),
    /// Controls that lead near a goal.
    Led { goal: Option<usize>, controls: Vec<Vec<f64>> },
    /// A plan that ends somewhere near a goal.
    Closed { goal: usize, plan: Plan },
}

impl Try {
    fn made(&self, plant: &Plant, goals: &[Goal], x: &[f64]) -> Option<Course> {
        let objective = |goal: Option<usize>| Objective::way(goal.map(|goal| &goals[goal]));
        match self {
            Self::Made(course) => Some(course.clone()),
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
