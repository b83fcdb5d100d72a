//! JSON pointers: `/fabric/warp/crimp`.

/// Whether `pointer` is `above` or something inside it.
pub(super) fn is_at_or_below(pointer: &str, above: &str) -> bool {
    pointer.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// The index that a part of a pointer stands for: digits without a leading zero.
pub(super) fn index(part: &str) -> Option<usize> {
    let canonical = part == "0" || part.starts_with(|c: char| ('1'..='9').contains(&c));
    part.parse().ok().filter(|_| canonical)
}

/// A key as part of a JSON pointer.
pub(crate) fn escape(key: &str) -> String {
    let short: String = key.chars().take(200).collect();
    short.replace('~', "~0").replace('/', "~1").chars().flat_map(shown).collect()
}

/// Control characters in escaped form: an error is one line per part.
fn shown(c: char) -> Vec<char> {
    if c.is_control() { c.escape_default().collect() } else { vec![c] }
}

/// A part of a JSON pointer as the key it stands for.
pub(super) fn unescape(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
}
