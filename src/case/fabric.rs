//! One woven fabric: its keys, and the same in SI units.

use schemars::JsonSchema;
use serde::Deserialize;

use super::CaseError;
use super::provenance::Provenance;
use super::units::{Denier, Dtex, GM2, Gpa, KgM3, Mm, MmN13, Mpa, PerCm, PerInch, Rad, Tex, Text, WordOr, choices};

/// Source of a default that stands for a property of the fabric.
const NOT_PUBLISHED: &str = "assumed: not published for this fabric";
/// Least b over a of (21) [N^(1/3)]: its cube is the force at which a crossover begins to stiffen, and has to be a number in single precision.
const LEAST_COMPRESSION: f64 = 1e-6;

/// One woven fabric (Table I of the paper plus what it leaves open).
#[derive(Clone, Debug, PartialEq)]
pub struct Fabric {
    /// Designation, e.g. "S-720".
    pub name: String,
    /// Fibre density [kg/m³]; enters through the yarn's cross-section only.
    pub fibre_density: f64,
    /// Mass per area [kg/m²], given or derived from linear density, count and crimp.
    pub areal_density: f64,
    /// Yarns along X.
    pub warp: Yarn,
    /// Yarns along Y.
    pub weft: Yarn,
    /// Warp–weft interaction.
    pub crossover: Crossover,
    /// Trellis shear (25); `None` when the case has no shear.
    pub shear: Option<Shear>,
    /// Fabric thickness [m]: shear resultant and default ply spacing.
    pub thickness: f64,
}

/// One yarn system.
#[derive(Clone, Debug, PartialEq)]
pub struct Yarn {
    /// False when this yarn direction is absent (`"absent": true`): no tension, no crimp, only its count.
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

/// The warp–weft interaction law.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossover {
    /// Unit-cell law.
    pub law: Law,
    /// In-plane force of the published law.
    pub membrane_force: MembraneForce,
    /// Initial gap g between the yarns (22) [m].
    pub gap: f64,
    /// Transverse compression (21); `None` is a rigid crossover.
    pub compression: Option<Compression>,
}

/// Constants of the transverse compression law (21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compression {
    /// Largest transverse compression a [m].
    pub a: f64,
    /// b [m·N^(1/3)].
    pub b: f64,
}

/// Trellis shear (25).
#[derive(Clone, Debug, PartialEq)]
pub struct Shear {
    /// Modulus before locking [Pa].
    pub g1: f64,
    /// Modulus after locking [Pa].
    pub g2: f64,
    /// Shear angle where locking begins [rad].
    pub gamma1: f64,
    /// Shear angle where locking is complete [rad].
    pub gamma2: f64,
    /// How G enters the stress.
    pub modulus: ShearModulus,
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
    /// How the modulus of (25) is understood.
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

/// Keys of a fabric, of a case, of a group of plies, or of a file of its own.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(extend("file" = true))]
pub(super) struct FabricKeys {
    /// Designation.
    name: Text,
    /// Density of the fibre; gives the yarn's section.
    #[schemars(range(min = 100.0, max = 30_000.0))]
    fibre_density_kg_m3: KgM3,
    /// Mass per area of the fabric.
    #[schemars(range(min = 0.01, max = 1e5), extend("derived" = "linear density × (1 + crimp) × count of both yarns"))]
    areal_density_g_m2: Option<GM2>,
    /// Yarns along X.
    warp: YarnKeys,
    /// Yarns along Y.
    weft: YarnKeys,
    /// Interaction of warp and weft.
    #[schemars(extend("default" = {}))]
    crossover: CrossoverKeys,
    /// Thickness of the fabric: shear resultant and ply spacing.
    #[schemars(range(min = 1e-3, max = 100.0), extend("default" = 0.30, "source" = NOT_PUBLISHED, "or" = "/shear/thickness_mm"))]
    thickness_mm: Option<Mm>,
    /// Resistance to trellis shear, (25) of the paper.
    #[schemars(extend("default" = {}))]
    shear: WordOr<NoShear, ShearKeys>,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct YarnKeys {
    /// True: no yarn in this direction, its count still sets the element size.
    #[schemars(extend("default" = false, "source" = "a woven fabric has both yarns"))]
    absent: bool,
    /// Mass of 9000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": ["false"]}))]
    linear_density_denier: Option<Denier>,
    /// Mass of 1000 m of yarn.
    #[schemars(range(min = 0.001, max = 1e5), extend("group" = "linear density", "only" = {"absent": ["false"]}))]
    linear_density_tex: Option<Tex>,
    /// Mass of 10 000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": ["false"]}))]
    linear_density_dtex: Option<Dtex>,
    /// Axial modulus of the fibre.
    #[schemars(range(min = 1e-6, max = 1e4), extend("only" = {"absent": ["false"]}))]
    modulus_gpa: Option<Gpa>,
    /// Axial strain at which the yarn breaks; 1: never.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0, "only" = {"absent": ["false"]}))]
    failure_strain: Option<f64>,
    /// Crossovers along this yarn per inch.
    #[schemars(range(min = 0.1, max = 1000.0), extend("group" = "count"))]
    count_per_inch: Option<PerInch>,
    /// Crossovers along this yarn per cm.
    #[schemars(range(min = 0.04, max = 400.0), extend("group" = "count"))]
    count_per_cm: Option<PerCm>,
    /// Yarn length over fabric length, minus one.
    #[schemars(range(min = 0.0, max = 0.5), extend("only" = {"absent": ["false"]}))]
    crimp: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct CrossoverKeys {
    /// Unit-cell law.
    #[schemars(extend("default" = "published", "source" = "the paper's (11)-(24)"))]
    law: Law,
    /// In-plane force of the published law.
    #[schemars(extend("default" = "tension", "source" = "the paper's yarn tension"))]
    membrane_force: MembraneForce,
    /// Initial gap between the yarns, (22).
    #[schemars(range(min = 0.0, max = 1.0), extend("default" = 0.0, "source" = NOT_PUBLISHED))]
    gap_mm: Mm,
    /// Transverse compression of the yarns, (21).
    #[schemars(extend("default" = {}))]
    compression: WordOr<NoCompression, CompressionKeys>,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct CompressionKeys {
    /// Largest compression a of (21); a = b = 0 is rigid.
    #[schemars(range(min = 0.0, max = 10.0), extend("default" = 0.10, "source" = NOT_PUBLISHED))]
    a_mm: Mm,
    /// b of (21).
    #[schemars(range(min = 0.0, max = 10.0), extend("default" = 0.10, "source" = NOT_PUBLISHED))]
    b_mm_n13: MmN13,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct ShearKeys {
    /// Thickness that carries the shear stress.
    #[schemars(range(min = 1e-3, max = 100.0), extend("derived" = "the fabric's thickness_mm"))]
    thickness_mm: Option<Mm>,
    /// Modulus before locking.
    #[schemars(range(min = 0.0, max = 1e6), extend("default" = 10.0, "source" = NOT_PUBLISHED))]
    g1_mpa: Mpa,
    /// Modulus after locking, at least g1_mpa.
    #[schemars(range(min = 0.0, max = 1e6), extend("default" = 1000.0, "source" = NOT_PUBLISHED))]
    g2_mpa: Mpa,
    /// Shear angle where locking begins.
    #[schemars(range(min = 0.0, max = 1.5), extend("default" = 0.35, "source" = NOT_PUBLISHED))]
    gamma1: Rad,
    /// Shear angle where locking is complete, at least gamma1.
    #[schemars(range(min = 0.0, max = 1.5), extend("default" = 0.60, "source" = NOT_PUBLISHED))]
    gamma2: Rad,
    /// Tangent: dτ/dγ = G(γ).
    #[schemars(extend("default" = "tangent", "source" = "model: G of (25) as the slope of the stress"))]
    modulus: ShearModulus,
}

impl FabricKeys {
    /// The fabric whose keys stand at the pointer `at`.
    pub(super) fn fabric(self, at: &str, record: &Provenance) -> Result<Fabric, CaseError> {
        let [warp, weft] = [self.warp, self.weft].map(YarnKeys::yarn);
        if !warp.present && !weft.present {
            let error = CaseError::at(at, "at least one yarn", "both absent");
            return Err(error.help("leave \"absent\" out of \"warp\" or \"weft\""));
        }
        let areal_density = self.areal_density_g_m2.map(GM2::si).unwrap_or_else(|| {
            let per_area = |yarn: &Yarn, other: &Yarn| yarn.linear_density * (1.0 + yarn.crimp) * other.count;
            let assumed = ["warp", "weft"].iter().any(|yarn| record.is_any_assumed(&format!("{at}/{yarn}")));
            let sum = per_area(&warp, &weft) + per_area(&weft, &warp);
            record.derive(&format!("{at}/areal_density_g_m2"), sum, "", assumed)
        });
        let crossover = self.crossover.crossover(&format!("{at}/crossover"))?;
        let [of_fabric, of_shear] = ["thickness_mm", "shear/thickness_mm"].map(|key| format!("{at}/{key}"));
        let (given, own) = match &self.shear {
            WordOr::Keys(keys) => (self.thickness_mm, keys.thickness_mm),
            WordOr::Word(_) => (self.thickness_mm, None),
        };
        // The thickness may stand with the fabric or with its shear; both must agree.
        let thickness = match (given.map(Mm::si), own.map(Mm::si)) {
            (Some(given), Some(own)) if given != own => {
                let error = CaseError::at(&of_shear, format!("the thickness at {of_fabric}"), record.number(&of_shear));
                return Err(error.help("give one of the two: a fabric has one thickness"));
            }
            (Some(given), own) => {
                if own.is_none() && matches!(self.shear, WordOr::Keys(_)) {
                    record.derive(&of_shear, given, "", record.is_assumed(&of_fabric));
                }
                given
            }
            (None, own) => {
                let assumed = record.is_assumed(&of_shear);
                record.derive(&of_fabric, own.unwrap_or_default(), "shear's thickness_mm", assumed)
            }
        };
        let shear = match self.shear {
            WordOr::Word(_) => None,
            WordOr::Keys(keys) => Some(keys.shear(&format!("{at}/shear"), record)?),
        };
        let (name, fibre_density) = (self.name.0, self.fibre_density_kg_m3.si());
        Ok(Fabric { name, fibre_density, areal_density, warp, weft, crossover, shear, thickness })
    }
}

impl YarnKeys {
    /// The yarn; one that is absent carries nothing, weighs nothing and never breaks.
    fn yarn(self) -> Yarn {
        let linear_density = self.linear_density_denier.map(Denier::si);
        let linear_density = linear_density.or(self.linear_density_tex.map(Tex::si));
        Yarn {
            present: !self.absent,
            linear_density: linear_density.or(self.linear_density_dtex.map(Dtex::si)).unwrap_or(0.0),
            modulus: self.modulus_gpa.map_or(0.0, Gpa::si),
            failure_strain: self.failure_strain.unwrap_or(1.0),
            count: self.count_per_inch.map(PerInch::si).or(self.count_per_cm.map(PerCm::si)).unwrap_or_default(),
            crimp: self.crimp.unwrap_or(0.0),
        }
    }
}

impl CrossoverKeys {
    fn crossover(self, at: &str) -> Result<Crossover, CaseError> {
        let compression = match self.compression {
            WordOr::Word(_) => None,
            WordOr::Keys(keys) => keys.compression(&format!("{at}/compression"))?,
        };
        Ok(Crossover { law: self.law, membrane_force: self.membrane_force, gap: self.gap_mm.si(), compression })
    }
}

impl CompressionKeys {
    fn compression(self, at: &str) -> Result<Option<Compression>, CaseError> {
        let (a, b) = (self.a_mm.si(), self.b_mm_n13.si());
        match (a > 0.0, b > 0.0) {
            (true, true) if b < LEAST_COMPRESSION * a => {
                let expected = format!("b_mm_n13 at least {LEAST_COMPRESSION:e} of a_mm, or both 0");
                let error = CaseError::at(at, expected, format!("{:e} of it", b / a));
                Err(error.help("at the first touch such a crossover would be softer than numbers can tell"))
            }
            (true, true) => Ok(Some(Compression { a, b })),
            (false, false) => Ok(None),
            (a_positive, _) => {
                let found = if a_positive { "b_mm_n13 = 0 with a_mm > 0" } else { "a_mm = 0 with b_mm_n13 > 0" };
                let error = CaseError::at(at, "a_mm and b_mm_n13 both above 0, or both 0", found);
                Err(error.help("write \"compression\": \"rigid\" for a crossover without compression"))
            }
        }
    }
}

impl ShearKeys {
    fn shear(self, at: &str, record: &Provenance) -> Result<Shear, CaseError> {
        let [g1, g2] = [self.g1_mpa, self.g2_mpa].map(Mpa::si);
        let [gamma1, gamma2] = [self.gamma1, self.gamma2].map(Rad::si);
        for (low, high, ordered) in [("g1_mpa", "g2_mpa", g1 <= g2), ("gamma1", "gamma2", gamma1 <= gamma2)] {
            if !ordered {
                let [low, above] = [low, high].map(|name| format!("{at}/{name}"));
                let expected = format!("at most {high}, which is {}", record.value(&above));
                return Err(CaseError::at(&low, expected, record.value(&low)));
            }
        }
        Ok(Shear { g1, g2, gamma1, gamma2, modulus: self.modulus })
    }
}
