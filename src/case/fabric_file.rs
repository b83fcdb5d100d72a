//! Fabrics of a case: `/fabric`, and `/pack/layup/N/fabric` of plies that have their own. In the place of each may stand `{"file": …}`: the
//! fabric kept in a file, or built into the program.

use std::path::{Component, Path, PathBuf};

use serde_json::{Map, Value, json};

use super::check::check_sources;
use super::error::{CaseError, describe, escape, index, is_at_or_below, quote};
use super::pack::{LAYUP, MAX_PLIES};
use super::{read, set};

/// Pointer of the fabric of every ply that has none of its own.
const COMMON: &str = "/fabric";

/// A fabric that comes with ripstop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BuiltInFabric {
    /// Kevlar 129, 1420 denier, 20 per inch, 255 g/m²: the paper's first.
    S720,
    /// Kevlar 129, 1500 denier, 17 per inch, 231 g/m²: the paper's second.
    S728,
    /// Twaron CT 612, 550 dtex, 11 per cm, 121 g/m²; mostly assumed.
    TwaronCt612,
    /// Twaron CT 709, 930 dtex, 10.5 per cm, 200 g/m²; moduli and crimp are assumed.
    TwaronCt709,
}

impl BuiltInFabric {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::S720, Self::S728, Self::TwaronCt612, Self::TwaronCt709];

    /// Name of the fabric in a case.
    pub fn file(self) -> &'static str {
        self.parts().0
    }

    /// Keys and values of the fabric, with their sources, as JSON.
    pub fn text(self) -> &'static str {
        self.parts().1
    }

    fn parts(self) -> (&'static str, &'static str) {
        macro_rules! fabric {
            ($file:literal) => {
                ($file, include_str!(concat!("../../cases/", $file)))
            };
        }
        match self {
            Self::S720 => fabric!("fabrics/s-720.json"),
            Self::S728 => fabric!("fabrics/s-728.json"),
            Self::TwaronCt612 => fabric!("fabrics/twaron-ct612.json"),
            Self::TwaronCt709 => fabric!("fabrics/twaron-ct709.json"),
        }
    }
}

/// The text of a fabric that is built into the program, by its name in a case: `fabrics/s-720.json`.
pub fn builtin_fabric(file: &str) -> Option<&'static str> {
    BuiltInFabric::ALL.into_iter().find(|fabric| fabric.file() == file).map(BuiltInFabric::text)
}

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

/// The fabric that a pointer names or reaches into.
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
pub(super) fn holds_fabrics(pointer: &str) -> bool {
    let group = |rest: &str| rest.strip_prefix('/').is_some_and(|group| index(group).is_some());
    pointer.strip_prefix(LAYUP).is_some_and(|rest| rest.is_empty() || group(rest))
}

/// Gives the group whose fabric stands at `place` a copy of the common fabric, with its sources, where it has none of its own.
pub(super) fn make_own(document: &mut Value, place: &str) {
    let Some(common) = document.get("fabric").cloned() else { return };
    match document.pointer_mut(place.strip_suffix(COMMON).unwrap_or_default()) {
        Some(Value::Object(group)) if place != COMMON && !group.contains_key("fabric") => {
            group.insert("fabric".to_owned(), common);
        }
        _ => return,
    }
    let Some(sources) = set::sources(document) else { return };
    let inside = sources.iter().filter_map(|(pointer, text)| Some((pointer.strip_prefix(COMMON)?, text.clone())));
    let inside = inside.filter(|(inside, _)| inside.starts_with('/'));
    let mut copies: Vec<(String, Value)> = inside.map(|(inside, text)| (format!("{place}{inside}"), text)).collect();
    // Else a source of the pack would seem to be one of the fabric.
    let whole = [COMMON, ""].iter().find_map(|above| sources.get(*above)).cloned();
    copies.push((place.to_owned(), whole.unwrap_or_else(|| Value::from("case file"))));
    for (pointer, text) in copies {
        sources.entry(pointer).or_insert(text);
    }
}

/// Puts the fabrics of files in place of their names; returns the files that were read.
pub(super) fn inline(document: &mut Value, source: &FabricSource<'_>) -> Result<Vec<Inlined>, CaseError> {
    let mut inlined = Vec::new();
    // A longer layup will be refused: no need to read its files.
    let count = document.pointer(LAYUP).and_then(Value::as_array).map_or(0, Vec::len).min(MAX_PLIES as usize);
    let own = (0..count).map(|index| format!("{LAYUP}/{index}{COMMON}"));
    for place in std::iter::once(COMMON.to_owned()).chain(own) {
        let Some(name) = file_name(document.pointer(&place), &place)? else { continue };
        let (file, text) = text_of(&name, source, &place)?;
        let fabric = read::parse(&text).and_then(|value| own_sources(value, &name, &place));
        let (fabric, own) = fabric.map_err(|error| error.in_file(&file))?;
        if let Some(stands) = document.pointer_mut(&place) {
            *stands = fabric;
        }
        // What the case itself says about a fabric holds over what the file says.
        let Some(sources) = set::sources(document) else { continue };
        let of_case: Vec<String> = sources.keys().filter(|pointer| is_at_or_below(pointer, &place)).cloned().collect();
        sources.extend(own.into_iter().filter(|(own, _)| !of_case.iter().any(|above| is_at_or_below(own, above))));
        inlined.push(Inlined { place, name: file });
    }
    Ok(inlined)
}

/// The name of a file as errors say it, and its text.
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
    let escapes = |found: &str| {
        let found = format!("{}, {found}", quote(name));
        CaseError::at(format!("{place}/file"), "a file inside the case's folder", found)
    };
    let path = Path::new(name);
    if path.is_absolute() {
        return Err(escapes("an absolute path").help("name it relative to the case's folder"));
    }
    let beside = "copy the fabric file beside the case";
    if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) || name.is_empty() {
        return Err(escapes("which leaves the folder").help(beside));
    }
    let failed = |error: std::io::Error| escapes(&error.to_string());
    let folder = folder.canonicalize().map_err(failed)?;
    let path = folder.join(path).canonicalize().map_err(failed)?;
    if !path.starts_with(&folder) {
        return Err(escapes("a link that leaves the folder").help(beside));
    }
    Ok(path)
}

/// A fabric file without its `sources`, and these as pointers of a case with the fabric at `place`.
fn own_sources(mut fabric: Value, name: &str, place: &str) -> Result<(Value, Map<String, Value>), CaseError> {
    let mut all = Map::new();
    let Value::Object(keys) = &mut fabric else {
        return Err(CaseError::at("line 1, column 1", "an object with the keys of \"fabric\"", describe(&fabric)));
    };
    let own = keys.shift_remove("sources").unwrap_or_else(|| json!({}));
    check_sources(&own, COMMON, &fabric)?;
    let own = own.as_object().into_iter().flatten();
    let own = own.map(|(pointer, text)| (format!("{place}{pointer}"), text.clone()));
    all.insert(place.to_owned(), Value::from(name));
    all.extend(own);
    Ok((fabric, all))
}
