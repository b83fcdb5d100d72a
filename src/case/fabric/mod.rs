//! One woven fabric: its keys.

mod place;
mod sheet;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::CaseError;
use super::error::short_number_text;
use super::keys::{WordOr, choices};
use super::provenance::Provenance;

pub(super) use place::{around, holds_fabrics, inline, make_own};
pub(super) use sheet::derive;

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

/// One yarn system.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default)]
pub struct Yarn {
    /// False when this yarn direction is absent (`"absent": true`): no tension, no crimp, only its count.
    #[serde(rename = "absent", deserialize_with = "not")]
    pub present: bool,
    /// Mass per length of the straight yarn [kg/m].
    pub linear_density: f64,
    /// Fibre elastic modulus; of a yarn with a curve, its steepest slope [Pa].
    pub modulus: f64,
    /// Strain [-] and stress [Pa] of points of a curve from nothing to break, both rising; none: stress is modulus times strain.
    pub curve: Vec<[f64; 2]>,
    /// Axial strain at which the virgin yarn breaks [-].
    pub failure_strain: f64,
    /// Part of that strain, and so of the strength, that is left in the fabric [-].
    pub strength_retention: f64,
    /// Crossovers per metre along this yarn, m in (12): undeformed cell length 2·w0 = 1/count [1/m].
    pub count: f64,
    /// Crimp (14): yarn length over fabric length minus one [-].
    pub crimp: f64,
}

impl Default for Yarn {
    /// A yarn that carries nothing, weighs nothing and never breaks.
    fn default() -> Self {
        let [linear_density, modulus, count, crimp] = [0.0; 4];
        let [failure_strain, strength_retention] = [1.0; 2];
        let curve = Vec::new();
        Self { present: false, linear_density, modulus, curve, failure_strain, strength_retention, count, crimp }
    }
}

fn not<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    bool::deserialize(deserializer).map(|flag| !flag)
}

/// Keys of a yarn.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
struct YarnKeys {
    /// True: no yarn in this direction, its count still sets the element size.
    ///
    /// Default: a woven fabric has both yarns.
    #[schemars(extend("default" = false))]
    absent: bool,
    /// Mass of 9000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_denier: Option<f64>,
    /// Mass of 1000 m of yarn.
    #[schemars(range(min = 0.001, max = 1e5), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_tex: Option<f64>,
    /// Mass of 10 000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_dtex: Option<f64>,
    /// Axial modulus of the fibre.
    #[schemars(range(min = 1e-6, max = 1e4), extend("group" = "modulus or curve", "only" = {"absent": "false"}))]
    modulus_gpa: Option<f64>,
    /// Strain and stress [GPa] of points from [0, 0] on, both rising, straight in between: in place of the modulus.
    #[schemars(length(min = 2, max = 16), inner(inner(range(min = 0, max = 1e4))))]
    #[schemars(extend("group" = "modulus or curve", "only" = {"absent": "false"}))]
    curve: Option<Vec<[f64; 2]>>,
    /// Axial strain at which the yarn breaks; 1: never.
    #[schemars(range(max = 1), extend("help" = "a part of one: 0.035, or \"3.5 %\"", "exclusiveMinimum" = 0, "group" = "failure strain or strength", "only" = {"absent": "false"}))]
    failure_strain: Option<f64>,
    /// Strength over linear density, in its place.
    #[schemars(range(min = 1e-3, max = 1e3), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    tenacity_g_den: Option<f64>,
    /// Strength over linear density, in its place.
    #[schemars(range(min = 1e-2, max = 1e4), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    tenacity_cn_tex: Option<f64>,
    /// Strength of the fibre, in its place.
    #[schemars(range(min = 1e-2, max = 1e6), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    strength_mpa: Option<f64>,
    /// Strength of the fibre, in its place.
    #[schemars(range(min = 1e-5, max = 1e3), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    strength_gpa: Option<f64>,
    /// Part of failure_strain, and so of strength, that a woven yarn keeps; assumed unless `sources` has this very key.
    ///
    /// Default: virgin yarn, as published.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0, "default" = 1, "only" = {"absent": "false"}, "own_source" = true))]
    strength_retention: f64,
    /// Crossovers along this yarn per inch: along the warp, the picks of a data sheet.
    #[schemars(range(min = 0.1, max = 1000), extend("group" = "count"))]
    count_per_inch: Option<f64>,
    /// Crossovers along this yarn per cm: along the warp, the picks of a data sheet.
    #[schemars(range(min = 0.04, max = 400), extend("group" = "count"))]
    count_per_cm: Option<f64>,
    /// Yarn length over fabric length, minus one.
    ///
    /// Otherwise: areal density over that of straight yarns, minus one; the same in both where both are left out.
    #[schemars(range(min = 0, max = 0.5), extend("only" = {"absent": "false"}))]
    crimp: Option<f64>,
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

impl Yarn {
    /// Fibre cross-section A = linear density / fibre density [m²].
    pub fn area(&self, fibre_density: f64) -> f64 {
        self.linear_density / fibre_density
    }

    /// Axial strain at which the yarn breaks as woven; `None`: never [-].
    pub fn breaking_strain(&self) -> Option<f64> {
        (self.failure_strain < 1.0).then_some(self.failure_strain * self.strength_retention)
    }

    /// Undeformed half-span w0 = 1/(2·count) (12) [m].
    pub fn half_span(&self) -> f64 {
        0.5 / self.count
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
        let at = |key: &str| format!("{at}{key}");
        let (warp, weft) = (&self.warp, &self.weft);
        if !warp.present && !weft.present {
            let error = CaseError::at(at(""), "at least one yarn", "both absent");
            return Err(error.help("leave \"absent\" out of \"warp\" or \"weft\""));
        }
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
