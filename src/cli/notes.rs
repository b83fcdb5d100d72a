//! What a user should know before a run: what was chosen, and what was accepted but does nothing yet.

use ripstop::case::Case;

use super::arguments::Backend;

/// One line each.
pub(crate) fn notes(case: &Case, backend: Backend) -> Vec<String> {
    let mut notes = Vec::new();
    if backend == Backend::Auto {
        notes.push("note: --backend auto takes the CPU: this version has no GPU backend".to_owned());
    }
    if case.output.frames > 0 {
        notes.push(format!("note: /output/frames = {}: frames are not written by this version", case.output.frames));
    }
    notes
}
