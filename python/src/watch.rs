//! Work beside the interpreter: it runs on a thread of its own without the interpreter's lock, while the caller's thread looks for
//! Ctrl-C and shows progress.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use crate::RunError;

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(100);

/// Progress and interrupt of work under way.
#[derive(Default)]
pub(crate) struct Watch {
    latest: Mutex<Option<Value>>,
    /// Raised: the work ends as soon as it can.
    pub(crate) interrupt: AtomicBool,
}

impl Watch {
    /// Takes note of progress, an object of numbers.
    pub(crate) fn progress(&self, at: Value) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(at);
    }

    fn look(&self, py: Python<'_>, show: Option<&Py<PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let (Some(show), Some(Value::Object(numbers))) = (show, latest) else { return Ok(()) };
        let at = PyDict::new(py);
        numbers.iter().try_for_each(|(name, number)| at.set_item(name, number.as_f64()))?;
        show.call1(py, (at,)).map(drop)
    }
}

/// Result of the work, and the exception that a signal or `show` raised meanwhile, which ended it early.
///
/// # Errors
/// When the work panics.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    show: Option<Py<PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let (done, raised) = py.detach(|| {
        let watch = Watch::default();
        let (ended, wait) = channel::<()>();
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let _ended = ended; // dropped with the end of the work, by a panic too
                work(&watch)
            });
            let mut raised = None;
            while wait.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if raised.is_none() {
                    raised = Python::attach(|py| watch.look(py, show.as_ref())).err();
                }
                if raised.is_some() {
                    watch.interrupt.store(true, Ordering::Relaxed);
                }
            }
            (worker.join(), raised)
        })
    });
    let done = done
        .map_err(|_| RunError::new_err("error: a defect in ripstop ended the work; its words are on standard error"));
    Ok((done?, raised))
}
