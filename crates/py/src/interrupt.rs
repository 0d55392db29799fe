//! Ctrl-C during long calls.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(30);

/// Looks for signals now and then, and keeps the exception that a handler raised.
#[derive(Debug)]
pub(crate) struct Interrupt {
    looked: Cell<Instant>,
    raised: RefCell<Option<PyErr>>,
}

impl Interrupt {
    pub(crate) fn new() -> Self {
        Self { looked: Cell::new(Instant::now()), raised: RefCell::new(None) }
    }

    /// Whether to go on; called often, by the thread that called from Python, without the interpreter's lock.
    pub(crate) fn go_on(&self) -> bool {
        if self.raised.borrow().is_some() {
            return false;
        }
        if self.looked.get().elapsed() < PERIOD {
            return true;
        }
        let raised = Python::attach(|py| py.check_signals().err());
        self.looked.set(Instant::now());
        let go_on = raised.is_none();
        *self.raised.borrow_mut() = raised;
        go_on
    }

    /// The exception raised, if any; else the result.
    pub(crate) fn or<T>(self, result: PyResult<T>) -> PyResult<T> {
        self.raised.into_inner().map_or(result, Err)
    }
}
