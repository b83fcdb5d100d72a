//! The pack: its plies, edges, mesh and initial state.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

use super::error::short_number_text;
use super::fixture::{Frame, Opening, Window, lies_across};
use super::grading::{GradingKeys, GradingWord};
use super::keys::{WordOr, choices};
use super::provenance::Provenance;
use super::{Accuracy, Case, CaseError, Fabric, Grading, Numerics, whole_elements};

/// Plies of a pack at most.
pub(super) const MAX_PLIES: u32 = 64;
/// List of groups of plies.
pub(super) const LAYUP: &str = "/pack/layup";
/// Elements along a side of a crossover around the hit.
const FINE: u32 = 4;
/// Elements along a side of a crossover where the result is to be converged.
const CONVERGED: u32 = 8;
/// Elements along a side of a crossover where a point strikes. A tip is held late where no node is under it; with four, oblique cones have
/// limits 6 % below those with eight, with six 1 %.
const UNDER_A_POINT: u32 = 6;
/// Elements along a side of a crossover, on an even mesh, where a bar strikes: the fewest with which strips break within 15 % of the closed form.
const ALONG_A_BAR: u32 = 2;

/// The pack: plies and the frame that holds them.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Pack {
    /// Number of plies; with a layup the sum over it, which need not be given.
    ///
    /// Default: a single ply.
    #[serde(default)]
    #[schemars(range(min = 1, max = MAX_PLIES), extend("default" = 1, "or" = "/layup"))]
    pub plies: u32,
    /// Size along warp, rounded to whole elements [m].
    #[schemars(rename = "width_mm", range(min = 1e-3, max = 1e5))]
    pub(super) width: f64,
    /// Size along weft, rounded to whole elements [m].
    #[schemars(rename = "height_mm", range(min = 1e-3, max = 1e5))]
    pub(super) height: f64,
    /// Boundary conditions of the sides.
    ///
    /// Default: a fixed frame, as in the paper.
    #[serde(deserialize_with = "edges")]
    #[schemars(with = "WordOr<Edge, Edges>", extend("default" = "clamped"))]
    pub edges: Edges,
    /// Circular opening of the frame in the middle of the pack. It clamps what lies outside, which is not computed; edges are clamped.
    ///
    /// Left out: the opening is width_mm × height_mm.
    pub window: Option<Window>,
    /// Side of square clamps at the four corners of the pack, which hold all displacements there; for packs whose sides are free [m].
    ///
    /// Default: no clamps there.
    #[schemars(rename = "corner_clamps_mm", range(min = 0, max = 1e5), extend("default" = 0))]
    pub corner_clamps: f64,
    /// Crossovers along each side of an element.
    ///
    /// Default: the paper: one element per crossover.
    #[schemars(range(min = 1, max = 64), extend("default" = 1))]
    pub crossovers_per_element: u32,
    /// Elements along each side of a crossover, to refine the mesh.
    ///
    /// Otherwise: numerics and accuracy: around a projectile's hit four elements per crossover (under a point six; converged: eight),
    /// graded beyond; where a bar strikes two (eight), even; one even element for the paper's numerics, no projectile, or several
    /// crossovers per element.
    #[serde(default)]
    #[schemars(range(min = 1, max = 16))]
    pub elements_per_crossover: u32,
    /// Elements that grow away from the hit; "graded" is an object without keys.
    ///
    /// Otherwise: numerics and accuracy: around a projectile's hit four elements per crossover (under a point six; converged: eight),
    /// graded beyond; where a bar strikes two (eight), even; one even element for the paper's numerics, no projectile, or several
    /// crossovers per element.
    pub(super) mesh_grading: Option<WordOr<GradingWord, GradingKeys>>,
    /// Distance of neighbouring plies' mid-planes; in a layup by default the mean of the two thicknesses [m].
    ///
    /// Otherwise: the fabric's thickness_mm.
    #[schemars(rename = "spacing_mm", range(min = 0, max = 100))]
    pub spacing: Option<f64>,
    /// Coulomb coefficient between plies.
    ///
    /// Default: assumed: not published for this fabric.
    #[schemars(range(min = 0, max = 2), extend("default" = 0.2))]
    pub friction: f64,
    /// Initial membrane force of every ply, along its own yarns; none where neither is above 0 [N/m].
    #[serde(deserialize_with = "pretension")]
    #[schemars(with = "Pretension", extend("default" = {}))]
    pub pretension: Option<[Option<f64>; 2]>,
    /// Velocity of every free node [m/s].
    ///
    /// Default: at rest.
    #[schemars(rename = "initial_velocity_m_s", inner(range(min = -5000, max = 5000)), extend("default" = [0, 0, 0]))]
    pub initial_velocity: [f64; 3],
    /// Initial amplitude·sin(mπX/width)·sin(nπY/height) of every ply, in its own axes.
    ///
    /// Left out: flat.
    pub initial_deflection: Option<InitialDeflection>,
    /// The plies in groups of consecutive ones, from the struck side, where they are not all alike.
    #[serde(default)]
    #[schemars(with = "Option<Vec<Layer>>", length(min = 1, max = MAX_PLIES))]
    pub layup: Vec<Layer>,
    /// Elements of a ply of the case's fabric.
    #[serde(skip)]
    pub mesh: MeshSize,
}

/// Consecutive plies that are alike.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Layer {
    /// Number of plies of this group.
    ///
    /// Default: a single ply.
    #[schemars(range(min = 1, max = MAX_PLIES), extend("default" = 1))]
    pub plies: u32,
    /// The fabric of these plies; a file is named relative to the case's folder.
    ///
    /// Otherwise: the case's fabric.
    pub fabric: Fabric,
    /// Angle of the warp to the pack's X axis, towards Y. At any angle the ply covers the opening of the frame [rad].
    ///
    /// Default: warp along the pack's X axis.
    #[schemars(rename = "orientation_deg", range(min = -360, max = 360), extend("default" = 0))]
    pub orientation: f64,
    /// Boundary conditions of the sides; sides left out of an object are clamped. At a multiple of 90 in the ply's own axes, at any other
    /// angle those of the pack.
    ///
    /// Otherwise: the pack's edges.
    #[serde(deserialize_with = "edges")]
    #[schemars(with = "WordOr<Edge, Edges>")]
    pub edges: Edges,
    /// Gap between this group and the one before it, added to spacing_mm there [m].
    ///
    /// Default: no gap.
    #[schemars(rename = "standoff_mm", range(min = 0, max = 1000), extend("default" = 0))]
    pub standoff: f64,
    /// Velocity of every free node, in the pack's axes [m/s].
    ///
    /// Otherwise: the pack's initial_velocity_m_s.
    #[schemars(rename = "initial_velocity_m_s", inner(range(min = -5000, max = 5000)))]
    pub initial_velocity: [f64; 3],
    /// Elements of each ply.
    #[serde(skip)]
    pub mesh: MeshSize,
}

/// Elements of a ply along warp (X) and weft (Y).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshSize {
    /// Number of elements of the finest size.
    pub count: [usize; 2],
    /// Undeformed length of the finest elements [m].
    pub length: [f64; 2],
    /// Growth of elements away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
    /// Frame around it.
    pub frame: Frame,
}

/// Keys of the initial membrane force.
#[derive(Deserialize, JsonSchema)]
struct Pretension {
    /// Force along warp per width [N/m].
    ///
    /// Left out: warp keeps its length.
    #[schemars(rename = "warp_n_per_m", range(min = 0, max = 1e7))]
    warp: Option<f64>,
    /// Force along weft per width [N/m].
    ///
    /// Left out: weft keeps its length.
    #[schemars(rename = "weft_n_per_m", range(min = 0, max = 1e7))]
    weft: Option<f64>,
}

fn pretension<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[Option<f64>; 2]>, D::Error> {
    let Pretension { warp, weft } = Pretension::deserialize(deserializer)?;
    // Without a force there is no stretch to look for: a crossover without friction carries none over a range of them.
    Ok([warp, weft].iter().flatten().any(|force| *force > 0.0).then_some([warp, weft]))
}

/// w = amplitude · sin(m π X/width) · sin(n π Y/height); 0 half waves along a direction: constant there.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct InitialDeflection {
    /// Largest deflection [m].
    #[schemars(rename = "amplitude_mm", range(min = -1000, max = 1000))]
    pub amplitude: f64,
    /// m; 0: constant along warp.
    #[schemars(range(min = 0, max = 1000))]
    pub warp_half_waves: u32,
    /// n; 0: constant along weft.
    #[schemars(range(min = 0, max = 1000))]
    pub weft_half_waves: u32,
}

/// Boundary condition of each side; X runs left to right along warp, Y bottom to top along weft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Edges {
    /// X = 0.
    ///
    /// Default: a fixed frame, as in the paper.
    #[schemars(extend("default" = "clamped"))]
    pub left: Edge,
    /// X = width.
    ///
    /// Default: a fixed frame, as in the paper.
    #[schemars(extend("default" = "clamped"))]
    pub right: Edge,
    /// Y = 0.
    ///
    /// Default: a fixed frame, as in the paper.
    #[schemars(extend("default" = "clamped"))]
    pub bottom: Edge,
    /// Y = height.
    ///
    /// Default: a fixed frame, as in the paper.
    #[schemars(extend("default" = "clamped"))]
    pub top: Edge,
}

impl Edges {
    /// Whether each of the four is this one.
    pub(crate) fn are_all(&self, edge: Edge) -> bool {
        [self.left, self.right, self.bottom, self.top] == [edge; 4]
    }

    /// Whether two opposite sides are clamped, so that the ply spans between them. A roller lets it move along its normal.
    pub fn span(&self) -> bool {
        [[self.left, self.right], [self.bottom, self.top]].contains(&[Edge::Clamped; 2])
    }
}

choices! {
    /// Boundary condition of one side.
    pub enum Edge {
        /// All displacements held.
        Clamped = "clamped",
        /// Nothing held.
        Free = "free",
        /// Displacement normal to the side held (symmetry plane).
        Roller = "roller",
    }
}

fn edges<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Edges, D::Error> {
    Ok(match WordOr::<Edge, Edges>::deserialize(deserializer)? {
        WordOr::Word(all) => Edges { left: all, right: all, bottom: all, top: all },
        WordOr::Keys(edges) => edges,
    })
}

/// Gives the groups of a layup what they do not say themselves; the document is complete but for that.
pub(super) fn share_with_layup(document: &mut Value) {
    let [edges, velocity] = ["edges", "initial_velocity"].map(|key| (key, document["pack"][key].clone()));
    let shared = [edges, velocity, ("fabric", document["fabric"].clone())];
    let groups = document["pack"].get_mut("layup").and_then(Value::as_array_mut);
    for group in groups.into_iter().flatten().filter_map(Value::as_object_mut) {
        for (key, value) in &shared {
            group.entry(*key).or_insert_with(|| value.clone());
        }
    }
}

impl Pack {
    /// Sizes of the pack along X and Y [m].
    pub(crate) fn size(&self) -> [f64; 2] {
        [self.width, self.height]
    }

    /// Sizes of the opening along X and Y [m].
    pub(crate) fn opening(&self) -> [f64; 2] {
        self.window.map_or([self.width, self.height], |window| [window.diameter; 2])
    }

    /// Crossovers along a side of the finest elements.
    pub(crate) fn crossovers_along_element(&self) -> f64 {
        f64::from(self.crossovers_per_element) / f64::from(self.elements_per_crossover)
    }

    /// Completes the number of plies: the sum over a layup.
    fn complete_plies(&mut self, record: &Provenance) -> Result<(), CaseError> {
        let sum: u32 = self.layup.iter().map(|layer| layer.plies).sum();
        if sum > MAX_PLIES {
            let expected = format!("at most {MAX_PLIES} plies over all groups");
            return Err(CaseError::at(LAYUP, expected, format!("{sum} plies")));
        }
        if self.plies == 0 {
            record.derive_text("/pack/plies", sum, "the sum over the layup", false);
        } else if self.plies != sum {
            let expected = format!("{sum}, the sum of the plies of {LAYUP}");
            let error = CaseError::at("/pack/plies", expected, self.plies.to_string());
            return Err(error.help("leave \"plies\" out: the layup says how many there are"));
        }
        self.plies = sum;
        Ok(())
    }
}

impl Case {
    /// Completes and checks the pack.
    pub(super) fn complete_pack(&mut self, record: &Provenance) -> Result<(), CaseError> {
        let (common, pack, projectile, solver) = (&self.fabric, &mut self.pack, self.projectile.as_ref(), &self.solver);
        let bar = projectile.is_some_and(|p| p.shape.is_bar());
        let finer = solver.numerics == Numerics::Default && pack.crossovers_per_element == 1 && projectile.is_some();
        if pack.elements_per_crossover == 0 {
            pack.elements_per_crossover = match (finer, solver.accuracy) {
                (false, _) => 1,
                (true, Accuracy::Converged) => CONVERGED,
                (true, Accuracy::Default) if bar => ALONG_A_BAR,
                (true, Accuracy::Default) if projectile.is_some_and(|p| p.shape.is_pointed()) => UNDER_A_POINT,
                (true, Accuracy::Default) => FINE,
            };
            record.derive_text("/pack/elements_per_crossover", pack.elements_per_crossover, "", false);
        }
        let (opening, side) = (pack.opening(), pack.crossovers_along_element());
        let (round, corner) = (pack.window.is_some(), pack.corner_clamps);
        // Elements of a ply of a fabric at an angle, of what stands at a pointer.
        let mesh = |at: &str, fabric: &Fabric, orientation: f64| {
            let length = [&fabric.warp, &fabric.weft].map(|yarn| side * 2.0 * yarn.half_span());
            let shape = Opening::of(round, orientation);
            let crossover = length.map(|length| length * (1.0 / side).round().max(1.0));
            let (size, how) = match shape {
                Opening::Mesh if lies_across(orientation) => ([opening[1], opening[0]], "the size"),
                Opening::Mesh => (opening, "the size"),
                _ => (shape.bounds(opening, orientation, crossover), "the bounds of the frame's opening"),
            };
            // Finer meshes cover the same cloth: whole crossovers.
            let count = whole_elements(at, size, length, (1.0 / side).round().max(1.0))?;
            let how = format!("{how} over the element length, to the nearest whole number of crossovers");
            record.derive_text(&format!("{at}/columns"), count[0], &how, false);
            record.derive_text(&format!("{at}/rows"), count[1], &how, false);
            let mut half = opening.map(|size| 0.5 * size);
            if shape == Opening::Mesh {
                half = [0, 1].map(|axis| 0.5 * count[axis] as f64 * length[axis]);
                half.rotate_left(usize::from(lies_across(orientation)));
            }
            Ok(MeshSize { count, length, grading: None, frame: Frame { opening: shape, half, corner } })
        };
        pack.mesh = mesh("/pack", common, 0.0)?;
        for (index, layer) in pack.layup.iter_mut().enumerate() {
            let at = format!("{LAYUP}/{index}");
            layer.complete(&at, common, record)?;
            layer.mesh = mesh(&at, &layer.fabric, layer.orientation)?;
        }
        if !pack.layup.is_empty() {
            pack.complete_plies(record)?;
        }
        self.check_fixture()?;
        let (common, pack) = (&self.fabric, &mut self.pack);
        if pack.spacing.is_none() {
            derive_spacing(common, &pack.layup, record);
        }
        let thickness = pack.layup.iter().map(|layer| layer.fabric.thickness);
        let thickest = thickness.reduce(f64::max).unwrap_or(common.thickness);
        let standoffs: f64 = pack.layup.iter().map(|layer| layer.standoff).sum();
        let depth = f64::from(pack.plies - 1) * pack.spacing.unwrap_or(thickest) + standoffs;
        // A bar meets whole rows of nodes, and sends waves along the whole of the strip: its mesh is even.
        let grading = self.graded(finer && !bar, depth, record)?;
        self.pack.layup.iter_mut().for_each(|layer| layer.mesh.grading = grading);
        self.pack.mesh.grading = grading;
        Ok(())
    }
}

impl Layer {
    /// Completes the fabric of the group at a pointer, and records what it shares with the pack.
    fn complete(&mut self, at: &str, common: &Fabric, record: &Provenance) -> Result<(), CaseError> {
        for key in ["edges", "initial_velocity_m_s"] {
            let (own, above) = (format!("{at}/{key}"), format!("/pack/{key}"));
            if !record.has(&own) {
                record.derive_text(&own, record.value(&above), "", record.is_assumed(&above));
            }
        }
        if record.has(&format!("{at}/fabric")) {
            return self.fabric.complete(&format!("{at}/fabric"), record);
        }
        record.derive_text(&format!("{at}/fabric"), &common.name, "", false);
        self.fabric = common.clone();
        Ok(())
    }
}

/// Records the spacing that follows from the thicknesses of neighbouring plies.
fn derive_spacing(fabric: &Fabric, layup: &[Layer], record: &Provenance) {
    let (at, common) = ("/pack/spacing_mm", "/fabric/thickness_mm");
    if layup.is_empty() {
        record.derive(at, fabric.thickness, "", record.is_assumed(common));
        return;
    }
    let assumed = (0..layup.len()).any(|index| {
        let own = format!("{LAYUP}/{index}{common}");
        record.is_assumed(if record.has(&own) { &own } else { common })
    });
    let within = layup.iter().filter(|layer| layer.plies > 1 || layup.len() == 1).map(|layer| layer.fabric.thickness);
    let between = layup.windows(2).map(|pair| 0.5 * (pair[0].fabric.thickness + pair[1].fabric.thickness));
    let spacings: Vec<f64> = within.chain(between).collect();
    let [least, most] = [f64::min, f64::max].map(|of| spacings.iter().copied().reduce(of).unwrap_or_default() * 1e3);
    let [least, most] = [least, most].map(short_number_text);
    let range = if least == most { least } else { format!("{least} to {most}") };
    record.derive_text(at, range, "the mean of the thickness_mm of the two plies", assumed);
}
