//! What is varied: numerical choices that a result should not depend on.

use crate::case::{Case, ContactSampling, LinesFrom, Word};

/// Courant numbers [-].
const COURANT: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 0.95];
/// Those of a quick look [-].
const COURANT_QUICK: [f64; 2] = [0.5, 0.95];
/// Hourglass coefficients [-].
const HOURGLASS: [f64; 3] = [0.0005, 0.005, 0.02];
/// Shifts of the hit along warp and weft, in cells; with the reference these are nine. What lies beyond a half is a mirror image.
const SHIFTS: [[f64; 2]; 8] =
    [[0.25, 0.0], [0.5, 0.0], [0.0, 0.25], [0.25, 0.25], [0.5, 0.25], [0.0, 0.5], [0.25, 0.5], [0.5, 0.5]];
/// Shifts that nobody could measure, one nanometre along warp, weft and both [mm].
const CHANCE: [[f64; 2]; 3] = [[1e-6, 0.0], [0.0, 1e-6], [1e-6, 1e-6]];

/// A numerical choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariedAxis {
    /// The case as it is.
    Reference,
    /// A finer mesh.
    Finer,
    /// A coarser mesh.
    Coarser,
    /// The time step.
    Courant,
    /// Where in a cell the projectile hits.
    Position,
    /// Where lines of nodes lie under the hit: counted from the edges of the ply instead of from the hit.
    Lines,
    /// Nothing that matters: what differs is chance.
    Repeatability,
    /// Where contact is sampled.
    Sampling,
    /// The hourglass coefficient.
    Hourglass,
}

impl VariedAxis {
    /// All but the reference.
    pub const ALL: [Self; 8] = [
        Self::Position,
        Self::Lines,
        Self::Finer,
        Self::Courant,
        Self::Coarser,
        Self::Sampling,
        Self::Hourglass,
        Self::Repeatability,
    ];

    /// Whether a figure is asked for the residual velocity, so that it is worth a mean.
    pub(super) fn asks_for_a_mean(self) -> bool {
        matches!(self, Self::Reference | Self::Position | Self::Finer | Self::Courant)
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Finer => "finer mesh",
            Self::Coarser => "coarser mesh",
            Self::Courant => "Courant number",
            Self::Position => "position of the hit",
            Self::Lines => "lines of nodes under the hit",
            Self::Repeatability => "a nanometre off",
            Self::Sampling => "contact sampling",
            Self::Hourglass => "hourglass coefficient",
        }
    }
}

/// One way to run the case.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// What is varied.
    pub axis: VariedAxis,
    /// To what, in words.
    pub name: String,
    /// Changes of the case.
    pub sets: Vec<String>,
    /// Whether the hit is moved by half a cell along warp, weft or both, and by nothing else.
    pub half_cell: bool,
}

impl Setting {
    fn new(axis: VariedAxis, name: String, sets: &[String]) -> Self {
        Self { axis, name, sets: sets.to_vec(), half_cell: false }
    }
}

/// The settings for a case, the reference first; `quick` takes a part of them.
pub fn settings(case: &Case, quick: bool) -> Vec<Setting> {
    let mut all = vec![Setting::new(VariedAxis::Reference, "the case as it is".to_owned(), &[])];
    all.extend(SHIFTS.iter().filter(|shift| !quick || shift[0] == shift[1]).map(|shift| shifted(case, *shift)));
    if case.pack.grading.is_some_and(|grading| grading.lines_from == LinesFrom::Hit) {
        let shifts = SHIFTS.iter().filter(|shift| !quick || shift[0] == shift[1]);
        all.extend(shifts.map(|shift| shifted_lines(case, *shift)));
    }
    all.extend(meshes(case));
    let courant = if quick { &COURANT_QUICK[..] } else { &COURANT };
    for courant in courant.iter().filter(|courant| **courant != case.solver.courant) {
        all.push(Setting::new(VariedAxis::Courant, courant.to_string(), &[format!("/solver/courant={courant}")]));
    }
    if quick {
        return all;
    }
    let other = match case.solver.contact_sampling {
        ContactSampling::Nodes => ContactSampling::Edges,
        ContactSampling::Edges => ContactSampling::Nodes,
    };
    let set = format!("/solver/contact_sampling={}", other.word());
    all.push(Setting::new(VariedAxis::Sampling, other.word().to_owned(), &[set]));
    for value in HOURGLASS.iter().filter(|value| **value != case.solver.hourglass) {
        all.push(Setting::new(VariedAxis::Hourglass, value.to_string(), &[format!("/solver/hourglass={value}")]));
    }
    for [x, y] in CHANCE {
        let name = format!("{} nm, {} nm", x * 1e6, y * 1e6);
        all.push(Setting::new(VariedAxis::Repeatability, name, &[offset(case, [x, y])]));
    }
    all
}

/// Half and twice the elements along each side.
fn meshes(case: &Case) -> [Setting; 2] {
    let [coarse, fine] = [case.pack.crossovers_per_element, case.pack.elements_per_crossover];
    let crossovers = |count: u32| format!("/pack/crossovers_per_element={count}");
    let elements = |count: u32| format!("/pack/elements_per_crossover={count}");
    let halved = if coarse.is_multiple_of(2) { crossovers(coarse / 2) } else { elements(2 * fine) };
    let doubled = if fine.is_multiple_of(2) { elements(fine / 2) } else { crossovers(2 * coarse) };
    [
        Setting::new(VariedAxis::Finer, "half as long elements".to_owned(), &[halved]),
        Setting::new(VariedAxis::Coarser, "twice as long elements".to_owned(), &[doubled]),
    ]
}

/// The hit moved by parts of a cell along warp and weft.
fn shifted(case: &Case, shift: [f64; 2]) -> Setting {
    let [x, y] = [shift[0] * case.pack.element_length_x, shift[1] * case.pack.element_length_y];
    let name = format!("{}, {} cells", shift[0], shift[1]);
    let half_cell = shift.iter().all(|part| [0.0, 0.5].contains(part));
    Setting { half_cell, ..Setting::new(VariedAxis::Position, name, &[offset(case, [x * 1e3, y * 1e3])]) }
}

/// The hit moved likewise, over lines that are counted from the edges.
fn shifted_lines(case: &Case, shift: [f64; 2]) -> Setting {
    let moved = shifted(case, shift);
    let sets = moved.sets.into_iter().chain(["/pack/mesh_grading/lines_from=edges".to_owned()]).collect();
    Setting { axis: VariedAxis::Lines, sets, half_cell: false, ..moved }
}

/// The point of aim moved by `by` [mm].
pub(super) fn offset(case: &Case, by: [f64; 2]) -> String {
    let at = case.projectile.as_ref().map_or([0.0; 2], |projectile| projectile.offset);
    format!("/projectile/offset_mm=[{:?}, {:?}]", at[0] * 1e3 + by[0], at[1] * 1e3 + by[1])
}
