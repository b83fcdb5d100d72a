//! What a user should know before a run: what was chosen, and what was accepted but does nothing yet.

use ripstop::case::Case;

/// One line each.
pub(crate) fn notes(case: &Case) -> Vec<String> {
    let mut notes = Vec::new();
    if case.output.frames > 0 {
        notes.push(format!("note: /output/frames = {}: frames are not written by this version", case.output.frames));
    }
    notes
}
