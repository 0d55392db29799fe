//! sindyna beside its peers in Python, in turn on one core: ratios of neighbours in time, since what else the machine does cancels in them.
//!
//! What a peer does is in `benches/peers`, which is run by the Python that `scripts/peers_install` makes. Each measurement writes its file in results; the program
//! `performance` makes the page.

mod ask;
mod baselines;
mod speed;
mod whole_job;

use clap::{Parser, Subcommand};
use sindyna_bench::study::Result;

#[derive(Debug, Parser)]
struct Options {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// From nothing to a policy that solves the task, beside PySINDy with an agent of Stable-Baselines3 or SBX
    WholeJob(whole_job::Options),
    /// Updates of SAC beside SBX's scan, Stable-Baselines3's, and the matrix products of an update by other libraries
    Updates(speed::Options),
    /// Training of an ensemble of networks beside PyTorch's
    Ensemble(speed::Options),
    /// A step of the learned model beside PySINDy's predict and the step of Gymnasium's environment
    ModelSteps(speed::Options),
    /// Our model-free baseline beside Stable-Baselines3's SAC with the same settings
    Baselines(baselines::Options),
}

fn main() -> Result {
    match Options::parse().what {
        What::WholeJob(options) => whole_job::measure(&options),
        What::Updates(options) => speed::updates(&options),
        What::Ensemble(options) => speed::ensemble(&options),
        What::ModelSteps(options) => speed::model_steps(&options),
        What::Baselines(options) => baselines::measure(&options),
    }
}
