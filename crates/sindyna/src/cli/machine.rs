//! What machine a run was timed on.

/// Processor and number of cores, as far as the system tells.
pub(crate) fn describe() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim()));
    let model = model.unwrap_or(std::env::consts::ARCH);
    format!("{model}, {cores} core{}", if cores == 1 { "" } else { "s" })
}
