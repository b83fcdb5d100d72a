//! Features of a scene: terms of the model that it has. A backend leaves the others out.

use crate::case::Law;
use crate::model::Model;
use crate::model::ply_type::PlyType;
use crate::physics::arc_length::MAX_TERMS;
use crate::physics::unit_cell_parameters::NEVER;

/// Features of a scene.
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
    /// Friction acts on the projectile.
    pub friction: bool,
    /// The rim of its face is sampled too.
    pub edges: bool,
    /// Rotation of the projectile is free.
    pub rotation: bool,
    /// There are plies that may touch each other.
    pub plies: bool,
    /// Friction acts between plies.
    pub ply_friction: bool,
    /// Elements of a ply differ in size.
    pub graded: bool,
}

impl Features {
    /// Features of one ply type of a model.
    pub fn new<S>(model: &Model<S>, ply_type: &PlyType<S>) -> Self {
        Self::of_all(model, std::slice::from_ref(ply_type))
    }

    /// Features that any of these ply types has; law, pivot and series are those of the first.
    pub(super) fn of_all<S>(model: &Model<S>, ply_types: &[PlyType<S>]) -> Self {
        let any = |has: &dyn Fn(&PlyType<S>) -> bool| ply_types.iter().any(has);
        let (first, projectile) = (&ply_types[0], model.projectile.as_ref());
        Self {
            law: first.law,
            pivot: first.cell.pivot,
            series: first.cell.yarn.iter().map(|yarn| yarn.terms).max().unwrap_or(MAX_TERMS),
            compression: any(&|t| t.cell.compression[0] > 0.0),
            shear: any(&|t| t.has_shear),
            hourglass: any(&|t| t.element.hourglass.iter().any(|k| *k > 0.0)),
            mean_stretch: any(&|t| t.element.mode_share > 0.0),
            failure: any(&|t| (0..2).any(|i| t.present[i] && t.cell.yarn[i].failure_strain < NEVER)),
            law_energy: any(&|t| t.law_energy.is_some()),
            viscous: any(&|t| t.viscous),
            strength: model.strength.is_some(),
            projectile: projectile.is_some(),
            friction: projectile.is_some() && model.friction > 0.0,
            edges: model.edges,
            rotation: projectile.is_some_and(|p| !p.locked),
            plies: model.plies.len() > 1,
            ply_friction: model.plies.len() > 1 && model.ply_friction > 0.0,
            graded: any(&|t| t.mesh.is_graded()),
        }
    }

    /// Name and value of each feature, as in `summary.json`.
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
