//! Places of fabrics in a case. `/fabric` is that of every ply, `/pack/layup/N/fabric` that of plies that have their own; in the place of each
//! may stand `{"file": …}`.

use std::iter::once;
use std::path::{Component, Path};

use serde_json::{Map, Value, json};

use super::super::error::{check_sources, describe, escape, index, is_at_or_below, quote};
use super::super::pack::{LAYUP, MAX_PLIES};
use super::super::{CaseError, builtin_fabric, changes, read};

/// Pointer of the fabric of every ply that has none of its own.
pub(super) const COMMON: &str = "/fabric";

/// The fabric that a pointer names or reaches into.
pub(in crate::case) fn around(pointer: &str) -> Option<&str> {
    let group = pointer.strip_prefix(LAYUP).and_then(|rest| rest.strip_prefix('/')?.split_once('/'));
    let start = group.map_or(Some(0), |(group, _)| index(group).map(|_| LAYUP.len() + 1 + group.len()))?;
    is_at_or_below(&pointer[start..], COMMON).then(|| &pointer[..start + COMMON.len()])
}

/// Whether a pointer names the layup or one of its groups.
pub(in crate::case) fn holds_fabrics(pointer: &str) -> bool {
    let group = pointer.strip_prefix(LAYUP);
    group.is_some_and(|rest| rest.is_empty() || rest.strip_prefix('/').and_then(index).is_some())
}

/// Gives the group whose fabric stands at `place` a copy of the common fabric, with its sources, where it has none of its own.
pub(in crate::case) fn make_own(document: &mut Value, place: &str) {
    let Some(common) = document.get("fabric").cloned() else { return };
    match document.pointer_mut(place.strip_suffix(COMMON).unwrap_or_default()) {
        Some(Value::Object(group)) if place != COMMON && !group.contains_key("fabric") => {
            group.insert("fabric".to_owned(), common);
        }
        _ => return,
    }
    let Some(sources) = changes::sources(document) else { return };
    // Else a source of the pack would seem to be one of the fabric.
    let whole = sources.get(COMMON).or(sources.get("")).cloned().unwrap_or_else(|| json!("case file"));
    let inside = |(pointer, text): (&String, &Value)| Some((pointer.strip_prefix(COMMON)?.to_owned(), text.clone()));
    let inside: Vec<_> = sources.iter().filter_map(inside).filter(|(inside, _)| inside.starts_with('/')).collect();
    for (inside, text) in inside.into_iter().chain(once((String::new(), whole))) {
        sources.entry(format!("{place}{inside}")).or_insert(text);
    }
}

/// Puts the fabrics of files in `folder`, or of those built in, in place of their names; returns place and file of each that was read.
pub(in crate::case) fn inline(document: &mut Value, folder: Option<&Path>) -> Result<Vec<(String, String)>, CaseError> {
    let mut inlined = Vec::new();
    // A longer layup will be refused: no need to read its files.
    let count = document.pointer(LAYUP).and_then(Value::as_array).map_or(0, Vec::len).min(MAX_PLIES as usize);
    let own = (0..count).map(|index| format!("{LAYUP}/{index}{COMMON}"));
    for place in once(COMMON.to_owned()).chain(own) {
        let Some(stands) = document.pointer_mut(&place) else { continue };
        let Some(name) = file_name(stands, &place)?.map(str::to_owned) else { continue };
        let (file, text) = text_of(&name, folder, &place)?;
        let fabric = read::parse(&text).and_then(|fabric| own_sources(fabric, &name, &place));
        let (fabric, own) = fabric.map_err(|error| error.in_file(&file))?;
        *stands = fabric;
        // What the case itself says about a fabric holds over what the file says.
        let Some(sources) = changes::sources(document) else { continue };
        let of_case: Vec<String> = sources.keys().filter(|pointer| is_at_or_below(pointer, &place)).cloned().collect();
        sources.extend(own.into_iter().filter(|(own, _)| !of_case.iter().any(|above| is_at_or_below(own, above))));
        inlined.push((place, file));
    }
    Ok(inlined)
}

/// The name in `{"file": name}`; `None` for a fabric written out in the case.
fn file_name<'a>(fabric: &'a Value, place: &str) -> Result<Option<&'a str>, CaseError> {
    if fabric.is_array() {
        let error = CaseError::at(place, "one fabric", "a list of fabrics");
        return Err(error.help("plies of different fabrics are listed in /pack/layup, one fabric in each item"));
    }
    let Some((map, file)) = fabric.as_object().and_then(|map| Some((map, map.get("file")?))) else { return Ok(None) };
    if let Some(other) = map.keys().find(|key| *key != "file") {
        let location = format!("{place}/{}", escape(other));
        let error = CaseError::at(location, "\"file\" alone", format!("{} beside it", quote(other)));
        return Err(error.help("write the fabric out in the case to change it, or use --set"));
    }
    let wrong = || CaseError::at(format!("{place}/file"), "the name of a file", describe(file));
    file.as_str().map(Some).ok_or_else(wrong)
}

/// The name of a file as errors say it, and its text. The file must lie inside the case's folder, links followed.
fn text_of(name: &str, folder: Option<&Path>, place: &str) -> Result<(String, String), CaseError> {
    let refused = |expected: &str, found: String| CaseError::at(format!("{place}/file"), expected, found);
    let Some(folder) = folder else {
        let help = "a case without a file of its own cannot name a fabric file; write it out";
        let text = builtin_fabric(name).ok_or_else(|| refused("a fabric that is built in", quote(name)).help(help))?;
        return Ok((format!("{name} (built in)"), text.to_owned()));
    };
    let outside = |why: &str| refused("a file inside the case's folder", format!("{}, {why}", quote(name)));
    let beside = "copy the fabric file beside the case";
    if Path::new(name).is_absolute() {
        return Err(outside("an absolute path").help("name it relative to the case's folder"));
    }
    let is_inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if !Path::new(name).components().all(is_inside) || name.is_empty() {
        return Err(outside("which leaves the folder").help(beside));
    }
    let canonical = |path: &Path| path.canonicalize().map_err(|error| outside(&error.to_string()));
    let path = canonical(&folder.join(name))?;
    if !path.starts_with(canonical(folder)?) {
        return Err(outside("a link that leaves the folder").help(beside));
    }
    let file = folder.join(name).display().to_string();
    let text = read::text_of_file(&path).map_err(|error| error.in_file(&file))?;
    Ok((file, text))
}

/// A fabric file without its `sources`, and these as pointers of a case with the fabric at `place`.
fn own_sources(mut fabric: Value, name: &str, place: &str) -> Result<(Value, Map<String, Value>), CaseError> {
    let Value::Object(keys) = &mut fabric else {
        return Err(CaseError::at("line 1, column 1", "an object with the keys of \"fabric\"", describe(&fabric)));
    };
    let own = keys.shift_remove("sources").unwrap_or_else(|| json!({}));
    check_sources(&own, COMMON, &fabric)?;
    let own = own.as_object().into_iter().flatten().map(|(pointer, text)| (format!("{place}{pointer}"), text.clone()));
    Ok((fabric, once((place.to_owned(), Value::from(name))).chain(own).collect()))
}
