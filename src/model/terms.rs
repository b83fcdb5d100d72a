//! Which terms of the model a scene has. A backend leaves the others out.

use super::{Model, Sheet};
use crate::kernels::arc_length::MAX_TERMS;
use crate::kernels::cell_constants::NEVER;
use crate::kernels::crossover::Variant;

/// Terms of the model that a scene has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// Unit-cell law.
    pub law: Variant,
    /// The yarn whose height is the unknown of the unit cell: 0 warp, 1 weft.
    pub pivot: usize,
    /// The unit cell's joint iteration comes first.
    pub joint: bool,
    /// Terms of the arc length series.
    pub series: usize,
    /// Yarns flatten where they cross.
    pub compression: bool,
    /// Trellis shear.
    pub shear: bool,
    /// Its modulus is a secant one.
    pub secant: bool,
    /// Hourglass stiffness.
    pub hourglass: bool,
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
    pub rim: bool,
    /// It may turn.
    pub rotation: bool,
    /// There are plies that may touch each other.
    pub plies: bool,
    /// They rub.
    pub ply_friction: bool,
    /// Elements of a ply differ in size.
    pub graded: bool,
}

impl Terms {
    /// The terms of one sheet of a model.
    pub fn new<S>(model: &Model<S>, sheet: &Sheet<S>) -> Self {
        let yarns = &sheet.cell.yarn;
        let projectile = model.projectile.as_ref();
        Self {
            law: sheet.law,
            pivot: sheet.cell.pivot,
            joint: sheet.cell.joint,
            series: yarns.iter().map(|y| y.terms).max().unwrap_or(MAX_TERMS),
            compression: sheet.cell.compression[0] > 0.0,
            shear: sheet.has_shear,
            secant: sheet.has_shear && sheet.element.shear.secant > 0.0,
            hourglass: sheet.element.hourglass.iter().any(|k| *k > 0.0),
            failure: (0..2).any(|i| sheet.present[i] && yarns[i].failure_strain < NEVER),
            law_energy: sheet.law_energy.is_some(),
            viscous: sheet.viscous,
            windows: sheet.windows.is_some(),
            strength: model.strength.is_some(),
            projectile: projectile.is_some(),
            friction: projectile.is_some() && model.friction > 0.0,
            rim: model.rim,
            rotation: projectile.is_some_and(|p| !p.locked),
            plies: model.plies.len() > 1,
            ply_friction: model.plies.len() > 1 && model.ply_friction > 0.0,
            graded: sheet.mesh.is_graded(),
        }
    }

    /// What any sheet of a pack has; law, pivot and series are those of the struck ply.
    pub(super) fn of_pack<S>(model: &Model<S>) -> Self {
        let first = Self::new(model, &model.sheets[0]);
        model.sheets[1..].iter().map(|sheet| Self::new(model, sheet)).fold(first, |all, sheet| Self {
            compression: all.compression | sheet.compression,
            shear: all.shear | sheet.shear,
            secant: all.secant | sheet.secant,
            hourglass: all.hourglass | sheet.hourglass,
            failure: all.failure | sheet.failure,
            law_energy: all.law_energy | sheet.law_energy,
            viscous: all.viscous | sheet.viscous,
            windows: all.windows | sheet.windows,
            graded: all.graded | sheet.graded,
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
