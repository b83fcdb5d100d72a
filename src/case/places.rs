//! Where a case has fabrics: `/fabric`, and `/pack/layup/N/fabric` of plies that have their own.

use serde_json::{Map, Value};

use super::pack_keys::MAX_PLIES;
use super::pointer::{index, is_at_or_below};

/// The fabric of every ply that has none of its own.
pub(super) const COMMON: &str = "/fabric";
/// The list of groups of plies.
pub(super) const LAYUP: &str = "/pack/layup";

/// Every place of a document, whether or not a fabric stands there.
pub(super) fn all(document: &Map<String, Value>) -> Vec<String> {
    let layup = document.get("pack").and_then(|pack| pack.get("layup")).and_then(Value::as_array);
    // A longer list will be refused: no need to read its files.
    let count = layup.map_or(0, Vec::len).min(MAX_PLIES as usize);
    let own = (0..count).map(|index| format!("{LAYUP}/{index}{COMMON}"));
    std::iter::once(COMMON.to_owned()).chain(own).collect()
}

/// The place that a pointer names or reaches into.
pub(super) fn around(pointer: &str) -> Option<&str> {
    if is_at_or_below(pointer, COMMON) {
        return Some(COMMON);
    }
    let (group, _) = pointer.strip_prefix(LAYUP)?.strip_prefix('/')?.split_once('/')?;
    let end = LAYUP.len() + 1 + group.len();
    index(group)?;
    is_at_or_below(&pointer[end..], COMMON).then(|| &pointer[..end + COMMON.len()])
}

/// Whether a pointer names the layup or one of its groups.
pub(super) fn holds_places(pointer: &str) -> bool {
    let group = |rest: &str| rest.strip_prefix('/').is_some_and(|group| index(group).is_some());
    pointer.strip_prefix(LAYUP).is_some_and(|rest| rest.is_empty() || group(rest))
}

/// What stands at a pointer.
pub(super) fn get_mut<'a>(document: &'a mut Map<String, Value>, pointer: &str) -> Option<&'a mut Value> {
    let pointer = pointer.strip_prefix('/')?;
    match pointer.split_once('/') {
        Some((top, below)) => document.get_mut(top)?.pointer_mut(&format!("/{below}")),
        None => document.get_mut(pointer),
    }
}

/// Gives the group at `place` a copy of the common fabric, with its sources, where it has no fabric of its own.
pub(super) fn make_own(document: &mut Map<String, Value>, place: &str) {
    let Some(common) = document.get("fabric").cloned() else { return };
    let group = place.strip_suffix(COMMON).unwrap_or_default();
    match get_mut(document, group) {
        Some(Value::Object(group)) if !group.contains_key("fabric") => group.insert("fabric".to_owned(), common),
        _ => return,
    };
    let sources = document.entry("sources").or_insert_with(|| Value::Object(Map::new()));
    let Value::Object(sources) = sources else { return };
    let whole = [COMMON, ""].iter().find_map(|above| sources.get(*above)).cloned();
    let inside = sources.iter().filter_map(|(pointer, text)| Some((pointer.strip_prefix(COMMON)?, text.clone())));
    let inside = inside.filter(|(inside, _)| inside.starts_with('/'));
    let mut copies: Vec<(String, Value)> = inside.map(|(inside, text)| (format!("{place}{inside}"), text)).collect();
    // Else a source of the pack would seem to be one of the fabric.
    copies.push((place.to_owned(), whole.unwrap_or_else(|| Value::from("case file"))));
    for (pointer, text) in copies {
        sources.entry(pointer).or_insert(text);
    }
}

#[cfg(test)]
#[path = "places_tests.rs"]
mod tests;
