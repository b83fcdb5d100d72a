//! `sources`: what the case says about where its values come from.

use serde_json::Value;

use super::error::{CaseError, describe, nearest, quote};
use super::pointer::{escape, is_at_or_below};
use super::table;

/// Refuses a source that is no text or whose pointer names nothing; `base` is where `document` stands in a case.
pub(super) fn check(sources: &Value, base: &str, document: &Value) -> Result<(), CaseError> {
    let Value::Object(sources) = sources else {
        return Err(CaseError::at("/sources", "an object of JSON pointers and texts", describe(sources)));
    };
    for (pointer, text) in sources {
        let location = format!("/sources/{}", escape(pointer));
        if !text.is_string() {
            return Err(CaseError::at(location, "text", describe(text)));
        }
        let known = table::lookup(&format!("{base}{pointer}")).is_some() || document.pointer(pointer).is_some();
        if !known {
            let pointers: Vec<String> = table::pointers();
            let inside = pointers.iter().filter(|known| is_at_or_below(known, base)).map(|known| &known[base.len()..]);
            let error = CaseError::at(location, "the JSON pointer of a field", quote(pointer));
            return Err(match nearest(pointer, inside.filter(|pointer| !pointer.is_empty())) {
                Some(near) => error.help(format!("did you mean {}?", quote(near))),
                None => error,
            });
        }
    }
    Ok(())
}
