//! One woven fabric, in SI units.

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
    /// Which unit-cell law.
    pub law: Law,
    /// In-plane force of the published law.
    pub membrane_force: MembraneForce,
    /// Initial gap g between the yarns (22) [m].
    pub gap: f64,
    /// Transverse compression (21); `None` is a rigid crossover.
    pub compression: Option<Compression>,
}

/// Unit-cell law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Law {
    /// The paper's (13)–(24): sinusoidal yarns, F = 2 T sin α.
    #[default]
    Published,
    /// Sinusoidal yarns, forces conjugate to the arc length: conserves energy to round-off.
    Variational,
}

/// In-plane force of the published law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MembraneForce {
    /// The yarn tension T.
    Tension,
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

/// How the modulus of (25) is understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ShearModulus {
    /// dτ/dγ = G(γ).
    Tangent,
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
