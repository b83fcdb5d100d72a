//! From a file or text to a checked case; JSON is read like `serde_json` does, but a key given twice is an error, and errors say what to do.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value, json};

use super::check::check;
use super::error::{CaseError, describe, is_at_or_below, quote};
use super::fabric_file::{self, FabricSource, Inlined};
use super::keys::{CASE, without_aliases};
use super::provenance::{Provenance, in_si, typed};
use super::set::{self, Set};
use super::{Case, CaseKeys, limits, pack, solver, variability};

/// Largest size of a case file [bytes]; a larger file is something else.
const MAX_BYTES: u64 = 1 << 20;

/// Reads, completes and checks a case file; `sets` are changes in the form `/json/pointer=value`.
///
/// # Errors
/// Everything that is wrong key by key, else the first thing that does not go together, with places in the file.
pub fn read(path: &Path, sets: &[String]) -> Result<Case, CaseError> {
    let file = path.display().to_string();
    let text = text_of_file(path).map_err(|error| error.in_file(&file))?;
    let case = assemble(&file, &text, sets, &FabricSource::Folder(folder_of(path)))?;
    Ok(Case { name: stem(path), path: path.to_owned(), ..case })
}

/// Reads a case from text that came another way; `name` stands for the file in errors and names the results, files of
/// fabrics lie in `folder`.
///
/// # Errors
/// As of [`read`].
pub fn from_text(name: &str, text: &str, folder: &Path, sets: &[String]) -> Result<Case, CaseError> {
    let case = assemble(name, text, sets, &FabricSource::Folder(folder))?;
    Ok(Case { name: name.to_owned(), path: PathBuf::from(name), ..case })
}

/// Reads a case from memory; `name` stands for the file in errors. It may name built-in fabrics only.
///
/// # Errors
/// As of [`read`].
pub fn from_str(name: &str, text: &str, sets: &[String]) -> Result<Case, CaseError> {
    let case = assemble(name, text, sets, &FabricSource::BuiltIn)?;
    Ok(Case { name: stem(Path::new(name)), ..case })
}

impl Case {
    /// Names the changes that a case was read with in its title and its name, so that its results are not taken for those of the file.
    pub fn name_changes(&mut self, sets: &[String]) {
        let sets: Vec<Set> = sets.iter().filter_map(|text| set::parse(text).ok()).collect();
        self.name.push_str(&set::in_name(&sets));
        if sets.iter().any(|set| set.pointer == "/title") {
            return;
        }
        self.title.push_str(&set::in_title(&sets));
        if let Some(title) = self.as_run.get_mut("title") {
            *title = Value::from(self.title.as_str());
        }
    }
}

/// The folder of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "case".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// The text of a file of reasonable size.
pub(super) fn text_of_file(path: &Path) -> Result<String, CaseError> {
    let failed = |error: std::io::Error| CaseError::at("", "a case file that can be read", error.to_string());
    let large = |found: String| Err(CaseError::at("", "a file of at most 1 MiB", found));
    let metadata = path.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(CaseError::at("", "a case file", "a folder"));
    }
    if metadata.len() > MAX_BYTES {
        return large(format!("{} bytes", metadata.len()));
    }
    // A pipe or device has no size beforehand.
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return large("more".to_owned());
    }
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let byte = error.as_bytes().get(offset).copied().unwrap_or_default();
        let location = line_column(error.as_bytes(), offset);
        CaseError::at(location, "UTF-8 text", format!("the byte 0x{byte:02X}")).help("save the file as UTF-8")
    })
}

fn assemble(file: &str, text: &str, sets: &[String], source: &FabricSource<'_>) -> Result<Case, CaseError> {
    let named = |error: CaseError| error.in_file(file);
    let document = parse(text).map_err(named)?;
    if !document.is_object() {
        return Err(named(CaseError::at("line 1, column 1", "a JSON object", describe(&document))));
    }
    let sets: Vec<Set> = sets.iter().map(|text| set::parse(text)).collect::<Result<_, _>>().map_err(named)?;
    assemble_document(file, document, &sets, set::FLAG, source)
}

/// The case of a document with changes, whose source is `by`.
pub(super) fn assemble_document(
    file: &str,
    mut document: Value,
    sets: &[Set],
    by: &str,
    source: &FabricSource<'_>,
) -> Result<Case, CaseError> {
    let named = |error: CaseError| error.in_file(file);
    let attributed = |error: CaseError| named(set::attribute(error, sets));
    let (choices, others): (Vec<&Set>, Vec<&Set>) = sets.iter().partition(|set| set.chooses_fabric());
    choices.into_iter().try_for_each(|set| set.apply(&mut document, by)).map_err(named)?;
    let mut files = fabric_file::inline(&mut document, source).map_err(attributed)?;
    others.iter().try_for_each(|set| set.apply(&mut document, by)).map_err(named)?;
    without_aliases(&CASE, &mut document);
    // Where a change reaches into the fabric, the file alone is not to blame.
    files.retain(|file| !others.iter().any(|set| is_at_or_below(&set.pointer, &file.place)));
    let case = checked(&document).map_err(|errors| {
        let placed = errors.into_iter().map(|error| attributed(in_fabric_file(error, &files)));
        CaseError::first_of(placed.collect())
    })?;
    Ok(Case { as_run: document, ..case })
}

/// The case, or everything that is not as its key says, or the first thing that does not go together.
fn checked(document: &Value) -> Result<Case, Vec<CaseError>> {
    let built = built(document)?;
    let mut case = match variability::realised(&built, document) {
        None => built,
        Some((document, drawn)) => Case { drawn, ..self::built(&document)? },
    };
    limits::fit(&mut case);
    limits::check(&case).map_err(|error| vec![error])?;
    Ok(case)
}

/// The case of a document, before it is known whether it can be run.
fn built(document: &Value) -> Result<Case, Vec<CaseError>> {
    let wrong = check(document);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let mut document = document.clone();
    let record = Provenance::of(&mut document);
    solver::derive(&mut document, &record);
    in_si(&CASE, &mut document);
    pack::share_with_layup(&mut document);
    typed("", document).and_then(|keys: CaseKeys| keys.case(record)).map_err(|error| vec![error])
}

/// A shot of a case: `shot` of the draws of `seed`, at this impact velocity before its scatter [m/s]; `None`: that of the case.
///
/// # Errors
/// When a value that was drawn is none that its key allows, or does not go together with the others.
pub(crate) fn realisation(case: &Case, seed: u32, shot: u32, velocity: Option<f64>) -> Result<Case, CaseError> {
    let mut document = case.as_run.clone();
    if !document["variability"].is_object() {
        document["variability"] = json!({});
    }
    document["variability"]["seed"] = json!(seed);
    document["variability"]["shot"] = json!(shot);
    let projectile = document.get_mut("projectile").and_then(Value::as_object_mut);
    if let (Some(projectile), Some(velocity)) = (projectile, velocity) {
        projectile.insert("velocity_m_s".to_owned(), json!(velocity));
    }
    rebuilt(case, document).map_err(CaseError::first_of)
}

/// The case on the mesh of `"accuracy": "converged"`; `None` where its mesh is as fine already, or that one is refused.
pub(crate) fn converged(case: &Case) -> Option<Case> {
    let mut document = case.as_run.clone();
    document["solver"]["accuracy"] = json!("converged");
    let finer = rebuilt(case, document).ok()?;
    (finer.pack.elements_per_crossover > case.pack.elements_per_crossover).then_some(finer)
}

/// A case with another document.
fn rebuilt(case: &Case, document: Value) -> Result<Case, Vec<CaseError>> {
    let built = checked(&document)?;
    Ok(Case { name: case.name.clone(), path: case.path.clone(), as_run: document, ..built })
}

/// An error inside an inlined fabric is one of the file it came from.
fn in_fabric_file(error: CaseError, files: &[Inlined]) -> CaseError {
    let inside = |file: &Inlined| {
        let inside = error.location.strip_prefix(&file.place).filter(|inside| inside.starts_with('/'))?;
        Some((inside.to_owned(), file.name.clone()))
    };
    match files.iter().find_map(inside) {
        Some((location, file)) => CaseError { location, ..error }.in_file(&file),
        None => error,
    }
}

const DUPLICATE: &str = "duplicate key ";

/// Parses one JSON document; errors are located by line and column.
pub(super) fn parse(text: &str) -> Result<Value, CaseError> {
    let refused = |found| CaseError::at("line 1, column 1", "a JSON document", found);
    if text.starts_with('\u{feff}') {
        return Err(refused("a byte order mark (BOM)").help("save the file as UTF-8 without BOM"));
    }
    if text.trim().is_empty() {
        return Err(refused("an empty file"));
    }
    let mut reader = serde_json::Deserializer::from_str(text);
    let value = Unique.deserialize(&mut reader).and_then(|value| reader.end().map(|()| value));
    value.map_err(|error| explain(text, &error))
}

/// `line L, column C` of a byte offset, both from 1.
pub(super) fn line_column(bytes: &[u8], offset: usize) -> String {
    let before = &bytes[..offset.min(bytes.len())];
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|byte| **byte != b'\n').count() + 1;
    format!("line {line}, column {column}")
}

fn explain(text: &str, error: &serde_json::Error) -> CaseError {
    let at = |expected: &str, found: &str| {
        CaseError::at(format!("line {}, column {}", error.line(), error.column().max(1)), expected, found)
    };
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
    let token = token_at(text, error.line(), error.column());
    let found = if token.is_empty() { "the end of the line".to_owned() } else { quote(&token) };
    if error.is_eof() {
        return at("the rest of the document", &format!("the end of the text ({message})"))
            .help("a closing brace, bracket or quote is missing; was the file cut off?");
    }
    match message {
        _ if message.starts_with(DUPLICATE) => {
            at("each key once in an object", message).help("remove one of the two, or rename it")
        }
        "recursion limit exceeded" => at("objects and lists nested at most 127 deep", "deeper nesting"),
        "number out of range" => at("a number that fits in 64 bits (below 1.8e308)", &found),
        "trailing comma" => {
            at("another item or the closing bracket", "a comma before it").help("JSON has no comma after the last item")
        }
        "trailing characters" => at("the end of the text after the document", &found),
        "key must be a string" => at("a key in double quotes", &found),
        _ => {
            let (expected, found) = match message.strip_prefix("expected ") {
                Some(expected) => (expected.replace("ident", "a JSON value"), found),
                None => ("valid JSON".to_owned(), format!("{message}: {found}")),
            };
            let error = at(&expected, &found);
            match help(&token) {
                Some(help) => error.help(help),
                None => error,
            }
        }
    }
}

/// Help for something that people write and JSON does not have.
fn help(token: &str) -> Option<&'static str> {
    let word = token.trim_start_matches(['-', '+']).to_lowercase();
    let begins = |with: &[&str]| with.iter().any(|with| word.starts_with(with));
    if ["nan", "inf", "infinity"].contains(&word.as_str()) {
        Some("JSON has no NaN or Infinity; every number of a case is finite")
    } else if begins(&["//", "/*", "#"]) {
        Some("JSON has no comments; put them under \"notes\"")
    } else if begins(&["'"]) {
        Some("JSON strings stand in double quotes")
    } else if begins(&["."]) || token.starts_with('+') {
        Some("JSON numbers begin with a digit or a minus")
    } else {
        None
    }
}

/// The word, number or sign at a position of the text, for people.
fn token_at(text: &str, line: usize, column: usize) -> String {
    let line = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let part = |c: char| c.is_alphanumeric() || "+-._".contains(c);
    let mut start = column.saturating_sub(1).min(line.len());
    while !line.is_char_boundary(start) {
        start -= 1;
    }
    let before = line[..start].chars().rev().take_while(|c| part(*c)).map(char::len_utf8).sum::<usize>();
    let rest = &line[start - before..];
    match rest.chars().next() {
        Some(first) if part(first) => rest.chars().take_while(|c| part(*c)).take(40).collect(),
        Some('/') => rest.chars().take(2).collect(),
        first => first.into_iter().collect(),
    }
}

/// Reader of a value whose objects have each key once.
struct Unique;

impl<'de> DeserializeSeed<'de> for Unique {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Unique {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Value, E> {
        Ok(Value::Bool(flag))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::from(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::from(number))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Value, E> {
        Number::from_f64(number).map(Value::Number).ok_or_else(|| E::custom("number out of range"))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::from(text))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element_seed(Self)? {
            list.push(item);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            if map.contains_key(&key) {
                return Err(A::Error::custom(format!("{DUPLICATE}{}", quote(&key))));
            }
            map.insert(key, entries.next_value_seed(Self)?);
        }
        Ok(Value::Object(map))
    }
}
