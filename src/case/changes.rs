//! Changes of a document: `--set /json/pointer=value`, and cases written in Rust, which are the same document as a file's.

use serde_json::{Map, Value, json};
use twox_hash::XxHash3_64;

use super::error::{describe, index, is_at_or_below, nearest, quote, short_number_text, text_of, unescape};
use super::fabric::{around, holds_fabrics, make_own};
use super::keys::{Key, lookup, object, pointers};
use super::provenance::{is_assumed, source};
use super::{Case, CaseError, Edge, read};

/// The source of what a user changes on the command line, and the first word of the place of its errors.
pub(super) const FLAG: &str = "--set";
/// The source of a value that a program sets, of which nothing else is said.
pub(super) const BY: &str = "set by a program";
/// Values longer than this stand in names as a hash [characters].
const LONGEST_VALUE: usize = 24;
/// Names of changes longer than this become a hash [characters].
const LONGEST_NAME: usize = 100;

/// A fabric that comes with ripstop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BuiltInFabric {
    /// Kevlar 129, 1420 denier, 20 per inch, 255 g/m²: the paper's first.
    S720,
    /// Kevlar 129, 1500 denier, 17 per inch, 231 g/m²: the paper's second.
    S728,
    /// Kevlar KM2 style 706, 600 denier, 34 per inch, 180 g/m²; crimp is assumed.
    Km2S706,
    /// Kevlar 29 style 745, 3000 denier, 17 per inch, 475 g/m²; crimp follows from that.
    Kevlar29S745,
    /// Kevlar 49, 17 per inch; linear density and crimp are assumed.
    Kevlar49,
    /// Twaron CT 612, 550 dtex, 11 per cm, 121 g/m²; mostly assumed.
    TwaronCt612,
    /// Twaron CT 709, 930 dtex, 10.5 per cm, 200 g/m²; moduli and crimp are assumed.
    TwaronCt709,
}

/// Fabrics with their names in a case and their texts.
const BUILT_IN: [(BuiltInFabric, &str, &str); 7] = [
    (BuiltInFabric::S720, "fabrics/s-720.json", include_str!("../../cases/fabrics/s-720.json")),
    (BuiltInFabric::S728, "fabrics/s-728.json", include_str!("../../cases/fabrics/s-728.json")),
    (BuiltInFabric::Km2S706, "fabrics/km2-s706.json", include_str!("../../cases/fabrics/km2-s706.json")),
    (BuiltInFabric::Kevlar29S745, "fabrics/kevlar29-s745.json", include_str!("../../cases/fabrics/kevlar29-s745.json")),
    (BuiltInFabric::Kevlar49, "fabrics/kevlar49-17x17.json", include_str!("../../cases/fabrics/kevlar49-17x17.json")),
    (BuiltInFabric::TwaronCt612, "fabrics/twaron-ct612.json", include_str!("../../cases/fabrics/twaron-ct612.json")),
    (BuiltInFabric::TwaronCt709, "fabrics/twaron-ct709.json", include_str!("../../cases/fabrics/twaron-ct709.json")),
];

impl BuiltInFabric {
    /// Name of the fabric in a case.
    pub fn file(self) -> &'static str {
        BUILT_IN.iter().find(|(fabric, ..)| *fabric == self).map_or("", |(_, name, _)| name)
    }
}

/// The text of a fabric that is built into the program, by its name in a case: `fabrics/s-720.json`.
pub fn builtin_fabric(file: &str) -> Option<&'static str> {
    BUILT_IN.iter().find(|(_, name, _)| *name == file).map(|(.., text)| *text)
}

/// One change: the pointer and the value it gets.
pub(super) struct Change {
    pub(super) pointer: String,
    value: Value,
}

/// Reads `/json/pointer=value`; a value that is not JSON is a word.
pub(super) fn parse(text: &str) -> Result<Change, CaseError> {
    let refused = |place: &str, expected: &str, found: &str| {
        let help = "for example --set /projectile/velocity_m_s=200";
        Err(CaseError::at(located(place), expected, found).help(help))
    };
    let form = "/json/pointer=value";
    match text.split_once('=') {
        None => refused(text, form, &format!("{}, which has no =", quote(text))),
        Some((pointer, _)) if !is_pointer(pointer) => refused(text, form, &format!("the pointer {}", quote(pointer))),
        Some((pointer, value)) if value.trim().is_empty() => refused(pointer, "a value after =", "nothing"),
        Some((pointer, value)) => match read::parse(value) {
            Ok(value) => Change::new(pointer, value),
            Err(error) if value.trim_start().starts_with(['{', '[', '"']) => {
                let found = format!("{} ({})", error.found, error.location);
                Err(CaseError { location: located(pointer), found, ..error })
            }
            Err(_) => Change::new(pointer, Value::from(value.trim())),
        },
    }
}

/// Whether a text has the form of a JSON pointer to a key.
fn is_pointer(text: &str) -> bool {
    text.starts_with('/') && !text.ends_with('/') && !text.contains("//")
}

/// Place of an error that a change on the command line caused.
pub(super) fn located(pointer: &str) -> String {
    let short: String = pointer.chars().filter(|c| !c.is_control()).take(200).collect();
    format!("{FLAG} {short}")
}

impl Change {
    /// A change to a value that is at hand.
    fn new(pointer: &str, value: Value) -> Result<Self, CaseError> {
        if !is_pointer(pointer) {
            let expected = "a JSON pointer, for example /projectile/velocity_m_s";
            return Err(CaseError::at(pointer, expected, quote(pointer)));
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

    /// Puts the value in its place, creating objects that the case file knows.
    fn put(&self, document: &mut Value) -> Result<(), CaseError> {
        if let Some(place) = around(&self.pointer).filter(|place| *place != self.pointer) {
            make_own(document, place);
        }
        for (end, _) in self.pointer.match_indices('/').skip(1) {
            let place = &self.pointer[..end];
            if document.pointer(place).is_none_or(Value::is_null) {
                insert(document, place, created(place)?)?;
            }
        }
        insert(document, &self.pointer, self.value.clone())
    }

    /// Makes the change, and drops what the case says about the old value: the source of the new one is `by`.
    pub(super) fn apply(&self, document: &mut Value, by: &str) -> Result<(), CaseError> {
        self.put(document)?;
        if ["/title", "/notes", "/expect", "/sources"].iter().any(|above| is_at_or_below(&self.pointer, above)) {
            return Ok(());
        }
        let Some(sources) = sources(document) else { return Ok(()) };
        let is_assumed = source(sources, &self.pointer).is_some_and(is_assumed);
        let text = if is_assumed { format!("assumed, {by}") } else { by.to_owned() };
        sources.retain(|pointer, _| !is_at_or_below(pointer, &self.pointer));
        // A fabric's file brings its own sources.
        if !(self.is_fabric() && self.value.get("file").is_some()) {
            sources.insert(self.pointer.clone(), Value::from(text));
        }
        Ok(())
    }
}

/// The sources of a document; `None` where they are no object.
pub(super) fn sources(document: &mut Value) -> Option<&mut Map<String, Value>> {
    document.as_object_mut()?.entry("sources").or_insert_with(|| json!({})).as_object_mut()
}

/// Puts a value in its place in an object or a list.
fn insert(document: &mut Value, pointer: &str, value: Value) -> Result<(), CaseError> {
    let (above, last) = pointer.rsplit_once('/').unwrap_or_default();
    match document.pointer_mut(above) {
        Some(Value::Object(map)) => drop(map.insert(unescape(last), value)),
        Some(Value::Array(items)) => {
            let expected = format!("an index from 0 to {}", items.len().saturating_sub(1));
            let item = index(last).and_then(|index| items.get_mut(index));
            *item.ok_or_else(|| CaseError::at(pointer, expected, quote(last)))? = value;
        }
        found => return Err(no_children(above, found.as_deref())),
    }
    Ok(())
}

/// Value of a place before anything is put into it: an object without keys, or the default list.
fn created(place: &str) -> Result<Value, CaseError> {
    let Some(Key { node, .. }) = lookup(place) else {
        let known = pointers();
        let near = nearest(place, known.iter().map(String::as_str)).map(|near| format!("did you mean {near}?"));
        let error = CaseError::at(place, "a pointer into the case", format!("nothing at {}", quote(place)));
        return Err(CaseError { help: near, ..error });
    };
    match &node["default"] {
        list @ Value::Array(_) => Ok(list.clone()),
        _ if node["type"] != "array" && object(node).is_some() || node["propertyNames"].is_object() => Ok(json!({})),
        _ => Err(no_children(place, None)),
    }
}

fn no_children(place: &str, found: Option<&Value>) -> CaseError {
    let found = found.map_or_else(|| "nothing".to_owned(), describe);
    CaseError::at(place, format!("an object or a list at {place}"), found).help(format!("set {place} as a whole"))
}

/// The last part of a pointer, with the one before it where other keys end alike.
fn short_name(pointer: &str) -> String {
    let mut parts = pointer.rsplit('/');
    let [last, above] = [(); 2].map(|()| parts.next().unwrap_or_default());
    let alike = pointers().iter().filter(|known| known.rsplit('/').next() == Some(last)).count();
    let is_alone = above.is_empty() || alike <= 1 && index(last).is_none();
    if is_alone { last.to_owned() } else { format!("{above}.{last}") }
}

/// Title with this velocity [m/s] in place of its own, or without one.
pub fn with_velocity(title: &str, velocity: Option<f64>) -> String {
    let parts = title.split_once(" m/s").and_then(|(before, after)| Some((before.rsplit_once(" at ")?, after)));
    match parts.filter(|((_, number), _)| number.parse::<f64>().is_ok()) {
        Some(((before, _), after)) => {
            let at = velocity.map_or_else(String::new, |velocity| format!(" at {} m/s", short_number_text(velocity)));
            format!("{before}{at}{after}")
        }
        None => title.to_owned(),
    }
}

/// A change for the name of a folder: `+velocity_m_s=200`; any file system takes it.
fn in_name((name, value): &(String, &Value)) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || ".-_".contains(c);
    let text = text_of(value);
    let is_plain = text.len() <= LONGEST_VALUE && text.chars().all(plain);
    format!("+{name}={}", if is_plain { text } else { hash(&value.to_string()) })
}

fn hash(text: &str) -> String {
    format!("{:08x}", (XxHash3_64::oneshot(text.as_bytes()) >> 32) as u32)
}

impl Case {
    /// Names the changes that a case was read with in its title and its name, so that its results are not taken for those of the file.
    pub fn name_changes(&mut self, sets: &[String]) {
        let sets: Vec<Change> = sets.iter().filter_map(|text| parse(text).ok()).collect();
        let same_shot = ["/$schema", "/title", "/notes", "/expect", "/sources", "/output"];
        let is_last = |(at, set): &(usize, &Change)| !sets[at + 1..].iter().any(|later| later.pointer == set.pointer);
        let kept = sets.iter().enumerate().filter(is_last).map(|(_, set)| set);
        let kept = kept.filter(|set| !same_shot.iter().any(|above| is_at_or_below(&set.pointer, above)));
        let changes: Vec<(String, &Value)> = kept.map(|set| (short_name(&set.pointer), &set.value)).collect();
        let name: String = changes.iter().map(in_name).collect();
        self.name += &match name.len() <= LONGEST_NAME {
            true => name,
            false => format!("+{}-changes-{}", changes.len(), hash(&name)),
        };
        if changes.is_empty() || sets.iter().any(|set| set.pointer == "/title") {
            return;
        }
        let words: Vec<String> = changes.iter().map(|(name, value)| format!("{name} = {}", text_of(value))).collect();
        let velocity = self.projectile.as_ref().map(|projectile| projectile.velocity);
        if sets.iter().any(|set| is_at_or_below("/projectile/velocity_m_s", &set.pointer)) {
            self.title = with_velocity(&self.title, velocity);
        }
        self.title += &format!(" [{}]", words.join(", "));
        self.as_run["title"] = json!(self.title);
    }

    /// A case to be written in Rust, with this title. Fabric and size have to be given, and all of a projectile where there is one.
    pub fn builder(title: impl Into<String>) -> CaseBuilder {
        CaseBuilder { name: "case".to_owned(), document: Ok(json!({"title": title.into()})) }
    }

    /// The case with another value for the key that a JSON pointer names, checked like a new one; name and title stay.
    ///
    /// ```
    /// # let case = ripstop::Case::builder("a ply").fabric(ripstop::BuiltInFabric::S720).size_mm(40.0, 40.0)
    /// #     .sphere_mm(6.0).mass_g(1.0).velocity_m_s(120.0).build()?;
    /// let faster = case.with("/projectile/velocity_m_s", 150)?;
    /// # assert_eq!(faster.projectile.map(|projectile| projectile.velocity), Some(150.0));
    /// # Ok::<(), ripstop::CaseError>(())
    /// ```
    ///
    /// # Errors
    /// The refusal of the case so changed.
    pub fn with(&self, pointer: &str, value: impl Into<Value>) -> Result<Self, CaseError> {
        let change = Change::new(pointer, value.into()).map_err(|error| error.in_file(&self.name))?;
        self.changed(&self.name, &[change], BY)
    }

    /// The case with changes `/json/pointer=value`, as the command line's `--set` makes them, named after them.
    ///
    /// # Errors
    /// As of [`case::read`](crate::case::read).
    pub fn with_sets(&self, sets: &[String]) -> Result<Self, CaseError> {
        let path = self.path.display().to_string();
        let file = if path.is_empty() { &self.name } else { &path };
        let changes = sets.iter().map(|text| parse(text)).collect::<Result<Vec<_>, _>>();
        let mut case = self.changed(file, &changes.map_err(|error| error.in_file(file))?, FLAG)?;
        case.name_changes(sets);
        Ok(case)
    }

    fn changed(&self, file: &str, changes: &[Change], by: &str) -> Result<Self, CaseError> {
        let folder = Some(&*self.path).filter(|path| path.is_file()).map(read::folder_of);
        let changed = read::assemble_document(file, self.as_run.clone(), changes, by, folder)?;
        Ok(Self { name: self.name.clone(), path: self.path.clone(), ..changed })
    }
}

/// A case in the making. Methods are named as the keys of a case file, units included.
///
/// A key that has no method here is given by [`CaseBuilder::set`]. Nothing is checked before [`CaseBuilder::build`]. A value of which
/// nothing else is said has the source `set by a program`.
///
/// ```
/// use ripstop::{BuiltInFabric, Case, Edge};
///
/// let case = Case::builder("a small ply")
///     .fabric(BuiltInFabric::S720)
///     .size_mm(40.0, 40.0)
///     .edges(Edge::Clamped)
///     .sphere_mm(6.0)
///     .density_kg_m3(7850.0)
///     .velocity_m_s(120.0)
///     .set("/projectile/obliquity_deg", 30)
///     .build()?;
/// assert_eq!(case.pack.plies, 1);
/// # Ok::<(), ripstop::CaseError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use]
pub struct CaseBuilder {
    name: String,
    document: Result<Value, CaseError>,
}

impl CaseBuilder {
    /// The name of the case in errors, and of the folder of its results; `case` where none is given.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// A fabric that comes with ripstop.
    pub fn fabric(self, fabric: BuiltInFabric) -> Self {
        self.set("/fabric", json!({"file": fabric.file()}))
    }

    /// Size of the pack along warp and along weft [mm].
    pub fn size_mm(self, width: f64, height: f64) -> Self {
        self.set("/pack/width_mm", width).set("/pack/height_mm", height)
    }

    /// Plies of the pack; one where nothing is said.
    pub fn plies(self, plies: u32) -> Self {
        self.set("/pack/plies", plies)
    }

    /// Boundary condition of all four edges.
    pub fn edges(self, edges: Edge) -> Self {
        self.set("/pack/edges", edges.word())
    }

    /// A sphere strikes the pack.
    pub fn sphere_mm(self, diameter: f64) -> Self {
        self.set("/projectile/shape", "sphere").set("/projectile/diameter_mm", diameter)
    }

    /// A cylinder strikes the pack with its flat face.
    pub fn cylinder_mm(self, diameter: f64, length: f64) -> Self {
        let cylinder = self.set("/projectile/shape", "cylinder").set("/projectile/diameter_mm", diameter);
        cylinder.set("/projectile/length_mm", length)
    }

    /// Mass of the projectile [g].
    pub fn mass_g(self, mass: f64) -> Self {
        self.set("/projectile/mass_g", mass)
    }

    /// Density of the projectile, from which its mass follows [kg/m³].
    pub fn density_kg_m3(self, density: f64) -> Self {
        self.set("/projectile/density_kg_m3", density)
    }

    /// Impact velocity [m/s].
    pub fn velocity_m_s(self, velocity: f64) -> Self {
        self.set("/projectile/velocity_m_s", velocity)
    }

    /// When the run ends, if its outcome is not known before [µs].
    pub fn end_time_us(self, time: f64) -> Self {
        self.set("/solver/end_time_us", time)
    }

    /// Where the value of a key, or of all keys below it, comes from; a text that begins with `assumed` marks it as assumed.
    pub fn source(mut self, pointer: &str, text: impl Into<String>) -> Self {
        if let Ok(document) = &mut self.document {
            document["sources"][pointer] = Value::from(text.into());
        }
        self
    }

    /// Any key of a case file by its JSON pointer, in the unit that the key ends in.
    pub fn set(mut self, pointer: &str, value: impl Into<Value>) -> Self {
        let put = |mut document: Value| Change::new(pointer, value.into())?.put(&mut document).map(|()| document);
        self.document = self.document.and_then(put);
        self
    }

    /// The case, completed and checked like that of a file.
    ///
    /// # Errors
    /// Everything that is wrong key by key, else the first thing that does not go together.
    pub fn build(self) -> Result<Case, CaseError> {
        let mut document = self.document.map_err(|error| error.in_file(&self.name))?;
        if let Some(sources) = sources(&mut document) {
            sources.entry("").or_insert_with(|| json!(BY));
        }
        let case = read::assemble_document(&self.name, document, &[], BY, None)?;
        Ok(Case { name: self.name, ..case })
    }
}
