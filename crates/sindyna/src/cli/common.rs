//! What the commands that compute have in common.

use super::failure::Failure;

/// Threads to work with.
const MOST_THREADS: i64 = 1_024;

/// What every long-running command understands.
#[derive(Debug, clap::Args)]
pub(crate) struct Common {
    /// Number of threads; results do not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
}

impl Common {
    /// A thread pool of the size asked for.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        // None given: rayon's own variable counts, but no more than an option could ask for; 0 is all cores.
        let variable = || std::env::var("RAYON_NUM_THREADS").ok()?.parse::<usize>().ok();
        let threads = self.threads.map_or_else(|| variable().unwrap_or(0), usize::from).min(MOST_THREADS as usize);
        Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
    }
}

/// Writes an option that was given over the setting it is for.
pub(crate) fn set<T: Clone>(setting: &mut T, option: &Option<T>) {
    if let Some(value) = option {
        setting.clone_from(value);
    }
}
