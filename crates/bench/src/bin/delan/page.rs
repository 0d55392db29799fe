//! results/delan.json and docs/delan.md.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, count, median, short};

/// The largest error that counts as exact [N² m²].
const EXACT: f64 = 1e-20;

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Samples of each log.
    pub(crate) samples: usize,
    pub(crate) runs: Vec<Run>,
}

/// One log.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Run {
    /// The letter; `all` for all of them.
    pub(crate) letter: String,
    /// The row of it at which the log begins.
    pub(crate) from: usize,
    /// Whether the equations are called adequate.
    pub(crate) adequate: bool,
    /// Those of the torques; none if there are no equations, or they cannot be solved for torques.
    pub(crate) errors: Option<Errors>,
    /// Wall time of the command.
    pub(crate) seconds: f64,
}

/// Mean over samples of the squared error of both torques, in all and by what they are for [N² m²].
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Errors {
    pub(crate) torque: f64,
    pub(crate) inertial: f64,
    pub(crate) coriolis: f64,
    pub(crate) gravity: f64,
}

impl Errors {
    fn all(self) -> [f64; 4] {
        [self.torque, self.inertial, self.coriolis, self.gravity]
    }
}

impl Run {
    fn is_exact(&self) -> bool {
        self.errors.is_some_and(|errors| errors.all().iter().all(|error| *error <= EXACT))
    }
}

/// docs/delan.md.
pub(crate) fn page(document: &Document<Figures>) -> Result<String> {
    let Figures { samples, runs } = &document.figures;
    let (few, all): (Vec<&Run>, Vec<&Run>) = runs.iter().partition(|run| run.letter != "all");
    let exact = |runs: &[&Run]| count(runs.iter().copied(), Run::is_exact);
    let wrong = runs.iter().filter(|run| run.adequate && !run.is_exact()).count();
    let worst =
        |at: usize, runs: &[&Run]| runs.iter().filter_map(|run| run.errors).map(|e| e.all()[at]).max_by(f64::total_cmp);
    let middle = |at: usize, runs: &[&Run]| median(runs.iter().filter_map(|run| run.errors).map(|e| e.all()[at]));
    let row = |name: &str, of: &dyn Fn(usize) -> Option<f64>| {
        std::iter::once(name.to_owned()).chain((0..4).map(|at| short(of(at)))).collect::<Vec<String>>()
    };
    let rows = vec![
        row(&format!("{samples} samples, median of {} logs", few.len()), &|at| middle(at, &few)),
        row(&format!("{samples} samples, largest of {} logs", few.len()), &|at| worst(at, &few)),
        row("all 2,459 samples", &|at| worst(at, &all)),
        ["DeLaN, as printed (2,459 samples)", "4.3e-4", "7.3e-4", "2.2e-4", "7.3e-4"].map(str::to_owned).to_vec(),
    ];
    let seconds = short(median(few.iter().map(|run| run.seconds)));
    Ok(Page::new("Letters of a planar arm")
        .text("Equations of an arm with two joints from samples of angles, rates, accelerations and torques, and the torques that they give for three other letters. The structure is found: nothing is declared but the names of the columns.")
        .list([
            format!("All four errors are at most 1e-20 with {} of {} logs of {samples} consecutive samples.", exact(&few), few.len()),
            format!("In {wrong} runs the record calls equations adequate that are not exact."),
            format!("Median wall time of the command: {seconds} s."),
        ])
        .table(&["mean squared error [N² m²]", "torque", "inertial", "Coriolis", "gravity"], rows)
        .section("How it was measured")
        .text("Each log is a part of one of 17 letters, a row every 40 ms, and is read by `sindyna identify` without options. The torques are the inverse dynamics of the equations ([`Model::inverse_dynamics`]): those of gravity at rest without acceleration, those of inertia at rest with acceleration, those of Coriolis and centrifugal forces without acceleration, less those of gravity. The figures of Deep Lagrangian Networks are those that its authors print (ICLR 2019); the data are theirs (crates/bench/data/delan).")
        .text(&document.made.origin("delan"))
        .markdown())
}
