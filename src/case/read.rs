//! From a file or text to a checked case. A key given twice is an error, and errors of JSON say what to do.

use std::collections::HashSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde_json::{Deserializer, Value, json};

use super::changes::{self, Change};
use super::error::{CaseError, check, describe, is_at_or_below, quote};
use super::keys::CASE;
use super::provenance::{Origin, Provenance, in_si, typed};
use super::units::without_units;
use super::{Case, fabric, pack, solver, variability};

/// Largest size of a case file [bytes]; a larger file is something else.
const MAX_BYTES: u64 = 1 << 20;

/// Reads, completes and checks a case file; `sets` are changes in the form `/json/pointer=value`.
///
/// # Errors
/// Everything that is wrong key by key, else the first thing that does not go together, with places in the file.
pub fn read(path: &Path, sets: &[String]) -> Result<Case, CaseError> {
    let file = path.display().to_string();
    let text = text_of_file(path).map_err(|error| error.in_file(&file))?;
    let case = assemble(&file, &text, sets, Some(folder_of(path)))?;
    Ok(Case { name: stem(path), path: path.to_owned(), ..case })
}

/// Reads a case from memory; `name` stands for the file in errors. It may name built-in fabrics only.
///
/// # Errors
/// As of [`read`].
pub fn from_str(name: &str, text: &str, sets: &[String]) -> Result<Case, CaseError> {
    let case = assemble(name, text, sets, None)?;
    Ok(Case { name: stem(Path::new(name)), ..case })
}

/// The folder of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."))
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "case".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// The text of a file of reasonable size.
pub(super) fn text_of_file(path: &Path) -> Result<String, CaseError> {
    let failed = |error: std::io::Error| CaseError::at("", "a case file that can be read", error.to_string());
    let metadata = path.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(CaseError::at("", "a case file", "a folder"));
    }
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        // A pipe or device has no size beforehand.
        let found = format!("{} bytes", metadata.len().max(bytes.len() as u64));
        return Err(CaseError::at("", "a file of at most 1 MiB", found));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (before, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let found = format!("the byte 0x{:02X}", rest.first().unwrap_or(&0));
        CaseError::at(line_column(before), "UTF-8 text", found).help("save the file as UTF-8")
    })
}

fn assemble(file: &str, text: &str, sets: &[String], folder: Option<&Path>) -> Result<Case, CaseError> {
    let read = || {
        let document = parse(text)?;
        if !document.is_object() {
            return Err(CaseError::at("line 1, column 1", "a JSON object", describe(&document)));
        }
        Ok((document, sets.iter().map(|text| changes::parse(text)).collect::<Result<Vec<_>, _>>()?))
    };
    let (document, changes) = read().map_err(|error| error.in_file(file))?;
    assemble_document(file, document, &changes, changes::FLAG, folder)
}

/// The case of a document with changes, whose source is `by`.
pub(super) fn assemble_document(
    file: &str,
    mut document: Value,
    changes: &[Change],
    by: &str,
    folder: Option<&Path>,
) -> Result<Case, CaseError> {
    let of_change = |error: CaseError| match by == changes::FLAG {
        true => CaseError { location: changes::located(&error.location), ..error }.in_file(file),
        false => error.in_file(file),
    };
    let attributed = |error: CaseError| {
        let is_of_change = |change: &Change| is_at_or_below(&error.location, &change.pointer);
        let own = error.file.is_empty() && changes.iter().any(is_of_change);
        if own { of_change(error) } else { error.in_file(file) }
    };
    let (choices, others): (Vec<&Change>, Vec<&Change>) = changes.iter().partition(|change| change.chooses_fabric());
    choices.into_iter().try_for_each(|change| change.apply(&mut document, by)).map_err(of_change)?;
    let mut files = fabric::inline(&mut document, folder).map_err(attributed)?;
    others.iter().try_for_each(|change| change.apply(&mut document, by)).map_err(of_change)?;
    without_units(&mut document);
    // Where a change reaches into the fabric, the file alone is not to blame.
    files.retain(|(place, _)| !others.iter().any(|change| is_at_or_below(&change.pointer, place)));
    let placed = |error: CaseError| {
        let inside = |(place, file): &(String, String)| {
            let inside = error.location.strip_prefix(place).filter(|inside| inside.starts_with('/'))?;
            Some((inside.to_owned(), file.clone()))
        };
        match files.iter().find_map(inside) {
            Some((location, file)) => CaseError { location, ..error }.in_file(&file),
            None => attributed(error),
        }
    };
    let case = checked(&document);
    let case = case.map_err(|errors| CaseError::first_of(errors.into_iter().map(placed).collect()))?;
    Ok(Case { as_run: document, ..case })
}

/// The case, or everything that is not as its key says, or the first thing that does not go together.
fn checked(document: &Value) -> Result<Case, Vec<CaseError>> {
    let built = built(document)?;
    let mut case = match variability::realised(&built, document) {
        None => built,
        Some((document, drawn)) => Case { drawn, ..self::built(&document)? },
    };
    super::fit_to_end(&mut case);
    super::check_limits(&case).map_err(|error| vec![error])?;
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
    let completed = |mut case: Case| case.complete(&record).map(|()| case);
    let case = typed("", document).and_then(completed).map_err(|error| vec![error])?;
    Ok(Case { fields: record.into_fields(), ..case })
}

/// A shot of a case: `shot` of the draws of `seed`, at this impact velocity before its scatter [m/s]; `None`: that of the case.
///
/// # Errors
/// When a value that was drawn is none that its key allows, or does not go together with the others.
pub(crate) fn realisation(case: &Case, seed: u32, shot: u32, velocity: Option<f64>) -> Result<Case, CaseError> {
    let mut document = case.as_run.clone();
    document["variability"]["seed"] = json!(seed);
    document["variability"]["shot"] = json!(shot);
    if let Some(velocity) = velocity.filter(|_| case.projectile.is_some()) {
        document["projectile"]["velocity_m_s"] = json!(velocity);
    }
    rebuilt(case, document).map_err(CaseError::first_of)
}

/// The case on the mesh of `"accuracy": "converged"`; `None` where its mesh is as fine already, or that one is refused.
pub(crate) fn converged(case: &Case) -> Option<Case> {
    let mut document = case.as_run.clone();
    document["solver"]["accuracy"] = json!("converged");
    let finer = rebuilt(case, document).ok()?;
    (finer.pack.mesh != case.pack.mesh).then_some(finer)
}

/// Case whose impact velocity is the one asked for: its scatter moves shots, not the limit.
pub(crate) fn at_nominal_velocity(case: &Case) -> Case {
    let mut case = case.clone();
    if let Some(variability) = case.as_run.get_mut("variability").and_then(Value::as_object_mut) {
        variability.remove("velocity");
    }
    if let Some(variability) = &mut case.variability {
        variability.velocity = None;
    }
    case
}

/// The case with yarns that keep a part of their strength; `None` where it says itself what they keep.
pub(crate) fn as_woven(case: &Case, retention: f64) -> Option<Case> {
    let mut document = case.as_run.clone();
    for field in case.fields.iter().filter(|field| field.pointer.ends_with("/strength_retention")) {
        let (yarn, key) = field.pointer.rsplit_once('/').filter(|_| field.origin == Origin::Default)?;
        document.pointer_mut(yarn)?[key] = json!(retention);
    }
    rebuilt(case, document).ok()
}

/// A case with another document.
fn rebuilt(case: &Case, document: Value) -> Result<Case, Vec<CaseError>> {
    let built = checked(&document)?;
    Ok(Case { name: case.name.clone(), path: case.path.clone(), as_run: document, ..built })
}

/// Parses one JSON document; errors are located by line and column.
pub(super) fn parse(text: &str) -> Result<Value, CaseError> {
    let refused = |found| CaseError::at("line 1, column 1", "a JSON document", found);
    let text = text.strip_prefix('\u{feff}').unwrap_or(text); // a byte order mark
    if text.trim().is_empty() {
        return Err(refused("an empty file"));
    }
    if text.trim_start().starts_with(['*', '$']) {
        let help = "a case is JSON, with the yarns and the pack instead of cards: `ripstop new` writes one";
        return Err(refused("what seems to be an LS-DYNA keyword file").help(help));
    }
    let value = serde_json::from_str(text).map_err(|error| explain(text, &error))?;
    duplicate(text).map_or(Ok(value), Err)
}

/// The error of the first key that an object of a JSON text has twice.
fn duplicate(text: &str) -> Option<CaseError> {
    let (mut objects, mut at) = (Vec::new(), 0);
    while let Some(sign) = text.as_bytes().get(at) {
        match sign {
            b'{' => objects.push(HashSet::new()),
            b'}' => drop(objects.pop()),
            b'"' => {
                let mut strings = Deserializer::from_str(&text[at..]).into_iter::<String>();
                let key = strings.next()?.ok()?;
                at += strings.byte_offset() - 1;
                if text[at + 1..].trim_start().starts_with(':') && !objects.last_mut()?.insert(key.clone()) {
                    let (place, found) =
                        (line_column(&text.as_bytes()[..at]), format!("duplicate key {}", quote(&key)));
                    let error = CaseError::at(place, "each key once in an object", found);
                    return Some(error.help("remove one of the two, or rename it"));
                }
            }
            _ => {}
        }
        at += 1;
    }
    None
}

/// `line L, column C` of what follows these bytes of a text, both from 1.
fn line_column(before: &[u8]) -> String {
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|byte| **byte != b'\n').count() + 1;
    format!("line {line}, column {column}")
}

fn explain(text: &str, error: &serde_json::Error) -> CaseError {
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
    let token = token_at(text, error.line(), error.column());
    let found = if token.is_empty() { "the end of the line".to_owned() } else { quote(&token) };
    let (expected, found, help) = match message {
        _ if error.is_eof() => (
            "the rest of the document",
            format!("the end of the text ({message})"),
            Some("a closing brace, bracket or quote is missing; was the file cut off?"),
        ),
        "recursion limit exceeded" => ("objects and lists nested at most 127 deep", "deeper nesting".to_owned(), None),
        "number out of range" => ("a number that fits in 64 bits (below 1.8e308)", found, None),
        "trailing comma" => {
            let help = "JSON has no comma after the last item";
            ("another item or the closing bracket", "a comma before it".to_owned(), Some(help))
        }
        "trailing characters" => ("the end of the text after the document", found, None),
        "key must be a string" => ("a key in double quotes", found, None),
        "expected ident" => ("a JSON value", found, hint(&token)),
        _ => match message.strip_prefix("expected ") {
            Some(expected) => (expected, found, hint(&token)),
            None => ("valid JSON", format!("{message}: {found}"), hint(&token)),
        },
    };
    let location = format!("line {}, column {}", error.line(), error.column().max(1));
    CaseError { help: help.map(str::to_owned), ..CaseError::at(location, expected, found) }
}

/// Help for something that people write and JSON does not have.
fn hint(token: &str) -> Option<&'static str> {
    let word = token.trim_start_matches(['-', '+']).to_lowercase();
    match word.chars().next() {
        _ if ["nan", "inf", "infinity"].contains(&&*word) => {
            Some("JSON has no NaN or Infinity; every number of a case is finite")
        }
        Some('/' | '#') => Some("JSON has no comments; put them under \"notes\""),
        Some('\'') => Some("JSON strings stand in double quotes"),
        first if first == Some('.') || token.starts_with('+') => Some("JSON numbers begin with a digit or a minus"),
        _ => None,
    }
}

/// The word, number or sign at a position of the text, for people.
fn token_at(text: &str, line: usize, column: usize) -> String {
    let line = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let part = |c: char| c.is_alphanumeric() || "+-._".contains(c);
    let at = (0..=column.saturating_sub(1).min(line.len())).rfind(|at| line.is_char_boundary(*at)).unwrap_or(0);
    let rest = &line[line[..at].trim_end_matches(part).len()..];
    match rest.chars().next() {
        Some(first) if part(first) => rest.chars().take_while(|c| part(*c)).take(40).collect(),
        Some('/') => rest.chars().take(2).collect(),
        first => first.into_iter().collect(),
    }
}
