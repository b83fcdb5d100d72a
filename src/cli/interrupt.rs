//! Ctrl-C: the first one ends the run with complete results, the second ends the program.

use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::failure::{self, CommandFailure};

/// A flag that the first Ctrl-C (or a polite request to terminate) raises.
pub(crate) fn watch() -> Result<Arc<AtomicBool>, CommandFailure> {
    let raised = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&raised);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            process::exit(i32::from(failure::INTERRUPTED));
        }
    })
    .map_err(|error| CommandFailure::input(format!("error: cannot listen for Ctrl-C: {error}")))?;
    Ok(raised)
}
