//! Ctrl-C during long calls.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(20);

/// Stack of a thread that works, as large as that of a main thread.
const STACK: usize = 8 << 20;

/// Whether work is to stop.
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Whether it is.
    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// What tells it, for work that looks by itself.
    pub(crate) fn flag(&self) -> &Arc<AtomicBool> {
        &self.0
    }
}

/// The result of `work`, done by a thread of its own without the interpreter's lock. If a signal's handler raises an exception meanwhile, that is
/// the result at once; `work`, which is asked to stop, ends when it looks at what it is given.
///
/// # Errors
/// The exception raised; [`PyRuntimeError`] if `work` panics or no thread can be had.
pub(crate) fn apart<T: Send + 'static>(py: Python<'_>, work: impl FnOnce(&Stop) -> T + Send + 'static) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let (send, receive) = channel();
    let asked = Stop(Arc::clone(&stop));
    let worker = move || {
        // Nobody waits for the result of what was stopped.
        let _ = send.send(work(&asked));
    };
    let failed = |e: std::io::Error| PyRuntimeError::new_err(format!("no thread could be started: {e}"));
    Builder::new().name("sindyna".into()).stack_size(STACK).spawn(worker).map_err(failed)?;
    py.detach(move || {
        loop {
            match receive.recv_timeout(PERIOD) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(raised) = Python::attach(|py| py.check_signals()) {
                        stop.store(true, Ordering::Relaxed);
                        return Err(raised);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err(
                        "the engine failed; this is a fault of sindyna, please report it",
                    ));
                }
            }
        }
    })
}

/// Looks for signals now and then, for work that is done by the calling thread without the interpreter's lock.
#[derive(Debug)]
pub(crate) struct Look(Cell<Instant>);

impl Look {
    pub(crate) fn new() -> Self {
        Self(Cell::new(Instant::now()))
    }

    /// # Errors
    /// The exception that a signal's handler raised.
    pub(crate) fn check(&self) -> PyResult<()> {
        if self.0.get().elapsed() < PERIOD {
            return Ok(());
        }
        let checked = Python::attach(|py| py.check_signals());
        self.0.set(Instant::now());
        checked
    }
}
