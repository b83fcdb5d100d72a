//! The pack: its plies, edges, mesh and initial state.

use std::f64::consts::FRAC_PI_2;

use schemars::JsonSchema;
use serde::Deserialize;

use super::fabric::FabricKeys;
use super::grading::{GradingKeys, GradingWord};
use super::provenance::Provenance;
use super::text::short_number_text;
use super::units::{Deg, MS, Mm, NM, WordOr, choices};
use super::{Accuracy, CaseError, Fabric, Grading, Numerics, Projectile, Solver, limits};

/// Plies of a pack at most.
pub(super) const MAX_PLIES: u32 = 64;
/// List of groups of plies.
pub(super) const LAYUP: &str = "/pack/layup";
/// Where the mesh comes from.
const MESH: &str = "numerics and accuracy: around a projectile's hit four elements per crossover (under a point six; converged: eight), \
    graded beyond; where a bar strikes two (eight), even; one even element for the paper's numerics, no projectile, or several \
    crossovers per element";
/// Where a default of an edge comes from.
const FRAME: &str = "a fixed frame, as in the paper";
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
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pack {
    /// Number of plies.
    pub plies: u32,
    /// Distance between mid-planes of neighbouring plies [m]; `None`: the mean of their two thicknesses.
    pub spacing: Option<f64>,
    /// Coulomb coefficient between plies [-].
    pub friction: f64,
    /// The plies in groups from the struck side, where they are not all of the case's fabric, laid alike; else empty.
    pub layup: Vec<Layer>,
    /// Elements of the finest size along warp (X); the asked width rounded to whole elements.
    pub columns: usize,
    /// Elements of the finest size along weft (Y).
    pub rows: usize,
    /// Undeformed length along warp of the finest elements [m].
    pub element_length_x: f64,
    /// Undeformed length along weft of the finest elements [m].
    pub element_length_y: f64,
    /// Crossovers along each side of an element of the finest size.
    pub crossovers_per_element: u32,
    /// Growth of elements away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
    /// Elements along each side of one crossover.
    pub elements_per_crossover: u32,
    /// Boundary conditions.
    pub edges: Edges,
    /// Initial membrane force per reference length [N/m] along warp and weft; `None` holds that stretch at 1.
    pub pretension: Option<[Option<f64>; 2]>,
    /// Uniform initial velocity of every free node [m/s].
    pub initial_velocity: [f64; 3],
    /// Initial sine deflection, if any.
    pub initial_deflection: Option<InitialDeflection>,
}

impl Pack {
    /// Crossovers along a side of the finest elements.
    pub(crate) fn crossovers_along_element(&self) -> f64 {
        f64::from(self.crossovers_per_element) / f64::from(self.elements_per_crossover)
    }
}

/// Consecutive plies that are alike.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Layer {
    /// Number of plies.
    pub plies: u32,
    /// Their fabric.
    pub fabric: Fabric,
    /// Angle of the warp to the pack's X axis, towards Y [rad]. The ply's own axes turn with it, its edges too.
    pub orientation: f64,
    /// Boundary conditions, in the ply's own axes.
    pub edges: Edges,
    /// Initial velocity of every free node, in the pack's axes [m/s].
    pub initial_velocity: [f64; 3],
    /// Elements of the finest size along warp.
    pub columns: usize,
    /// Elements of the finest size along weft.
    pub rows: usize,
    /// Undeformed length along warp of the finest elements [m].
    pub element_length_x: f64,
    /// Undeformed length along weft of the finest elements [m].
    pub element_length_y: f64,
    /// Growth of elements away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
}

/// w = amplitude · sin(m π X/width) · sin(n π Y/height); 0 half waves along a direction: constant there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InitialDeflection {
    /// [m]
    pub amplitude: f64,
    /// m
    pub warp_half_waves: u32,
    /// n
    pub weft_half_waves: u32,
}

/// Boundary condition of each side; X runs left to right along warp, Y bottom to top along weft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Edges {
    /// X = 0.
    #[schemars(extend("default" = "clamped", "source" = FRAME))]
    pub left: Edge,
    /// X = width.
    #[schemars(extend("default" = "clamped", "source" = FRAME))]
    pub right: Edge,
    /// Y = 0.
    #[schemars(extend("default" = "clamped", "source" = FRAME))]
    pub bottom: Edge,
    /// Y = height.
    #[schemars(extend("default" = "clamped", "source" = FRAME))]
    pub top: Edge,
}

impl Edges {
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

impl From<WordOr<Edge, Edges>> for Edges {
    fn from(given: WordOr<Edge, Edges>) -> Self {
        match given {
            WordOr::Word(all) => Self { left: all, right: all, bottom: all, top: all },
            WordOr::Keys(edges) => edges,
        }
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct PackKeys {
    /// Number of plies; with a layup the sum over it, which need not be given.
    #[schemars(range(min = 1, max = MAX_PLIES), extend("default" = 1, "source" = "a single ply", "or" = "/layup"))]
    plies: Option<u32>,
    /// Size along warp, rounded to whole elements.
    #[schemars(range(min = 1e-3, max = 1e5))]
    width_mm: Mm,
    /// Size along weft, rounded to whole elements.
    #[schemars(range(min = 1e-3, max = 1e5))]
    height_mm: Mm,
    /// How the sides are held.
    #[schemars(extend("default" = "clamped", "source" = FRAME))]
    edges: WordOr<Edge, Edges>,
    /// Crossovers along each side of an element.
    #[schemars(range(min = 1, max = 64), extend("default" = 1, "source" = "the paper: one element per crossover"))]
    crossovers_per_element: u32,
    /// Elements along each side of a crossover, to refine the mesh.
    #[schemars(range(min = 1, max = 16), extend("derived" = MESH))]
    elements_per_crossover: Option<u32>,
    /// Elements that grow away from the hit; "graded" is an object without keys.
    #[schemars(extend("derived" = MESH))]
    mesh_grading: Option<WordOr<GradingWord, GradingKeys>>,
    /// Distance of neighbouring plies' mid-planes; in a layup by default the mean of the two thicknesses.
    #[schemars(range(min = 0.0, max = 100.0), extend("derived" = "the fabric's thickness_mm"))]
    spacing_mm: Option<Mm>,
    /// Coulomb coefficient between plies.
    #[schemars(range(min = 0.0, max = 2.0), extend("default" = 0.2, "source" = "assumed: not published for this fabric"))]
    friction: f64,
    /// Initial membrane force of every ply, along its own yarns.
    #[schemars(extend("default" = {}))]
    pretension: PretensionKeys,
    /// Velocity of every free node.
    #[schemars(inner(range(min = -5000.0, max = 5000.0)), extend("default" = [0, 0, 0], "source" = "at rest"))]
    initial_velocity_m_s: [MS; 3],
    /// Initial amplitude·sin(mπX/width)·sin(nπY/height) of every ply, in its own axes.
    #[schemars(extend("without" = "flat"))]
    initial_deflection: Option<DeflectionKeys>,
    /// The plies in groups of consecutive ones, from the struck side, where they are not all alike.
    #[schemars(length(min = 1, max = MAX_PLIES))]
    layup: Option<Vec<LayerKeys>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct LayerKeys {
    /// Number of plies of this group.
    #[schemars(range(min = 1, max = MAX_PLIES), extend("default" = 1, "source" = "a single ply"))]
    plies: u32,
    /// The fabric of these plies; a file is named relative to the case's folder.
    #[schemars(extend("derived" = "the case's fabric"))]
    fabric: Option<FabricKeys>,
    /// Angle of the warp to the pack's X axis, towards Y. At a multiple of 90 the ply covers the pack's rectangle;
    /// at any other angle it is cut along its yarns, width along warp and height along weft, then laid turned.
    #[schemars(range(min = -360.0, max = 360.0), extend("default" = 0.0, "source" = "warp along the pack's X axis"))]
    orientation_deg: Deg,
    /// How the sides are held, in the ply's own axes; sides left out of an object are clamped.
    #[schemars(extend("derived" = "the pack's edges"))]
    edges: Option<WordOr<Edge, Edges>>,
    /// Velocity of every free node, in the pack's axes.
    #[schemars(inner(range(min = -5000.0, max = 5000.0)), extend("derived" = "the pack's initial_velocity_m_s"))]
    initial_velocity_m_s: Option<[MS; 3]>,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct PretensionKeys {
    /// Force along warp per width.
    #[schemars(range(min = 0.0, max = 1e7), extend("without" = "warp keeps its length"))]
    warp_n_per_m: Option<NM>,
    /// Force along weft per width.
    #[schemars(range(min = 0.0, max = 1e7), extend("without" = "weft keeps its length"))]
    weft_n_per_m: Option<NM>,
}

#[derive(Debug, Deserialize, JsonSchema)]
struct DeflectionKeys {
    /// Largest deflection.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    amplitude_mm: Mm,
    /// m; 0: constant along warp.
    #[schemars(range(min = 0, max = 1000))]
    warp_half_waves: u32,
    /// n; 0: constant along weft.
    #[schemars(range(min = 0, max = 1000))]
    weft_half_waves: u32,
}

impl PackKeys {
    pub(super) fn pack(
        self,
        fabric: &Fabric,
        projectile: Option<&Projectile>,
        solver: &Solver,
        record: &Provenance,
    ) -> Result<Pack, CaseError> {
        let bar = projectile.is_some_and(|p| p.shape.is_bar());
        let finer = solver.numerics == Numerics::Default && self.crossovers_per_element == 1 && projectile.is_some();
        let elements_per_crossover = self.elements_per_crossover.unwrap_or_else(|| {
            let count = match (finer, solver.accuracy) {
                (false, _) => 1,
                (true, Accuracy::Default) if bar => ALONG_A_BAR,
                (true, Accuracy::Default) if projectile.is_some_and(|p| p.shape.is_pointed()) => UNDER_A_POINT,
                (true, Accuracy::Default) => FINE,
                (true, Accuracy::Converged) => CONVERGED,
            };
            record.derive_text("/pack/elements_per_crossover", count, "", false);
            count
        });
        // A bar meets whole rows of nodes, and sends waves along the whole of the strip: its mesh is even.
        let graded = finer && !bar;
        let pack = Pack {
            plies: self.plies.unwrap_or(1),
            spacing: self.spacing_mm.map(Mm::si),
            friction: self.friction,
            layup: Vec::new(),
            columns: 0,
            rows: 0,
            element_length_x: 0.0,
            element_length_y: 0.0,
            crossovers_per_element: self.crossovers_per_element,
            grading: None,
            elements_per_crossover,
            edges: self.edges.into(),
            pretension: None,
            initial_velocity: self.initial_velocity_m_s.map(MS::si),
            initial_deflection: self.initial_deflection.map(|keys| InitialDeflection {
                amplitude: keys.amplitude_mm.si(),
                warp_half_waves: keys.warp_half_waves,
                weft_half_waves: keys.weft_half_waves,
            }),
        };
        let (size, side) = ([self.width_mm.si(), self.height_mm.si()], pack.crossovers_along_element());
        let ([columns, rows], [element_length_x, element_length_y]) = mesh("/pack", fabric, size, side, record)?;
        let groups = self.layup.into_iter().flatten().enumerate();
        let layer =
            |(index, keys): (usize, LayerKeys)| keys.layer(&format!("{LAYUP}/{index}"), fabric, size, &pack, record);
        let mut layup: Vec<Layer> = groups.map(layer).collect::<Result<_, _>>()?;
        let plies = if layup.is_empty() { pack.plies } else { sum_of_plies(self.plies, &layup, record)? };
        if pack.spacing.is_none() {
            derive_spacing(fabric, &layup, record);
        }
        let thickest = layup.iter().map(|layer| layer.fabric.thickness).reduce(f64::max).unwrap_or(fabric.thickness);
        let depth = f64::from(plies - 1) * pack.spacing.unwrap_or(thickest);
        let grading = GradingKeys::grading(self.mesh_grading, graded, projectile, side, record)?;
        let grading = grading.map(|grading| grading.through(depth, size, projectile));
        for layer in &mut layup {
            layer.grading = grading;
        }
        let pretension = [self.pretension.warp_n_per_m, self.pretension.weft_n_per_m].map(|force| force.map(NM::si));
        let pretension = pretension.iter().any(Option::is_some).then_some(pretension);
        Ok(Pack { plies, layup, columns, rows, element_length_x, element_length_y, grading, pretension, ..pack })
    }
}

impl LayerKeys {
    /// The group at a pointer; it has from the pack what it does not say itself.
    fn layer(
        self,
        at: &str,
        common: &Fabric,
        size: [f64; 2],
        pack: &Pack,
        record: &Provenance,
    ) -> Result<Layer, CaseError> {
        let fabric = match self.fabric {
            Some(own) => own.fabric(&format!("{at}/fabric"), record)?,
            None => {
                record.derive_text(&format!("{at}/fabric"), &common.name, "", false);
                common.clone()
            }
        };
        let of_pack = |name: &str| {
            let above = format!("/pack/{name}");
            record.derive_text(&format!("{at}/{name}"), record.values_below(&above), "", record.is_any_assumed(&above));
        };
        if self.edges.is_none() {
            of_pack("edges");
        }
        if self.initial_velocity_m_s.is_none() {
            of_pack("initial_velocity_m_s");
        }
        let orientation = self.orientation_deg.si();
        let size = if lies_across(orientation) { [size[1], size[0]] } else { size };
        let side = pack.crossovers_along_element();
        let ([columns, rows], [element_length_x, element_length_y]) = mesh(at, &fabric, size, side, record)?;
        Ok(Layer {
            plies: self.plies,
            fabric,
            orientation,
            edges: self.edges.map_or(pack.edges, Into::into),
            initial_velocity: self.initial_velocity_m_s.map_or(pack.initial_velocity, |velocity| velocity.map(MS::si)),
            columns,
            rows,
            element_length_x,
            element_length_y,
            grading: None,
        })
    }
}

/// Whether the warp lies along the pack's Y axis: then the ply's own width is the pack's height.
fn lies_across(orientation: f64) -> bool {
    let quarters = orientation / FRAC_PI_2;
    let whole = quarters.round();
    // Degrees become radians with a rounding error.
    (quarters - whole).abs() < 1e-9 && whole.rem_euclid(2.0) == 1.0
}

/// Columns and rows, and the element lengths [m], for a size [m]: of the pack or of a group of its plies; `side` is the
/// number of crossovers along the side of an element.
fn mesh(
    at: &str,
    fabric: &Fabric,
    size: [f64; 2],
    side: f64,
    record: &Provenance,
) -> Result<([usize; 2], [f64; 2]), CaseError> {
    let length = [&fabric.warp, &fabric.weft].map(|yarn| side * 2.0 * yarn.half_span());
    // Finer meshes cover the same cloth: whole crossovers.
    let fine = (1.0 / side).round().max(1.0) as usize;
    let count = limits::mesh(at, size, length, fine)?;
    let how = "the size over the element length, to the nearest whole number of crossovers";
    for (name, count) in [("columns", count[0]), ("rows", count[1])] {
        record.derive_text(&format!("{at}/{name}"), count, how, false);
    }
    Ok((count, length))
}

/// Plies of a pack with a layup: the sum over it.
fn sum_of_plies(given: Option<u32>, layup: &[Layer], record: &Provenance) -> Result<u32, CaseError> {
    let sum: u32 = layup.iter().map(|layer| layer.plies).sum();
    if sum > MAX_PLIES {
        let expected = format!("at most {MAX_PLIES} plies over all groups");
        return Err(CaseError::at(LAYUP, expected, format!("{sum} plies")));
    }
    match given {
        None => record.derive_text("/pack/plies", sum, "the sum over the layup", false),
        Some(given) if given != sum => {
            let expected = format!("{sum}, the sum of the plies of {LAYUP}");
            let error = CaseError::at("/pack/plies", expected, given.to_string());
            return Err(error.help("leave \"plies\" out: the layup says how many there are"));
        }
        Some(_) => {}
    }
    Ok(sum)
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
    let spacings = within.chain(between);
    let (least, most) = spacings.fold((f64::INFINITY, 0.0_f64), |(least, most), s| (least.min(s), most.max(s)));
    let how = "the mean of the thickness_mm of the two plies";
    if least == most {
        record.derive(at, least, how, assumed);
    } else {
        let [least, most] = [least, most].map(|spacing| short_number_text(spacing * 1e3));
        record.derive_text(at, format!("{least} to {most}"), how, assumed);
    }
}
