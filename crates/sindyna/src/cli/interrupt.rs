//! Ctrl-C: the first asks the run to finish its record, the second ends the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::cli::failure::Failure;

/// Exit code of a run stopped by Ctrl-C.
pub(crate) const EXIT_INTERRUPTED: u8 = 130;

/// Signals that stop a run.
#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// Whether Ctrl-C was pressed.
#[derive(Debug, Clone, Default)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens for Ctrl-C (and SIGTERM, and a terminal that is closed) from now on; but not for what whoever started the program
    /// wants ignored, as `nohup` does.
    pub(crate) fn listen() -> Result<Self, Failure> {
        let pressed = Arc::new(AtomicBool::new(false));
        let ignored = ignored();
        for signal in SIGNALS.into_iter().filter(|signal| ignored & bit(*signal) == 0) {
            // In this order: the first signal finds the flag unset, and sets it.
            flag::register_conditional_shutdown(signal, i32::from(EXIT_INTERRUPTED), pressed.clone())
                .and_then(|_| flag::register(signal, pressed.clone()))
                .context("cannot listen for Ctrl-C")?;
        }
        Ok(Self(pressed))
    }

    /// The flag that is set.
    pub(crate) fn flag(&self) -> Arc<AtomicBool> {
        self.0.clone()
    }

    pub(crate) fn pressed(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

/// The signals that this process was started to ignore, a bit for each; none where Linux is not there to tell.
fn ignored() -> u64 {
    std::fs::read_to_string("/proc/self/status").ok().and_then(|status| ignored_in(&status)).unwrap_or(0)
}

/// What the text of `/proc/self/status` says of ignored signals.
fn ignored_in(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

/// The bit of `signal`; they are counted from 1.
fn bit(signal: i32) -> u64 {
    u32::try_from(signal - 1).ok().and_then(|place| 1_u64.checked_shl(place)).unwrap_or(0)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_their_mask() {
        let mask = ignored_in("Name:\tsindyna\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\n").unwrap();
        assert_eq!([SIGHUP, SIGINT, SIGTERM].map(|signal| mask & bit(signal) != 0), [true, false, false]);
        assert_eq!((ignored_in("Name:\tsindyna\n"), ignored_in("SigIgn:\tno\n")), (None, None));
    }
}
