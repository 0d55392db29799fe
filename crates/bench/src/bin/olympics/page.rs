//! results/olympics.json and docs/olympics.md.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, count, median, short};

use super::score::Score;

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    pub(crate) published: Vec<Published>,
    pub(crate) swings: Vec<Swing>,
}

/// The published run of the best controller of a board.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Published {
    pub(crate) robot: String,
    /// Its score, computed again.
    pub(crate) score: Score,
}

/// One log, and the swing-up that was planned in its equations.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Swing {
    pub(crate) robot: String,
    pub(crate) seed: u64,
    /// Whether all equations are called adequate.
    pub(crate) adequate: bool,
    pub(crate) identification_seconds: f64,
    pub(crate) planning_seconds: f64,
    pub(crate) score: Score,
}

/// docs/olympics.md.
pub(crate) fn page(document: &Document<Figures>, out: &str) -> Result<String> {
    let Figures { published, swings } = &document.figures;
    let cells = |name: &str, score: &Score| {
        let Score { time, energy, torque, smoothness, velocity, score } = *score;
        let numbers = [time, energy, torque, smoothness, velocity].map(|v| short(Some(v)));
        std::iter::once(name.to_owned()).chain(numbers).chain([format!("{score:.3}")]).collect::<Vec<String>>()
    };
    let head = ["", "time [s]", "energy [J]", "torque [N²m²s]", "smoothness [Nm]", "velocity [rad²/s]", "score"];
    let mut page = Page::new("AI Olympics: simulation boards")
        .text("A double pendulum whose elbow (acrobot) or shoulder (pendubot) is driven swings up from rest in a simulator and stays there for ten seconds. Controllers on the public boards know its equations or train in its simulator. Here they are found in 101 samples, two seconds at 50 Hz with the noise of the real machine (0.001 rad, 0.1 rad/s), and differential dynamic programming plans in them.");
    for best in published {
        let own: Vec<&Swing> = swings.iter().filter(|swing| swing.robot == best.robot).collect();
        let above = count(own.iter().copied(), |swing: &Swing| swing.score.score > best.score.score);
        let adequate = count(own.iter().copied(), |swing: &Swing| swing.adequate);
        let seconds = |of: &dyn Fn(&Swing) -> f64| short(median(own.iter().map(|swing| of(swing))));
        let rows = std::iter::once(cells("best on the board (History-SAC), scored again", &best.score)).chain(
            own.iter().map(|swing| {
                let doubt = if swing.adequate { "" } else { " (not called adequate)" };
                cells(&format!("log {}{doubt}", swing.seed), &swing.score)
            }),
        );
        page = page
            .section(if best.robot == "acrobot" { "Acrobot" } else { "Pendubot" })
            .list([
                format!("Scores above the best of the board: {above} of {} logs.", own.len()),
                format!("Equations called adequate: {adequate} of {}.", own.len()),
                format!(
                    "Median wall times: {} s for the equations, {} s for the plan.",
                    seconds(&|swing| swing.identification_seconds),
                    seconds(&|swing| swing.planning_seconds)
                ),
            ])
            .table(&head, rows);
    }
    Ok(page
        .section("How it was measured")
        .text("Plant, parameters and score are those of the boards, version 2 (Wiebe et al. 2024): Runge–Kutta steps of 0.002 s, torque limit 6 N m, no friction; score 1 − mean of tanh(π c/n) over the five criteria, n = 20, 60, 20, 0.1, 400, and 0 for a pendulum that does not stay above 0.45 m. The published run of the best controller of each board (crates/bench/data/olympics, rounded to seven digits) is scored again by the same code; the published scores are 0.655 and 0.682.")
        .text("In the log the driven joint is pushed to either side by up to 5 N m, 0.12 to 0.16 s each. `sindyna identify` is told that the positions are angles and that inputs are not late (`--angles q1,q2 --delay 0`). The planner is told the limit of the torque and, for the height of the tip, the lengths of the links. It chooses the rate of the torque every 0.01 s. Its rewards are the slopes of the score near what a swing-up of a second comes to, a run that is never up costing the whole score; the course that it finds is then improved three times for the slopes of the score where it comes to, in the equations. Measurements in the swing-up are exact, as on the boards. The boards' robustness tests were not run.")
        .text(&document.made.origin(out))
        .markdown())
}
