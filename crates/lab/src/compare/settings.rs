//! Every setting of a method on a task, for the reader.

use sindyna_core::Spec;
use sindyna_rl::EnsembleConfig;

use super::Method;
use super::presets::{Preset, mbpo, sac};
use crate::config::TrainConfig;
use crate::failure::Failure;

/// The settings of `method` on the task `spec`, a line each; none for methods without any.
pub(crate) fn method_settings(method: Method, spec: &Spec) -> Result<String, Failure> {
    let with_ensemble = |config: EnsembleConfig| Ok::<_, Failure>(outside(&mbpo(spec)) + &toml::to_string(&config)?);
    match method {
        Method::Sindy => inside(spec, &[]),
        // Nothing is identified by who knows the equations.
        Method::Truth => inside(spec, &["identification"]),
        Method::Sac => Ok(outside(&sac(spec, 1))),
        Method::Sac20 => Ok(outside(&sac(spec, 20))),
        Method::Mbpo => with_ensemble(EnsembleConfig::janner()),
        Method::MbpoPaper => with_ensemble(EnsembleConfig::paper()),
        Method::Lqr | Method::Hand | Method::Random => Ok(String::new()),
    }
}

/// The defaults of `sindyna train`, without what is said elsewhere and without the tables `but`.
fn inside(spec: &Spec, but: &[&str]) -> Result<String, Failure> {
    let mut settings = toml::Table::try_from(TrainConfig::defaults(spec))?;
    for key in ["version", "commit", "task", "seed"].iter().chain(but) {
        settings.remove(*key);
    }
    Ok(toml::to_string(&settings)?)
}

/// A preset as the program itself prints it.
fn outside(preset: &Preset) -> String {
    format!("schedule = {:#?}\nsac = {:#?}\n", preset.schedule, preset.sac)
}
