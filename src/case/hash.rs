//! What a case computes, in one number.

use serde_json::Value;

/// Keys of a case that say nothing about what it computes.
pub(crate) const CASE_WORDS: [&str; 5] = ["$schema", "title", "sources", "notes", "expect"];

/// Fingerprint of what a case computes: 64-bit FNV-1a of the case as run, with keys sorted and numbers in one form,
/// without the words around it (title, sources, notes) and what is expected of it.
pub fn case_hash(as_run: &Value) -> String {
    let mut text = String::new();
    match as_run.as_object() {
        Some(map) => object_text(map.iter().filter(|(key, _)| !CASE_WORDS.contains(&key.as_str())), &mut text),
        None => canonical(as_run, &mut text),
    }
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, mix))
}

fn canonical(value: &Value, text: &mut String) {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(number) => *text += &format!("{number:?}"),
            None => *text += &number.to_string(),
        },
        Value::Array(items) => {
            text.push('[');
            for item in items {
                canonical(item, text);
                text.push(',');
            }
            text.push(']');
        }
        Value::Object(map) => object_text(map, text),
        other => *text += &other.to_string(),
    }
}

fn object_text<'a>(entries: impl IntoIterator<Item = (&'a String, &'a Value)>, text: &mut String) {
    let mut entries: Vec<_> = entries.into_iter().collect();
    entries.sort_by_key(|(key, _)| *key);
    text.push('{');
    for (key, value) in entries {
        *text += &format!("{key:?}:");
        canonical(value, text);
        text.push(',');
    }
    text.push('}');
}

#[cfg(test)]
#[path = "hash_tests.rs"]
mod tests;
