//! From a file or text to a checked case.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::error::{CaseError, describe};
use super::fabric_file::{self, Inlined, Shelf};
use super::pointer::is_at_or_below;
use super::set::{self, Set};
use super::{Case, build, json, limits, sources};

/// No case comes near this size [bytes]; a file that does is something else.
const MAX_BYTES: u64 = 1 << 20;

/// Reads, completes and checks a case file; `sets` are changes in the form `/json/pointer=value`.
///
/// # Errors
/// The first thing that is wrong, with its place in the file.
pub fn read(path: &Path, sets: &[String]) -> Result<Case, CaseError> {
    let file = path.display().to_string();
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let text = text_of_file(path).map_err(|error| error.in_file(&file))?;
    let mut case = assemble(&file, &text, sets, &Shelf::Folder(folder))?;
    case.name = stem(path);
    case.path = path.to_owned();
    Ok(case)
}

/// Reads a case from memory; `name` stands for the file in errors. It may name built-in fabrics only.
///
/// # Errors
/// The first thing that is wrong, with its place in the text.
pub fn from_str(name: &str, text: &str, sets: &[String]) -> Result<Case, CaseError> {
    let mut case = assemble(name, text, sets, &Shelf::BuiltIn)?;
    case.name = stem(Path::new(name));
    case.path = PathBuf::new();
    Ok(case)
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "case".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// The text of a file of reasonable size.
pub(super) fn text_of_file(path: &Path) -> Result<String, CaseError> {
    let whole = "";
    let failed = |error: std::io::Error| CaseError::at(whole, "a case file that can be read", error.to_string());
    let large = |found: String| CaseError::at(whole, "a file of at most 1 MiB", found);
    let metadata = path.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(CaseError::at(whole, "a case file", "a folder"));
    }
    if metadata.len() > MAX_BYTES {
        return Err(large(format!("{} bytes", metadata.len())));
    }
    // A pipe or device has no size beforehand.
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(large("more".to_owned()));
    }
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let byte = error.as_bytes().get(offset).copied().unwrap_or_default();
        let location = json::line_column(error.as_bytes(), offset);
        CaseError::at(location, "UTF-8 text", format!("the byte 0x{byte:02X}")).help("save the file as UTF-8")
    })
}

fn assemble(file: &str, text: &str, sets: &[String], shelf: &Shelf<'_>) -> Result<Case, CaseError> {
    let named = |error: CaseError| error.in_file(file);
    let document = json::parse(text).map_err(named)?;
    let Value::Object(mut document) = document else {
        return Err(named(CaseError::at("line 1, column 1", "a JSON object", describe(&document))));
    };
    let sets: Vec<Set> = sets.iter().map(|text| set::parse(text)).collect::<Result<_, _>>().map_err(named)?;
    let blamed = |error: CaseError| named(set::blame(error, &sets));
    for set in sets.iter().filter(|set| set.chooses_fabric()) {
        set.apply(&mut document).map_err(named)?;
    }
    let mut files = fabric_file::inline(&mut document, shelf).map_err(blamed)?;
    for set in sets.iter().filter(|set| !set.chooses_fabric()) {
        set.apply(&mut document).map_err(named)?;
    }
    let as_run = Value::Object(document);
    // Where a change reaches into the fabric, the file alone is not to blame.
    let changes = |set: &Set, place: &str| !set.chooses_fabric() && is_at_or_below(&set.pointer, place);
    files.retain(|file| !sets.iter().any(|set| changes(set, &file.place)));
    let case = checked(&as_run).map_err(|error| blamed(in_fabric_file(error, &files)))?;
    Ok(Case { as_run, ..case })
}

fn checked(document: &Value) -> Result<Case, CaseError> {
    if let Some(given) = document.get("sources") {
        sources::check(given, "", document)?;
    }
    let map = document.as_object().cloned().unwrap_or_default();
    let case = build::case(&map)?;
    limits::check(&case)?;
    Ok(case)
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
