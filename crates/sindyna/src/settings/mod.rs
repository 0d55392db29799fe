//! Settings of a run, as `config.toml` has them.

mod check;
mod choices;
mod identification;
mod overrides;
mod train;

pub(crate) use check::check_episodes;
pub(crate) use choices::{
    ControllerName, CoordinatesName, ExplorerName, ImaginedRollouts, IsaName, LibraryName, PrecisionName,
    SimulatorName, SolverName, TargetName,
};
pub(crate) use identification::IdentificationConfig;
pub(crate) use overrides::key;
pub(crate) use train::{DataConfig, TrainConfig, agent};
