//! `--set /json/pointer=value`: one change to the document.

use serde_json::{Map, Value, json};
use twox_hash::XxHash3_64;

use super::error::{CaseError, describe, index, is_at_or_below, nearest, quote, text_of, unescape};
use super::fabric_file::{around, holds_fabrics, make_own};
use super::keys::{Key, lookup, object, pointers};
use super::provenance::is_assumed;
use super::read;

/// The source of what a user changes on the command line, and the first word of the place of its errors.
pub(super) const FLAG: &str = "--set";
/// Values longer than this stand in names as a hash [characters].
const LONGEST_VALUE: usize = 24;
/// Names of changes longer than this become a hash [characters].
const LONGEST_NAME: usize = 100;

/// One change: the pointer and the value it gets.
pub(super) struct Set {
    pub(super) pointer: String,
    value: Value,
}

/// Reads `/json/pointer=value`; a value that is not JSON is a word.
pub(super) fn parse(text: &str) -> Result<Set, CaseError> {
    let help = "for example --set /projectile/velocity_m_s=200";
    let form = |found: String| CaseError::at(located(text), "/json/pointer=value", found).help(help);
    let Some((pointer, value)) = text.split_once('=') else {
        return Err(form(format!("{}, which has no =", quote(text))));
    };
    if !is_pointer(pointer) {
        return Err(form(format!("the pointer {}", quote(pointer))));
    }
    if value.trim().is_empty() {
        return Err(CaseError::at(located(pointer), "a value after =", "nothing").help(help));
    }
    match read::parse(value) {
        Ok(value) => Set::new(pointer, value),
        Err(error) if value.trim_start().starts_with(['{', '[', '"']) => {
            let found = format!("{} ({})", error.found, error.location);
            Err(CaseError { location: located(pointer), found, ..error })
        }
        Err(_) => Set::new(pointer, Value::from(value.trim())),
    }
}

/// Whether a text can be a pointer to a key.
fn is_pointer(text: &str) -> bool {
    text.starts_with('/') && !text.ends_with('/') && !text.contains("//")
}

fn located(pointer: &str) -> String {
    let short: String = pointer.chars().filter(|c| !c.is_control()).take(200).collect();
    format!("{FLAG} {short}")
}

/// Names the change as the place of an error that it caused.
pub(super) fn attribute(mut error: CaseError, sets: &[Set]) -> CaseError {
    if error.file.is_empty() && sets.iter().any(|set| is_at_or_below(&error.location, &set.pointer)) {
        error.location = located(&error.location);
    }
    error
}

impl Set {
    /// A change to a value that is at hand.
    pub(super) fn new(pointer: &str, value: Value) -> Result<Self, CaseError> {
        if !is_pointer(pointer) {
            let expected = "a JSON pointer, for example /projectile/velocity_m_s";
            return Err(CaseError::at(located(pointer), expected, quote(pointer)));
        }
        // Another file replaces a fabric whole, written out in the case or not.
        Ok(match pointer.strip_suffix("/file").filter(|place| around(place) == Some(place)) {
            Some(place) => Self { pointer: place.to_owned(), value: json!({"file": value}) },
            None => Self { pointer: pointer.to_owned(), value },
        })
    }

    /// Whether the change decides which fabrics there are, so that it comes before fabric files are read.
    pub(super) fn chooses_fabric(&self) -> bool {
        let with_layup = self.pointer == "/pack" && self.value.get("layup").is_some();
        self.is_fabric() || holds_fabrics(&self.pointer) || with_layup
    }

    fn is_fabric(&self) -> bool {
        around(&self.pointer) == Some(self.pointer.as_str())
    }

    /// Makes the change; `by` is the source of the new value.
    pub(super) fn apply(&self, document: &mut Value, by: &str) -> Result<(), CaseError> {
        self.put(document)?;
        self.renew_sources(document, by);
        Ok(())
    }

    /// Puts the value in its place, creating objects that the case file knows.
    pub(super) fn put(&self, document: &mut Value) -> Result<(), CaseError> {
        if let Some(place) = around(&self.pointer).filter(|place| *place != self.pointer) {
            make_own(document, place);
        }
        let Some((parents, last)) = self.pointer.rsplit_once('/') else { return Ok(()) };
        let (mut node, mut place) = (document, String::new());
        for part in parents.split('/').skip(1) {
            let next = format!("{place}/{part}");
            let above = std::mem::replace(&mut place, next);
            node = match node {
                Value::Object(map) => child(map, &unescape(part), &place)?,
                Value::Array(items) => item(items, part, &place)?,
                other => return Err(no_children(&above, Some(other))),
            };
        }
        match node {
            Value::Object(map) => drop(map.insert(unescape(last), self.value.clone())),
            Value::Array(items) => *item(items, last, &self.pointer)? = self.value.clone(),
            other => return Err(no_children(&place, Some(other))),
        }
        Ok(())
    }

    /// Drops what the case says about the old value: it does not hold for the new one.
    fn renew_sources(&self, document: &mut Value, by: &str) {
        if ["/title", "/notes", "/expect", "/sources"].iter().any(|above| is_at_or_below(&self.pointer, above)) {
            return;
        }
        let Some(sources) = sources(document) else { return };
        let covering = sources.iter().filter(|(above, _)| is_at_or_below(&self.pointer, above));
        let nearest = covering.max_by_key(|(above, _)| above.len()).and_then(|(_, text)| text.as_str());
        let text = if nearest.is_some_and(is_assumed) { format!("assumed, {by}") } else { by.to_owned() };
        sources.retain(|pointer, _| !is_at_or_below(pointer, &self.pointer));
        // A fabric's file brings its own sources.
        if !(self.is_fabric() && self.value.get("file").is_some()) {
            sources.insert(self.pointer.clone(), Value::from(text));
        }
    }
}

/// The sources of a document; `None` where they are no object.
pub(super) fn sources(document: &mut Value) -> Option<&mut Map<String, Value>> {
    document.as_object_mut()?.entry("sources").or_insert_with(|| json!({})).as_object_mut()
}

/// Value at a key, created where the case file knows it: an object, or the default list.
fn child<'a>(map: &'a mut Map<String, Value>, name: &str, place: &str) -> Result<&'a mut Value, CaseError> {
    if map.get(name).is_none_or(Value::is_null) {
        let Some(Key { node, .. }) = lookup(place) else {
            let known = pointers();
            let error =
                CaseError::at(located(place), "a pointer into the case", format!("nothing at {}", quote(place)));
            return Err(match nearest(place, known.iter().map(String::as_str)) {
                Some(near) => error.help(format!("did you mean {near}?")),
                None => error,
            });
        };
        let created = match &node["default"] {
            list @ Value::Array(_) => list.clone(),
            _ if node["type"] != "array"
                && index(name).is_none()
                && (node["type"] == "object" || object(node).is_some()) =>
            {
                json!({})
            }
            _ => return Err(no_children(place, map.get(name))),
        };
        map.insert(name.to_owned(), created);
    }
    Ok(map.entry(name).or_insert(Value::Null))
}

fn item<'a>(items: &'a mut [Value], part: &str, place: &str) -> Result<&'a mut Value, CaseError> {
    let expected = match items.len() {
        0 => "another pointer: the list is empty".to_owned(),
        count => format!("an index from 0 to {}", count - 1),
    };
    let error = CaseError::at(located(place), expected, quote(part));
    index(part).and_then(|index| items.get_mut(index)).ok_or(error)
}

fn no_children(place: &str, found: Option<&Value>) -> CaseError {
    let found = found.map_or_else(|| "nothing".to_owned(), describe);
    CaseError::at(located(place), format!("an object or a list at {place}"), found)
        .help(format!("set {place} as a whole"))
}

/// The changes that make another shot of a case, each key's last one: its name and itself.
fn differences(sets: &[Set]) -> Vec<(String, &Set)> {
    let same_shot = ["/$schema", "/title", "/notes", "/expect", "/sources", "/output"];
    let last = |(index, set): &(usize, &Set)| !sets[index + 1..].iter().any(|later| later.pointer == set.pointer);
    let kept = sets.iter().enumerate().filter(last).map(|(_, set)| set);
    let kept = kept.filter(|set| !same_shot.iter().any(|above| is_at_or_below(&set.pointer, above)));
    kept.map(|set| (short_name(&set.pointer), set)).collect()
}

/// The last part of a pointer, with the one before it where other keys end alike.
fn short_name(pointer: &str) -> String {
    let last = pointer.rsplit('/').next().unwrap_or_default();
    let alike = pointers().iter().filter(|known| known.rsplit('/').next() == Some(last)).count();
    let parts = if alike <= 1 && lookup(pointer).is_some() && index(last).is_none() { 1 } else { 2 };
    let mut parts: Vec<&str> = pointer.rsplit('/').take(parts).filter(|part| !part.is_empty()).collect();
    parts.reverse();
    parts.join(".")
}

/// Changes for the title: empty, or `velocity_m_s = 200, …` in brackets.
pub(super) fn in_title(sets: &[Set]) -> String {
    let changes = differences(sets).into_iter().map(|(name, set)| format!("{name} = {}", text_of(&set.value)));
    let changes: Vec<String> = changes.collect();
    if changes.is_empty() { String::new() } else { format!(" [{}]", changes.join(", ")) }
}

/// Changes for the name of a folder: empty, or `+velocity_m_s=200…`; any file system takes it.
pub(super) fn in_name(sets: &[Set]) -> String {
    let hash = |text: &str| (XxHash3_64::oneshot(text.as_bytes()) >> 32) as u32;
    let plain = |c: char, more: &str| c.is_ascii_alphanumeric() || more.contains(c);
    let change = |(name, set): &(String, &Set)| {
        let value = text_of(&set.value);
        let name: String = name.chars().map(|c| if plain(c, "._") { c } else { '_' }).collect();
        match value.chars().count() <= LONGEST_VALUE && value.chars().all(|c| plain(c, ".-_")) {
            true => format!("+{name}={value}"),
            false => format!("+{name}={:08x}", hash(&set.value.to_string())),
        }
    };
    let changes = differences(sets);
    let whole: String = changes.iter().map(change).collect();
    if whole.len() <= LONGEST_NAME { whole } else { format!("+{}-changes-{:08x}", changes.len(), hash(&whole)) }
}
