//! `--set /json/pointer=value`: one change to the document.

use serde_json::{Map, Value, json};
use twox_hash::XxHash3_64;

use super::error::{CaseError, describe, nearest, quote};
use super::fields::{CaseKey, KeyType, Presence};
use super::places;
use super::pointer::{index, is_at_or_below, unescape};
use super::record::is_assumed;
use super::value::text_of;
use super::{json, table};

/// The source of what a user changes on the command line, and the first word of the place of its errors.
pub(super) const FLAG: &str = "--set";

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
    let pointer = pointer.to_owned();
    if value.trim().is_empty() {
        return Err(CaseError::at(located(&pointer), "a value after =", "nothing").help(help));
    }
    match json::parse(value) {
        Ok(value) => Ok(whole_fabric(Set { pointer, value })),
        Err(error) if value.trim_start().starts_with(['{', '[', '"']) => {
            let found = format!("{} ({})", error.found, error.location);
            Err(CaseError { location: located(&pointer), found, ..error })
        }
        Err(_) => Ok(whole_fabric(Set { pointer, value: Value::from(value.trim()) })),
    }
}

/// Whether a text can be a pointer to a key.
fn is_pointer(text: &str) -> bool {
    text.starts_with('/') && !text.ends_with('/') && !text.contains("//")
}

/// Another file replaces a fabric whole, written out in the case or not.
fn whole_fabric(set: Set) -> Set {
    match set.pointer.strip_suffix("/file") {
        Some(place) if places::around(place) == Some(place) => {
            Set { pointer: place.to_owned(), value: json!({"file": set.value}) }
        }
        _ => set,
    }
}

fn located(pointer: &str) -> String {
    let short: String = pointer.chars().filter(|c| !c.is_control()).take(200).collect();
    format!("{FLAG} {short}")
}

/// Names the change as the place of an error that it caused.
pub(super) fn attribute(mut error: CaseError, sets: &[Set]) -> CaseError {
    let of_case = error.file.is_empty();
    if of_case && sets.iter().any(|set| is_at_or_below(&error.location, &set.pointer)) {
        error.location = located(&error.location);
    }
    error
}

impl Set {
    /// Whether the change decides which fabrics there are, so that it comes before fabric files are read.
    pub(super) fn chooses_fabric(&self) -> bool {
        let with_layup = self.pointer == "/pack" && self.value.get("layup").is_some();
        self.is_fabric() || places::holds_places(&self.pointer) || with_layup
    }

    fn is_fabric(&self) -> bool {
        places::around(&self.pointer) == Some(self.pointer.as_str())
    }

    /// A change to a value that is at hand.
    pub(super) fn new(pointer: &str, value: Value) -> Result<Self, CaseError> {
        if !is_pointer(pointer) {
            let expected = "a JSON pointer, for example /projectile/velocity_m_s";
            return Err(CaseError::at(located(pointer), expected, quote(pointer)));
        }
        Ok(whole_fabric(Self { pointer: pointer.to_owned(), value }))
    }

    /// Makes the change; `by` is the source of the new value.
    pub(super) fn apply(&self, document: &mut Map<String, Value>, by: &str) -> Result<(), CaseError> {
        self.put(document)?;
        self.renew_sources(document, by);
        Ok(())
    }

    /// Puts the value in its place, creating objects that the table knows.
    pub(super) fn put(&self, document: &mut Map<String, Value>) -> Result<(), CaseError> {
        if let Some(place) = places::around(&self.pointer).filter(|place| *place != self.pointer) {
            places::make_own(document, place);
        }
        let parts: Vec<&str> = self.pointer.split('/').skip(1).collect();
        let Some((last, parents)) = parts.split_last() else { return Ok(()) };
        let mut place = String::new();
        let Some((first, rest)) = parents.split_first() else {
            document.insert(unescape(last), self.value.clone());
            return Ok(());
        };
        place.push('/');
        place.push_str(first);
        let mut node = child_of_object(document, first, &place)?;
        for part in rest {
            place.push('/');
            place.push_str(part);
            node = child(node, part, &place)?;
        }
        match node {
            Value::Object(map) => {
                map.insert(unescape(last), self.value.clone());
            }
            Value::Array(_) => *item(node, last, &self.pointer)? = self.value.clone(),
            other => return Err(no_children(&place, Some(other))),
        }
        Ok(())
    }

    /// What the case says about the old value does not hold for the new one.
    fn renew_sources(&self, document: &mut Map<String, Value>, by: &str) {
        if ["/title", "/notes", "/expect", "/sources"].iter().any(|above| is_at_or_below(&self.pointer, above)) {
            return;
        }
        let sources = document.entry("sources").or_insert_with(|| Value::Object(Map::new()));
        let Value::Object(sources) = sources else { return };
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

/// Values longer than this stand in names as a hash [characters].
const LONGEST_VALUE: usize = 24;
/// Names of changes longer than this become a hash [characters].
const LONGEST_NAME: usize = 100;

/// The changes that make another shot of a case, each key's last one: its name and itself.
fn differences(sets: &[Set]) -> Vec<(String, &Set)> {
    let same_shot = ["/$schema", "/title", "/notes", "/expect", "/sources", "/output"];
    let last = |(index, set): (usize, &Set)| !sets[index + 1..].iter().any(|later| later.pointer == set.pointer);
    let kept = sets.iter().enumerate().filter(|(index, set)| last((*index, set))).map(|(_, set)| set);
    let kept = kept.filter(|set| !same_shot.iter().any(|above| is_at_or_below(&set.pointer, above)));
    kept.map(|set| (short_name(&set.pointer), set)).collect()
}

/// The last part of a pointer, with the one before it where other keys end alike.
fn short_name(pointer: &str) -> String {
    let known = table::pointers();
    let alike = |count: usize| {
        let end = |pointer: &str| pointer.rsplit('/').take(count).map(str::to_owned).collect::<Vec<_>>();
        known.iter().filter(|known| end(known) == end(pointer)).count()
    };
    let parts = if alike(1) <= 1
        && table::lookup(pointer).is_some()
        && index(pointer.rsplit('/').next().unwrap_or_default()).is_none()
    {
        1
    } else {
        2
    };
    let mut last: Vec<&str> = pointer.rsplit('/').take(parts).filter(|part| !part.is_empty()).collect();
    last.reverse();
    last.join(".")
}

/// What was changed, for the title: empty, or `velocity_m_s = 200, …` in brackets.
pub(super) fn in_title(sets: &[Set]) -> String {
    let changes: Vec<String> =
        differences(sets).iter().map(|(name, set)| format!("{name} = {}", text_of(&set.value))).collect();
    if changes.is_empty() { String::new() } else { format!(" [{}]", changes.join(", ")) }
}

/// What was changed, for the name of a folder: empty, or `+velocity_m_s=200…`; any file system takes it.
pub(super) fn in_name(sets: &[Set]) -> String {
    let plain = |value: &str| {
        value.chars().count() <= LONGEST_VALUE && value.chars().all(|c| c.is_ascii_alphanumeric() || ".-_".contains(c))
    };
    let change = |(name, set): &(String, &Set)| {
        let value = text_of(&set.value);
        let name: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() || "._".contains(c) { c } else { '_' }).collect();
        if plain(&value) { format!("+{name}={value}") } else { format!("+{name}={:08x}", hash(&set.value.to_string())) }
    };
    let changes = differences(sets);
    let whole: String = changes.iter().map(change).collect();
    if whole.len() <= LONGEST_NAME { whole } else { format!("+{}-changes-{:08x}", changes.len(), hash(&whole)) }
}

fn hash(text: &str) -> u32 {
    (XxHash3_64::oneshot(text.as_bytes()) >> 32) as u32
}

fn child<'a>(node: &'a mut Value, part: &str, place: &str) -> Result<&'a mut Value, CaseError> {
    match node {
        Value::Object(map) => child_of_object(map, part, place),
        Value::Array(_) => item(node, part, place),
        other => Err(no_children(place.rsplit_once('/').map_or(place, |(parent, _)| parent), Some(other))),
    }
}

fn child_of_object<'a>(map: &'a mut Map<String, Value>, part: &str, place: &str) -> Result<&'a mut Value, CaseError> {
    let name = unescape(part);
    let absent = map.get(&name).is_none_or(Value::is_null);
    if absent {
        let Some(empty) = table::lookup(place).and_then(empty) else {
            if table::lookup(place).is_some() {
                return Err(no_children(place, map.get(&name)));
            }
            let known = table::pointers();
            let error =
                CaseError::at(located(place), "a pointer into the case", format!("nothing at {}", quote(place)));
            return Err(match nearest(place, known.iter().map(String::as_str)) {
                Some(near) => error.help(format!("did you mean {near}?")),
                None => error,
            });
        };
        map.insert(name.clone(), empty);
    }
    Ok(map.entry(name).or_insert(Value::Null))
}

/// What stands at a key before something inside it is set: an object, or the default list.
fn empty(key: &CaseKey) -> Option<Value> {
    match (key.kind, key.presence) {
        (KeyType::Numbers(..), Presence::Default(literal, _)) => Some(literal.value()),
        (KeyType::Object(_) | KeyType::WordOrObject(..) | KeyType::ObjectOrFile(_) | KeyType::Sources, _) => {
            Some(Value::Object(Map::new()))
        }
        _ => None,
    }
}

fn item<'a>(list: &'a mut Value, part: &str, place: &str) -> Result<&'a mut Value, CaseError> {
    let count = list.as_array().map_or(0, Vec::len);
    let expected = match count {
        0 => "another pointer: the list is empty".to_owned(),
        count => format!("an index from 0 to {}", count - 1),
    };
    let error = CaseError::at(located(place), expected, quote(part));
    index(part).and_then(|index| list.get_mut(index)).ok_or(error)
}

fn no_children(place: &str, found: Option<&Value>) -> CaseError {
    let found = found.map_or_else(|| "nothing".to_owned(), describe);
    CaseError::at(located(place), format!("an object or a list at {place}"), found)
        .help(format!("set {place} as a whole"))
}
