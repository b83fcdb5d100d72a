//! Refusals: where, what was expected, what was found, and help; a document against the keys of the case file, everything that
//! is wrong with it, before anything is read; and the words for values, numbers, lists and JSON pointers.

use std::path::Path;
use std::{fmt, io, iter};

use serde_json::Value;

use super::keys::{CASE, Key, accepts, expected, fits, keys, lookup, object, pointers, strings, value_of};
use super::units::{has_number, others};

/// Refusal of a case, or of a file or folder that goes with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub struct CaseError {
    /// The file, as the user named it.
    pub file: Box<str>,
    /// JSON pointer, `line L, column C`, or `--set /pointer`; empty where the file cannot be read at all.
    pub location: String,
    /// Values that may stand there.
    pub expected: String,
    /// The value that stands there.
    pub found: String,
    /// Remedy, where one is known.
    pub help: Option<String>,
    /// The next error of the same case.
    pub next: Option<Box<Self>>,
}

/// Errors shown; of a file that is something else, more say nothing.
const SHOWN: usize = 12;

impl fmt::Display for CaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |error: &Self| {
            let Self { file, location, expected, found, help, .. } = error;
            let colon = if file.is_empty() || location.is_empty() { "" } else { ": " };
            let help = help.as_ref().map(|help| format!("\n  help: {help}")).unwrap_or_default();
            format!("error: {file}{colon}{location}\n  expected: {expected}\n  found: {found}{help}")
        };
        f.write_str(&self.all().take(SHOWN).map(text).collect::<Vec<_>>().join("\n"))?;
        match self.all().count().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, "\n{more} more"),
        }
    }
}

impl CaseError {
    /// An error in a file, at a JSON pointer of it.
    pub fn new(
        file: &str,
        location: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self::at(location, expected, found).help(help).in_file(file)
    }

    /// An error at `location` of a file that the caller names with [`CaseError::in_file`].
    pub(crate) fn at(location: impl Into<String>, expected: impl Into<String>, found: impl Into<String>) -> Self {
        let (location, expected, found) = (location.into(), expected.into(), found.into());
        Self { file: Box::default(), location, expected, found, help: None, next: None }
    }

    /// This one and all that are wrong besides.
    pub fn all(&self) -> impl Iterator<Item = &Self> {
        iter::successors(Some(self), |error| error.next.as_deref())
    }

    /// The first of some errors, with the others behind it.
    pub(super) fn first_of(errors: Vec<Self>) -> Self {
        let chained = errors.into_iter().rev().reduce(|next, error| Self { next: Some(Box::new(next)), ..error });
        chained.unwrap_or_else(|| Self::at("", "a case", "nothing"))
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// An error of a file or folder as a whole.
    pub(crate) fn of_path(path: &Path, expected: impl Into<String>, found: impl ToString, help: &str) -> Self {
        Self::new(&path.display().to_string(), "", expected, found.to_string(), help)
    }

    /// Error of a file of results that the disk refuses.
    pub(crate) fn unwritten(path: &Path, error: &io::Error) -> Self {
        Self::of_path(path, "a disk that takes the results", error, "make room there; the same command goes on")
    }

    /// Names the file, unless an inner reader already did.
    #[must_use]
    pub fn in_file(mut self, file: &str) -> Self {
        if self.file.is_empty() {
            self.file = file.into();
        }
        self
    }
}

/// A JSON value in words, short enough for one line.
pub(super) fn describe(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Bool(flag) => flag.to_string(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), number_text),
        Value::String(text) => quote(text),
        Value::Array(items) => format!("a list of {}", items.len()),
        Value::Object(map) => match map.keys().next() {
            Some(key) => format!("an object with {}", quote(key)),
            None => "an empty object".to_owned(),
        },
    }
}

/// A value as the report shows it.
pub(super) fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => format!("[{}]", items.iter().map(text_of).collect::<Vec<_>>().join(", ")),
        other => describe(other),
    }
}

/// Text in quotes, control characters escaped, cut at 60 characters.
pub(super) fn quote(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    format!("{short:?}")
}

/// `"a", "b" or "c"`.
pub(super) fn list<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<String> = words.into_iter().map(quote).collect();
    match &words[..] {
        [rest @ .., last] if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        words => words.concat(),
    }
}

/// A number in the fewest digits that read back as itself.
pub(super) fn number_text(number: f64) -> String {
    if number == 0.0 || (1e-4..1e7).contains(&number.abs()) { format!("{number}") } else { format!("{number:e}") }
}

/// A computed number to six digits: without the dust of unit conversion.
pub(super) fn short_number_text(number: f64) -> String {
    number_text(format!("{number:.5e}").parse().unwrap_or(number))
}

/// A length [m] in millimetres, for messages.
pub(super) fn millimetres(length: f64) -> String {
    format!("{} mm", short_number_text(length * 1e3))
}

/// A whole number that fits; 2.0 is one.
pub(super) fn whole(value: &Value) -> Option<u32> {
    let number = value.as_f64().filter(|number| number.fract() == 0.0)?;
    (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as u32)
}

/// The fraction meant by `1%`.
pub(super) fn percent(text: &str) -> Option<f64> {
    let number: f64 = text.strip_suffix('%')?.trim().parse().ok()?;
    (0.0..=100.0).contains(&number).then_some(number / 100.0)
}

/// The candidate nearest to a word: fewest edits, at most a third of its letters, and among those the longest common beginning.
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Beyond this length nothing resembles a key, and the table of edits would only cost time.
    let word: String = word.chars().take(100).collect();
    let rank = |candidate: &&str| {
        let common = word.chars().zip(candidate.chars()).take_while(|(a, b)| a == b).count();
        // `mass` is meant as `mass_g`, however long the unit that was left out.
        let beginning = common == word.chars().count().min(candidate.chars().count()) && common >= 3;
        let edits = strsim::osa_distance(&word, candidate);
        (if beginning { edits.min(2) } else { edits }, std::cmp::Reverse(common))
    };
    candidates.into_iter().min_by_key(rank).filter(|near| rank(near).0 <= (word.chars().count() / 3).max(2))
}

/// Whether `pointer` is `above` or something inside it.
pub(super) fn is_at_or_below(pointer: &str, above: &str) -> bool {
    pointer.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// The index that a part of a pointer stands for: digits without a leading zero.
pub(super) fn index(part: &str) -> Option<usize> {
    let canonical = part == "0" || part.starts_with(|c: char| ('1'..='9').contains(&c));
    part.parse().ok().filter(|_| canonical)
}

/// A key as part of a JSON pointer; control characters are escaped, for an error is one line per part.
pub(super) fn escape(key: &str) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().collect() } else { vec![c] };
    key.chars().take(200).collect::<String>().replace('~', "~0").replace('/', "~1").chars().flat_map(shown).collect()
}

/// A part of a JSON pointer as the key it stands for.
pub(super) fn unescape(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
}

/// Everything in a document that is not as its key says, in the order of the document.
pub(super) fn check(document: &Value) -> Vec<CaseError> {
    let mut errors = Vec::new();
    check_object("", &CASE, document, &mut errors);
    let sources = document.get("sources").filter(|given| given.is_object());
    errors.extend(sources.and_then(|given| check_sources(given, "", document).err()));
    errors
}

fn check_object(pointer: &str, node: &'static Value, object: &Value, errors: &mut Vec<CaseError>) {
    let keys = keys(node);
    let mut meant = Vec::new();
    for (name, value) in object.as_object().into_iter().flatten() {
        let Some(key) = keys.iter().find(|key| key.name == name) else {
            meant.extend(nearest(name, keys.iter().map(|key| key.name)));
            errors.push(unknown(pointer, &keys, name));
            continue;
        };
        let place = format!("{pointer}/{name}");
        match misplaced(&place, key, value, &keys, object) {
            Some(error) => errors.push(error),
            None if key.node["type"].is_array() && value.is_null() => {}
            None => check_value(&place, key.node, value, errors),
        }
    }
    // Who wrote a key wrong need not hear that it is missing.
    let absent = |key: &&Key| object.get(key.name).is_none() && !meant.contains(&key.name);
    for key in keys.iter().filter(absent).filter(|key| key.belongs(&keys, object) && key.is_missing(&keys, object)) {
        let error = CaseError::at(format!("{pointer}/{}", key.name), expected(key.node), "nothing");
        let instead = key.text("or").strip_prefix('/').map(|or| format!(", or {}", quote(or))).unwrap_or_default();
        errors.push(error.help(format!("{}{instead} is required: {}", quote(key.name), key.text("description"))));
    }
    for key in keys.iter().filter(|key| key.has("at_most")) {
        let (limit, unit) = (key.text("at_most"), format!(" {}", key.unit()));
        let [low, most] = [key.name, limit].map(|name| value_of(name, &keys, object).unwrap_or_default());
        if let (Ok(number), Ok(largest)) = (low.parse::<f64>(), most.parse::<f64>())
            && number > largest
        {
            let [expected, found] = [format!("at most {limit}, which is {most}{unit}"), format!("{low}{unit}")];
            errors.push(CaseError::at(format!("{pointer}/{}", key.name), expected.trim_end(), found.trim_end()));
        }
    }
    for members in keys.chunk_by(|one, other| one.text("group") == other.text("group")) {
        let group = members[0].text("group");
        if group.is_empty() || !members[0].belongs(&keys, object) {
            continue;
        }
        let names = list(members.iter().map(|key| key.name));
        let given = members.iter().filter(|key| object.get(key.name).is_some());
        if given.clone().next().is_none() {
            errors.push(CaseError::at(pointer, format!("a {group}: {names}"), "none of them"));
        } else if let Some(second) = given.clone().nth(1) {
            let (place, found) = (format!("{pointer}/{}", second.name), format!("{} of them", given.count()));
            errors.push(CaseError::at(place, format!("one {group}: {names}"), found));
        }
    }
}

/// Checks a value, and what is in it.
fn check_value(place: &str, node: &'static Value, value: &Value, errors: &mut Vec<CaseError>) {
    if let Some(items) = fits(node, value) {
        let items = items.iter().enumerate();
        items.for_each(|(index, item)| check_value(&format!("{place}/{index}"), &node["items"], item, errors));
    } else if !accepts(node, value) {
        let help = remedy(node, value);
        errors.push(CaseError { help, ..CaseError::at(place, expected(node), describe(value)) });
    } else if value.is_object() && object(node).is_some() {
        check_object(place, node, value, errors);
    }
}

/// Help with a value that may not stand where it does.
fn remedy(node: &'static Value, value: &Value) -> Option<String> {
    let text = value.as_str().unwrap_or_default();
    let choice = node["anyOf"].get(0).unwrap_or(node);
    let is_number = node["type"] == "number" || node["type"] == "integer";
    if choice.get("enum").is_some() && !text.is_empty() {
        nearest(text, strings(&choice["enum"])).map(|near| format!("did you mean {}?", quote(near)))
    } else if is_number && text.parse::<f64>().is_ok_and(f64::is_finite) {
        Some("write the number without quotes".to_owned())
    } else if is_number && has_number(text) {
        let others = others(node["unit"].as_str()).join(", ");
        Some(if others.is_empty() { "write the number alone".to_owned() } else { format!("units here: {others}") })
    } else if node["anyOf"][1].get("pattern").is_some() && !text.is_empty() {
        Some("for example \"1%\"".to_owned())
    } else {
        node["help"].as_str().filter(|_| value.as_f64() > Some(0.0)).map(str::to_owned)
    }
}

/// The error of a key that does not belong beside what the others say, or lacks the one that belongs with it.
fn misplaced(place: &str, key: &Key, value: &Value, keys: &[Key], object: &Value) -> Option<CaseError> {
    let (name, with) = (quote(key.name), key.text("with"));
    if !key.belongs(keys, object) {
        let (other, values) = key.condition("only")?;
        let expected = format!("no {name} where {} is {}", quote(other), quote(&value_of(other, keys, object)?));
        let help = format!("it belongs where {} is {}", quote(other), list(values));
        return Some(CaseError::at(place, expected, describe(value)).help(help));
    }
    let together = || {
        CaseError::at(place, format!("{name} and {} together, or none of them", quote(with)), format!("only {name}"))
    };
    (!with.is_empty() && object.get(with).is_none()).then(together)
}

/// The error of an unknown key. The nearest one comes first; the others are many, and the schema has them.
fn unknown(pointer: &str, keys: &[Key], name: &str) -> CaseError {
    let object = if pointer.is_empty() { "the case" } else { pointer };
    let near = nearest(name, keys.iter().map(|key| key.name));
    // A key of this object without its unit is meant before one of another object.
    let without_unit = near.and_then(|near| near.strip_prefix(name)).is_some_and(|unit| unit.starts_with('_'));
    let elsewhere = pointers().into_iter().find(|pointer| pointer.rsplit('/').next() == Some(name) && !without_unit);
    let belongs = || elsewhere.map(|pointer| format!("{} belongs at {pointer}", quote(name)));
    let or = near.map_or("one".to_owned(), |near| format!("{} or another", quote(near)));
    let meant = near.map(|near| format!("did you mean {}? ", quote(near))).unwrap_or_default();
    let help = belongs().unwrap_or_else(|| format!("{meant}`ripstop schema` lists every key"));
    let expected = format!("{or} of the {} keys of {object}", keys.len());
    CaseError::at(format!("{pointer}/{}", escape(name)), expected, format!("unknown key {}", quote(name))).help(help)
}

/// Refuses a source that is no text or whose pointer names nothing; `base` is where `document` stands in a case.
pub(super) fn check_sources(sources: &Value, base: &str, document: &Value) -> Result<(), CaseError> {
    let Value::Object(sources) = sources else {
        return Err(CaseError::at("/sources", "an object of JSON pointers and texts", describe(sources)));
    };
    for (pointer, text) in sources {
        let location = format!("/sources/{}", escape(pointer));
        if !text.is_string() {
            return Err(CaseError::at(location, "text", describe(text)));
        }
        if lookup(&format!("{base}{pointer}")).is_none() && document.pointer(pointer).is_none() {
            let pointers = pointers();
            let inside = pointers.iter().filter(|known| is_at_or_below(known, base)).map(|known| &known[base.len()..]);
            let error = CaseError::at(location, "the JSON pointer of a field", quote(pointer));
            let near = nearest(pointer, inside.filter(|pointer| !pointer.is_empty()));
            return Err(CaseError { help: near.map(|near| format!("did you mean {}?", quote(near))), ..error });
        }
    }
    Ok(())
}
