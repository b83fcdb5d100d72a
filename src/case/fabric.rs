//! One woven fabric: its keys, and its places in a case. `/fabric` is that of every ply, `/pack/layup/N/fabric` that of plies that have
//! their own; in the place of each may stand `{"file": …}`.

use std::iter::once;
use std::path::{Component, Path};

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::error::{check_sources, describe, escape, index, is_at_or_below, quote, short_number_text};
use super::keys::{WordOr, choices};
use super::pack::{LAYUP, MAX_PLIES};
use super::provenance::Provenance;
use super::yarn::{Yarn, YarnKeys};
use super::{CaseError, builtin_fabric, changes, read};

/// Pointer of the fabric of every ply that has none of its own.
pub(super) const COMMON: &str = "/fabric";
/// Least b over a of (21) [N^(1/3)]: its cube is the force at which a crossover begins to stiffen, and has to be a number in single precision.
const LEAST_COMPRESSION: f64 = 1e-6;

/// One woven fabric (Table I of the paper plus what it leaves open).
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Fabric {
    /// Designation.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Density of the fibre; gives the yarn's section [kg/m³].
    #[schemars(rename = "fibre_density_kg_m3", range(min = 100, max = 30_000), extend("help" = "1440, or \"1.44 g/cm3\""))]
    pub fibre_density: f64,
    /// Mass per area of the fabric [kg/m²].
    ///
    /// Otherwise: linear density × (1 + crimp) × count of both yarns.
    #[serde(default)]
    #[schemars(rename = "areal_density_g_m2", range(min = 0.01, max = 1e5))]
    pub areal_density: f64,
    /// Yarns along X.
    #[schemars(with = "YarnKeys")]
    pub warp: Yarn,
    /// Yarns along Y.
    #[schemars(with = "YarnKeys")]
    pub weft: Yarn,
    /// Interaction of warp and weft.
    #[schemars(extend("default" = {}))]
    pub crossover: Crossover,
    /// Thickness of the fabric: shear resultant and ply spacing [m].
    ///
    /// Default: assumed: not published for this fabric.
    #[serde(default)]
    #[schemars(rename = "thickness_mm", range(min = 1e-3, max = 100))]
    #[schemars(extend("default" = 0.30, "or" = "/shear/thickness_mm"))]
    pub thickness: f64,
    /// Resistance to trellis shear, (25) of the paper.
    #[schemars(with = "WordOr<NoShear, ShearKeys>", extend("default" = {}, "none" = "none"))]
    pub shear: Option<Shear>,
    /// Stress of the yarns by the rate of strain; null or absent: it is the same at any.
    ///
    /// Left out: yarns do not depend on the rate.
    pub rate: Option<Rate>,
}

/// Law of Cowper and Symonds: a yarn that is strained at a rate ε̇ has 1 + (ε̇/C)^(1/P) times its stress, and so its strength; the strain at
/// which it breaks is the same.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Rate {
    /// C, the rate at which stress has doubled; assumed unless `sources` has this very key [1/s].
    #[schemars(rename = "c_per_s", range(min = 1e-12, max = 1e15), extend("own_source" = true))]
    pub c: f64,
    /// P: stress rises with the power 1/P of the rate; assumed unless `sources` has this very key.
    #[schemars(range(min = 1, max = 100), extend("own_source" = true))]
    pub p: f64,
}

/// Fastest strain that the law of the rate knows: what is faster has its stress [1/s].
const FASTEST: f64 = 1e5;

/// Most that the rate may add to a stress, over the stress [-].
const MOST_OF_RATE: f64 = 9.0;

impl Rate {
    /// Largest overstress of the rate over the stress [-].
    pub fn most(&self) -> f64 {
        (FASTEST / self.c).powf(1.0 / self.p)
    }
}

/// The warp–weft interaction law.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Crossover {
    /// Unit-cell law.
    ///
    /// Default: the paper's (11)-(24).
    #[schemars(extend("default" = "published"))]
    pub law: Law,
    /// In-plane force of the published law.
    ///
    /// Default: the paper's yarn tension.
    #[schemars(extend("default" = "tension"))]
    pub membrane_force: MembraneForce,
    /// Initial gap between the yarns, (22) [m].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(rename = "gap_mm", range(min = 0, max = 1), extend("default" = 0))]
    pub gap: f64,
    /// Transverse compression of the yarns, (21).
    #[schemars(with = "WordOr<NoCompression, Compression>", extend("default" = {}, "none" = "rigid"))]
    pub compression: Option<Compression>,
}

/// Constants of the transverse compression law (21).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Compression {
    /// Largest compression a of (21); a = b = 0 is rigid [m].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(rename = "a_mm", range(min = 0, max = 10), extend("default" = 0.10))]
    pub a: f64,
    /// b of (21) [m·N^(1/3)].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(rename = "b_mm_n13", range(min = 0, max = 10), extend("default" = 0.10))]
    pub b: f64,
}

/// Trellis shear (25).
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Shear {
    /// Modulus before locking [Pa].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(rename = "g1_mpa", range(min = 0, max = 1e6), extend("default" = 10, "at_most" = "g2_mpa"))]
    pub g1: f64,
    /// Modulus after locking, at least g1_mpa [Pa].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(rename = "g2_mpa", range(min = 0, max = 1e6), extend("default" = 1000))]
    pub g2: f64,
    /// Shear angle where locking begins [rad].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(range(min = 0, max = 1.5), extend("unit" = "rad", "default" = 0.35, "at_most" = "gamma2"))]
    pub gamma1: f64,
    /// Shear angle where locking is complete, at least gamma1 [rad].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(range(min = 0, max = 1.5), extend("unit" = "rad", "default" = 0.60))]
    pub gamma2: f64,
    /// Tangent: dτ/dγ = G(γ).
    ///
    /// Default: model: G of (25) as the slope of the stress.
    #[schemars(extend("default" = "tangent"))]
    pub modulus: ShearModulus,
}

/// Keys of [`Shear`], and the thickness, which belongs to the fabric as well.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
struct ShearKeys {
    /// Thickness that carries the shear stress.
    ///
    /// Otherwise: the fabric's thickness_mm.
    #[schemars(range(min = 1e-3, max = 100))]
    thickness_mm: Option<f64>,
    #[schemars(flatten)]
    shear: Shear,
}

choices! {
    /// Unit-cell law.
    #[derive(Default)]
    pub enum Law {
        /// The paper's (13)–(24): sinusoidal yarns, F = 2 T sin α.
        #[default]
        Published = "published" or "shahkarami_vaziri",
        /// Sinusoidal yarns, forces conjugate to the arc length: conserves energy to round-off.
        Variational = "variational",
    }
    /// In-plane force of the published law.
    pub enum MembraneForce {
        /// The yarn tension T.
        Tension = "tension",
    }
    /// Meaning of the modulus of (25).
    pub enum ShearModulus {
        /// dτ/dγ = G(γ).
        Tangent = "tangent",
    }
    pub(super) enum NoShear {
        None = "none",
    }
    pub(super) enum NoCompression {
        Rigid = "rigid",
    }
}

impl Fabric {
    /// Mass of the yarns per area [kg/m²].
    pub(crate) fn areal_density_of_yarns(&self) -> f64 {
        let per_area = |yarn: &Yarn, other: &Yarn| yarn.linear_density * (1.0 + yarn.crimp) * other.count;
        per_area(&self.warp, &self.weft) + per_area(&self.weft, &self.warp)
    }

    /// Completes and checks the fabric whose keys stand at the pointer `at`.
    pub(super) fn complete(&mut self, at: &str, record: &Provenance) -> Result<(), CaseError> {
        if !self.warp.present && !self.weft.present {
            let error = CaseError::at(at, "at least one yarn", "both absent");
            return Err(error.help("leave \"absent\" out of \"warp\" or \"weft\""));
        }
        self.complete_yarns(at, record)?;
        let at = |key: &str| format!("{at}{key}");
        let sum = self.areal_density_of_yarns();
        let assumed = record.is_assumed(&at("/warp")) || record.is_assumed(&at("/weft"));
        record.fill(&at("/areal_density_g_m2"), &mut self.areal_density, sum, "", assumed);
        self.crossover.complete(&at("/crossover/compression"))?;
        if let Some(rate) = self.rate.filter(|rate| rate.most() > MOST_OF_RATE) {
            let most = short_number_text(1.0 + MOST_OF_RATE);
            let expected =
                format!("constants with which a yarn has at most {most} times its stress at {FASTEST:e} 1/s");
            let found = format!("{} times", short_number_text((10.0 * (1.0 + rate.most())).round() / 10.0));
            return Err(
                CaseError::at(at("/rate"), expected, found).help("c_per_s is the rate at which stress has doubled")
            );
        }
        // The thickness may stand with the fabric or with its shear; both must agree.
        let [of_fabric, of_shear] = [at("/thickness_mm"), at("/shear/thickness_mm")];
        match record.si(&of_shear) {
            Some(own) if record.has(&of_fabric) && own != self.thickness => {
                let expected = format!("the thickness at {of_fabric}");
                let error = CaseError::at(&of_shear, expected, record.value(&of_shear));
                return Err(error.help("give one of the two: a fabric has one thickness"));
            }
            Some(own) => {
                let assumed = record.is_assumed(&of_shear);
                record.fill(&of_fabric, &mut self.thickness, own, "shear's thickness_mm", assumed);
            }
            None if self.shear.is_some() => {
                record.derive(&of_shear, self.thickness, "", record.is_assumed(&of_fabric));
            }
            None => {}
        }
        Ok(())
    }
}

impl Crossover {
    /// Checks the compression, whose keys stand at the pointer `at`; constants that are both 0 are those of a rigid crossover.
    fn complete(&mut self, at: &str) -> Result<(), CaseError> {
        let Some(Compression { a, b }) = self.compression else { return Ok(()) };
        if (a > 0.0) != (b > 0.0) || b < LEAST_COMPRESSION * a {
            let expected =
                format!("a_mm and b_mm_n13 above 0, b_mm_n13 at least {LEAST_COMPRESSION:e} of a_mm, or both 0");
            let [a, b] = [a, b].map(|constant| short_number_text(constant * 1e3));
            let error = CaseError::at(at, expected, format!("a_mm = {a} with b_mm_n13 = {b}"));
            return Err(error.help("write \"compression\": \"rigid\" for a crossover without compression"));
        }
        self.compression = self.compression.filter(|_| a > 0.0);
        Ok(())
    }
}

/// The fabric that a pointer names or reaches into.
pub(super) fn around(pointer: &str) -> Option<&str> {
    let group = pointer.strip_prefix(LAYUP).and_then(|rest| rest.strip_prefix('/')?.split_once('/'));
    let start = group.map_or(Some(0), |(group, _)| index(group).map(|_| LAYUP.len() + 1 + group.len()))?;
    is_at_or_below(&pointer[start..], COMMON).then(|| &pointer[..start + COMMON.len()])
}

/// Whether a pointer names the layup or one of its groups.
pub(super) fn holds_fabrics(pointer: &str) -> bool {
    let group = pointer.strip_prefix(LAYUP);
    group.is_some_and(|rest| rest.is_empty() || rest.strip_prefix('/').and_then(index).is_some())
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
pub(super) fn inline(document: &mut Value, folder: Option<&Path>) -> Result<Vec<(String, String)>, CaseError> {
    let mut inlined = Vec::new();
    // A longer layup will be refused: no need to read its files.
    let groups = document.pointer(LAYUP).and_then(Value::as_array).map_or(0, Vec::len).min(MAX_PLIES as usize);
    for place in once(COMMON.to_owned()).chain((0..groups).map(|group| format!("{LAYUP}/{group}{COMMON}"))) {
        let Some(stands) = document.pointer_mut(&place) else { continue };
        let Some(name) = file_name(stands, &place)?.map(str::to_owned) else { continue };
        let (file, text) = text_of(&name, folder, &place)?;
        let (fabric, own) = with_sources(&text, &name, &place).map_err(|error| error.in_file(&file))?;
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

/// Fabric of a text of its own without its `sources`, and these as pointers of a case with the fabric at `/fabric`; `name` is the source of
/// all that they do not name.
///
/// # Errors
/// A text that is no JSON object, and sources of what is not there.
pub fn fabric_from_str(name: &str, text: &str) -> Result<(Value, Map<String, Value>), CaseError> {
    with_sources(text, name, COMMON).map_err(|error| error.in_file(name))
}

/// Fabric of a text, and its sources in a case with the fabric at `place`.
fn with_sources(text: &str, name: &str, place: &str) -> Result<(Value, Map<String, Value>), CaseError> {
    let mut fabric = read::parse(text)?;
    let Value::Object(keys) = &mut fabric else {
        return Err(CaseError::at("line 1, column 1", "an object with the keys of \"fabric\"", describe(&fabric)));
    };
    let own = keys.shift_remove("sources").unwrap_or_else(|| json!({}));
    check_sources(&own, COMMON, &fabric)?;
    let own = own.as_object().into_iter().flatten().map(|(pointer, text)| (format!("{place}{pointer}"), text.clone()));
    Ok((fabric, once((place.to_owned(), Value::from(name))).chain(own).collect()))
}
