//! `{"file": …}` in place of a fabric: the fabric kept in a file of its own, or built into the program.

use std::path::{Component, Path, PathBuf};

use serde_json::{Map, Value};

use super::error::{CaseError, describe, quote};
use super::pointer::{escape, is_at_or_below};
use super::{builtin_fabric, json, places, read, sources};

/// Where a fabric file is looked up.
pub(super) enum FabricSource<'a> {
    /// The folder of the case file.
    Folder(&'a Path),
    /// The fabrics built into the program.
    BuiltIn,
}

/// A fabric that a file was read for.
pub(super) struct Inlined {
    /// Where in the case the fabric stands.
    pub(super) place: String,
    /// The file, as errors name it.
    pub(super) name: String,
}

/// Puts the fabrics of files in place of their names; returns the files that were read.
pub(super) fn inline(document: &mut Map<String, Value>, source: &FabricSource<'_>) -> Result<Vec<Inlined>, CaseError> {
    let mut inlined = Vec::new();
    for place in places::all(document) {
        let Some(name) = file_name(places::get_mut(document, &place).as_deref(), &place)? else { continue };
        let (file, text) = text_of(&name, source, &place)?;
        let fabric = json::parse(&text).and_then(|value| own_sources(value, &name, &place));
        let (fabric, fabric_sources) = fabric.map_err(|error| error.in_file(&file))?;
        if let Some(stands) = places::get_mut(document, &place) {
            *stands = Value::Object(fabric);
        }
        add_sources(document, fabric_sources, &place);
        inlined.push(Inlined { place, name: file });
    }
    Ok(inlined)
}

/// The name of a file as errors say it, and what it holds.
fn text_of(name: &str, source: &FabricSource<'_>, place: &str) -> Result<(String, String), CaseError> {
    match source {
        FabricSource::Folder(folder) => {
            let path = resolve(folder, name, place)?;
            let file = folder.join(name).display().to_string();
            let text = read::text_of_file(&path).map_err(|error| error.in_file(&file))?;
            Ok((file, text))
        }
        FabricSource::BuiltIn => match builtin_fabric(name) {
            Some(text) => Ok((format!("{name} (built in)"), text.to_owned())),
            None => {
                let error = CaseError::at(format!("{place}/file"), "a fabric that is built in", quote(name));
                Err(error.help("a case without a file of its own cannot name a fabric file; write it out"))
            }
        },
    }
}

/// The name in `{"file": name}`; `None` for a fabric written out in the case.
fn file_name(fabric: Option<&Value>, place: &str) -> Result<Option<String>, CaseError> {
    let map = match fabric {
        Some(Value::Array(_)) => {
            let error = CaseError::at(place, "one fabric", "a list of fabrics");
            return Err(error.help("plies of different fabrics are listed in /pack/layup, one fabric in each item"));
        }
        Some(Value::Object(map)) => map,
        _ => return Ok(None),
    };
    let Some(file) = map.get("file") else { return Ok(None) };
    if let Some(other) = map.keys().find(|key| *key != "file") {
        let location = format!("{place}/{}", escape(other));
        let error = CaseError::at(location, "\"file\" alone", format!("{} beside it", quote(other)));
        return Err(error.help("write the fabric out in the case to change it, or use --set"));
    }
    match file.as_str() {
        Some(name) => Ok(Some(name.to_owned())),
        None => Err(CaseError::at(format!("{place}/file"), "the name of a file", describe(file))),
    }
}

/// The file, which must lie inside the case's folder, links followed.
fn resolve(folder: &Path, name: &str, place: &str) -> Result<PathBuf, CaseError> {
    let inside = "a file inside the case's folder";
    let escapes = |found: &str| CaseError::at(format!("{place}/file"), inside, format!("{}, {found}", quote(name)));
    let path = Path::new(name);
    if path.is_absolute() {
        return Err(escapes("an absolute path").help("name it relative to the case's folder"));
    }
    if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) || name.is_empty() {
        return Err(escapes("which leaves the folder").help("copy the fabric file beside the case"));
    }
    let failed = |error: std::io::Error| escapes(&error.to_string());
    let folder = folder.canonicalize().map_err(failed)?;
    let path = folder.join(path).canonicalize().map_err(failed)?;
    if !path.starts_with(&folder) {
        return Err(escapes("a link that leaves the folder").help("copy the fabric file beside the case"));
    }
    Ok(path)
}

type FabricObject = (Map<String, Value>, Vec<(String, Value)>);

/// A fabric file without its `sources`, and these as pointers of a case with the fabric at `place`.
fn own_sources(value: Value, name: &str, place: &str) -> Result<FabricObject, CaseError> {
    let Value::Object(mut fabric) = value else {
        return Err(CaseError::at("line 1, column 1", "an object with the keys of \"fabric\"", describe(&value)));
    };
    let own = fabric.shift_remove("sources");
    let mut prefixed: Vec<(String, Value)> = Vec::new();
    if let Some(own) = own {
        sources::check(&own, places::COMMON, &Value::Object(fabric.clone()))?;
        let own = own.as_object().into_iter().flatten();
        prefixed.extend(own.map(|(pointer, text)| (format!("{place}{pointer}"), text.clone())));
    }
    if !prefixed.iter().any(|(pointer, _)| pointer == place) {
        prefixed.insert(0, (place.to_owned(), Value::from(name)));
    }
    Ok((fabric, prefixed))
}

/// What the case itself says about a fabric holds over what the file says.
fn add_sources(document: &mut Map<String, Value>, added: Vec<(String, Value)>, place: &str) {
    let sources = document.entry("sources").or_insert_with(|| Value::Object(Map::new()));
    let Value::Object(sources) = sources else { return };
    let of_case: Vec<String> = sources.keys().filter(|pointer| is_at_or_below(pointer, place)).cloned().collect();
    for (pointer, text) in added {
        if !of_case.iter().any(|above| is_at_or_below(&pointer, above)) {
            sources.insert(pointer, text);
        }
    }
}
