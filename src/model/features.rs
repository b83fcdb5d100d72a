//! Which terms of the model a scene has. A backend leaves the others out.

use crate::case::Law;
use crate::model::Model;
use crate::model::ply_type::PlyType;
use crate::physics::arc_length::MAX_TERMS;
use crate::physics::unit_cell_parameters::NEVER;

/// Terms of the model that a scene has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Features {
    /// Unit-cell law.
    pub law: Law,
    /// The yarn whose height is the unknown of the unit cell: 0 warp, 1 weft.
    pub pivot: usize,
    /// Terms of the arc length series.
    pub series: usize,
    /// Yarns flatten where they cross.
    pub compression: bool,
    /// Trellis shear.
    pub shear: bool,
    /// Elements have hourglass stiffness.
    pub hourglass: bool,
    /// Stretches are means over an element, so that its yarns act on the hourglass mode too.
    pub mean_stretch: bool,
    /// Yarns may break.
    pub failure: bool,
    /// The unit-cell law makes energy by itself.
    pub law_energy: bool,
    /// Yarns have shock viscosity.
    pub viscous: bool,
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
            series: yarns.iter().map(|y| y.terms).max().unwrap_or(MAX_TERMS),
            compression: ply_type.cell.compression[0] > 0.0,
            shear: ply_type.has_shear,
            hourglass: ply_type.element.hourglass.iter().any(|k| *k > 0.0),
            mean_stretch: ply_type.element.mode_share > 0.0,
            failure: (0..2).any(|i| ply_type.present[i] && yarns[i].failure_strain < NEVER),
            law_energy: ply_type.law_energy.is_some(),
            viscous: ply_type.viscous,
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
            hourglass: all.hourglass | ply_type.hourglass,
            mean_stretch: all.mean_stretch | ply_type.mean_stretch,
            failure: all.failure | ply_type.failure,
            law_energy: all.law_energy | ply_type.law_energy,
            viscous: all.viscous | ply_type.viscous,
            graded: all.graded | ply_type.graded,
            ..all
        })
    }

    /// Name and value of each term, as in `summary.json`.
    pub fn list(&self) -> [(&'static str, String); 10] {
        let law = match self.law {
            Law::Published => "published, tension",
            Law::Variational => "variational",
        };
        let word = |yes: bool| if yes { "yes" } else { "no" };
        [
            ("law", law),
            ("compression", word(self.compression)),
            ("shear", if self.shear { "tangent" } else { "no" }),
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
