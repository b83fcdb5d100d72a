//! One woven fabric.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::CaseError;
use super::keys::{WordOr, choices};
use super::provenance::Provenance;

/// Least b over a of (21) [N^(1/3)]: its cube is the force at which a crossover begins to stiffen, and has to be a number in single precision.
const LEAST_COMPRESSION: f64 = 1e-6;

/// One woven fabric (Table I of the paper plus what it leaves open).
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(extend("file" = true))]
pub struct Fabric {
    /// Designation.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Density of the fibre; gives the yarn's section [kg/m³].
    #[schemars(rename = "fibre_density_kg_m3", range(min = 100, max = 30_000))]
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
    /// Fibre elastic modulus [Pa].
    pub modulus: f64,
    /// Axial strain at which the yarn breaks [-].
    pub failure_strain: f64,
    /// Crossovers per metre along this yarn, m in (12): undeformed cell length 2·w0 = 1/count [1/m].
    pub count: f64,
    /// Crimp (14): yarn length over fabric length minus one [-].
    pub crimp: f64,
}

impl Default for Yarn {
    /// A yarn that carries nothing, weighs nothing and never breaks.
    fn default() -> Self {
        Self { present: false, linear_density: 0.0, modulus: 0.0, failure_strain: 1.0, count: 0.0, crimp: 0.0 }
    }
}

fn not<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    bool::deserialize(deserializer).map(|flag| !flag)
}

/// Keys of a yarn; those of a linear density and of a count are one number of [`Yarn`] each.
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
    #[schemars(range(min = 1e-6, max = 1e4), extend("only" = {"absent": "false"}))]
    modulus_gpa: f64,
    /// Axial strain at which the yarn breaks; 1: never.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0, "only" = {"absent": "false"}))]
    failure_strain: f64,
    /// Crossovers along this yarn per inch.
    #[schemars(range(min = 0.1, max = 1000), extend("group" = "count"))]
    count_per_inch: Option<f64>,
    /// Crossovers along this yarn per cm.
    #[schemars(range(min = 0.04, max = 400), extend("group" = "count"))]
    count_per_cm: Option<f64>,
    /// Yarn length over fabric length, minus one.
    #[schemars(range(min = 0, max = 0.5), extend("only" = {"absent": "false"}))]
    crimp: f64,
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
    #[schemars(rename = "g1_mpa", range(min = 0, max = 1e6), extend("default" = 10))]
    pub g1: f64,
    /// Modulus after locking, at least g1_mpa [Pa].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(rename = "g2_mpa", range(min = 0, max = 1e6), extend("default" = 1000))]
    pub g2: f64,
    /// Shear angle where locking begins [rad].
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(range(min = 0, max = 1.5), extend("unit" = "rad", "default" = 0.35))]
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
    #[non_exhaustive]
    pub enum MembraneForce {
        /// The yarn tension T.
        Tension = "tension",
    }
    /// Meaning of the modulus of (25).
    #[non_exhaustive]
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

    /// Undeformed half-span w0 = 1/(2·count) (12) [m].
    pub fn half_span(&self) -> f64 {
        0.5 / self.count
    }
}

impl Fabric {
    /// Completes and checks the fabric whose keys stand at the pointer `at`.
    pub(super) fn complete(&mut self, at: &str, record: &Provenance) -> Result<(), CaseError> {
        let at = |key: &str| format!("{at}{key}");
        let (warp, weft) = (&self.warp, &self.weft);
        if !warp.present && !weft.present {
            let error = CaseError::at(at(""), "at least one yarn", "both absent");
            return Err(error.help("leave \"absent\" out of \"warp\" or \"weft\""));
        }
        let per_area = |yarn: &Yarn, other: &Yarn| yarn.linear_density * (1.0 + yarn.crimp) * other.count;
        let sum = per_area(warp, weft) + per_area(weft, warp);
        let assumed = ["/warp", "/weft"].iter().any(|yarn| record.is_any_assumed(&at(yarn)));
        record.fill(&at("/areal_density_g_m2"), &mut self.areal_density, sum, "", assumed);
        self.crossover.complete(&at("/crossover/compression"))?;
        // The thickness may stand with the fabric or with its shear; both must agree.
        let [of_fabric, of_shear] = [at("/thickness_mm"), at("/shear/thickness_mm")];
        if record.has(&of_shear) {
            let (own, given) = (record.number(&of_shear), record.number(&of_fabric));
            if record.has(&of_fabric) && own != given {
                let error = CaseError::at(of_shear, format!("the thickness at {of_fabric}"), own);
                return Err(error.help("give one of the two: a fabric has one thickness"));
            }
            let own = record.si(&of_shear);
            record.fill(&of_fabric, &mut self.thickness, own, "shear's thickness_mm", record.is_assumed(&of_shear));
        } else if self.shear.is_some() {
            record.derive(&of_shear, self.thickness, "", record.is_assumed(&of_fabric));
        }
        let Some(Shear { g1, g2, gamma1, gamma2, .. }) = self.shear else { return Ok(()) };
        for (low, high, ordered) in [("g1_mpa", "g2_mpa", g1 <= g2), ("gamma1", "gamma2", gamma1 <= gamma2)] {
            if !ordered {
                let [low, above] = [low, high].map(|key| at(&format!("/shear/{key}")));
                let expected = format!("at most {high}, which is {}", record.value(&above));
                return Err(CaseError::at(&low, expected, record.value(&low)));
            }
        }
        Ok(())
    }
}

impl Crossover {
    /// Checks the compression, whose keys stand at the pointer `at`; constants that are both 0 are those of a rigid crossover.
    fn complete(&mut self, at: &str) -> Result<(), CaseError> {
        let Some(Compression { a, b }) = self.compression else { return Ok(()) };
        match (a > 0.0, b > 0.0) {
            (true, true) if b < LEAST_COMPRESSION * a => {
                let expected = format!("b_mm_n13 at least {LEAST_COMPRESSION:e} of a_mm, or both 0");
                let error = CaseError::at(at, expected, format!("{:e} of it", b / a));
                return Err(error.help("at the first touch such a crossover would be softer than numbers can tell"));
            }
            (true, true) => {}
            (false, false) => self.compression = None,
            (a_positive, _) => {
                let found = if a_positive { "b_mm_n13 = 0 with a_mm > 0" } else { "a_mm = 0 with b_mm_n13 > 0" };
                let error = CaseError::at(at, "a_mm and b_mm_n13 both above 0, or both 0", found);
                return Err(error.help("write \"compression\": \"rigid\" for a crossover without compression"));
            }
        }
        Ok(())
    }
}
