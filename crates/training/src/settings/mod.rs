//! Settings of a run, as `config.toml` has them.

mod check;
mod choices;
mod identification;
mod overrides;
mod train;

pub use check::check_episodes;
pub use choices::{
    ControllerName, CoordinatesName, ExplorerName, ImaginedRollouts, IsaName, LibraryName, PrecisionName,
    SimulatorName, SolverName, TargetName,
};
pub use identification::IdentificationConfig;
pub use overrides::key;
pub use train::{DataConfig, RECORDED_LOG, RECORDED_MODELS, TrainConfig, agent};
