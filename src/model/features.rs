//! Which terms of the model a scene has. A backend leaves the others out.

use super::{Model, PlyType};
use crate::kernels::arc_length::MAX_TERMS;
use crate::kernels::crossover::Variant;
use crate::kernels::unit_cell_parameters::NEVER;

/// Terms of the model that a scene has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Features {
    /// Unit-cell law.
    pub law: Variant,
    /// The yarn whose height is the unknown of the unit cell: 0 warp, 1 weft.
    pub pivot: usize,
    /// The unit cell's joint iteration comes first.
    pub newton: bool,
    /// Terms of the arc length series.
    pub series: usize,
    /// Yarns flatten where they cross.
    pub compression: bool,
    /// Trellis shear.
    pub shear: bool,
    /// Its modulus is a secant one.
    pub secant: bool,
    /// Elements have hourglass stiffness.
    pub hourglass: bool,
    /// Stretches are means over an element, so that its yarns act on the hourglass mode too.
    pub mean_stretch: bool,
    /// Yarns may break.
    pub failure: bool,
    /// The unit-cell law makes energy by itself.
    pub law_energy: bool,
    /// They have shock viscosity.
    pub viscous: bool,
    /// Failure is judged over a length along the yarns.
    pub windows: bool,
    /// Pieces of yarn differ in strength.
    pub strength: bool,
    /// There is a projectile.
    pub projectile: bool,
    /// It rubs.
    pub friction: bool,
    /// The rim of its face is sampled too.
    pub edges: bool,
    /// It may turn.
    pub rotation: bool,
    /// There are plies that may touch each other.
    pub plies: bool,
    /// They rub.
    pub ply_friction: bool,
    /// Elements of a ply differ in size.
    pub graded: bool,
}

impl Features {
    /// The terms of one ply type of a model.
    pub fn new<S>(model: &Model<S>, ply_type: &PlyType<S>) -> Self {
        let yarns = &ply_type.cell.yarn;
        let projectile = model.projectile.as_ref();
        Self {
            law: ply_type.law,
            pivot: ply_type.cell.pivot,
            newton: ply_type.cell.newton,
            series: yarns.iter().map(|y| y.terms).max().unwrap_or(MAX_TERMS),
            compression: ply_type.cell.compression[0] > 0.0,
            shear: ply_type.has_shear,
            secant: ply_type.has_shear && ply_type.element.shear.secant > 0.0,
            hourglass: ply_type.element.hourglass.iter().any(|k| *k > 0.0),
            mean_stretch: ply_type.element.mode_share > 0.0,
            failure: (0..2).any(|i| ply_type.present[i] && yarns[i].failure_strain < NEVER),
            law_energy: ply_type.law_energy.is_some(),
            viscous: ply_type.viscous,
            windows: ply_type.windows.is_some(),
            strength: model.strength.is_some(),
            projectile: projectile.is_some(),
            friction: projectile.is_some() && model.friction > 0.0,
            edges: model.edges,
            rotation: projectile.is_some_and(|p| !p.locked),
            plies: model.plies.len() > 1,
            ply_friction: model.plies.len() > 1 && model.ply_friction > 0.0,
            graded: ply_type.mesh.is_graded(),
        }
    }

    /// What any ply type of a pack has; law, pivot and series are those of the struck ply.
    pub(super) fn of_pack<S>(model: &Model<S>) -> Self {
        let first = Self::new(model, &model.ply_types[0]);
        model.ply_types[1..].iter().map(|ply_type| Self::new(model, ply_type)).fold(first, |all, ply_type| Self {
            compression: all.compression | ply_type.compression,
            shear: all.shear | ply_type.shear,
            secant: all.secant | ply_type.secant,
            hourglass: all.hourglass | ply_type.hourglass,
            mean_stretch: all.mean_stretch | ply_type.mean_stretch,
            failure: all.failure | ply_type.failure,
            law_energy: all.law_energy | ply_type.law_energy,
            viscous: all.viscous | ply_type.viscous,
            windows: all.windows | ply_type.windows,
            graded: all.graded | ply_type.graded,
            ..all
        })
    }

    /// Name and value of each term, as in `summary.json`.
    pub fn list(&self) -> [(&'static str, String); 10] {
        let law = match self.law {
            Variant::PublishedTension => "published, tension",
            Variant::PublishedProjected => "published, projected",
            Variant::Variational => "variational",
            Variant::Kawabata => "kawabata",
        };
        let shear = match (self.shear, self.secant) {
            (false, _) => "no",
            (true, false) => "tangent",
            (true, true) => "secant",
        };
        let word = |yes: bool| if yes { "yes" } else { "no" };
        [
            ("law", law),
            ("compression", word(self.compression)),
            ("shear", shear),
            ("hourglass", word(self.hourglass)),
            ("failure", word(self.failure)),
            ("projectile", word(self.projectile)),
            ("friction", word(self.friction)),
            ("rotation", word(self.rotation)),
            ("ply contact", word(self.plies)),
            ("ply friction", word(self.ply_friction)),
        ]
        .map(|(name, value)| (name, value.to_owned()))
    }
}
