//! Grading of a mesh: elements of the finest size around the hit, growing away from it.

use super::error::CaseError;
use super::scope::{Choice, Scope};
use super::value::millimetres;
use super::{Layer, Projectile, Shape};

/// Fine elements reach this far from the projectile's wall by default, over its radius [-].
const FINE_RADII: f64 = 3.0;
/// Places closer than this to a line of nodes are on it, over the element length [-].
const ON_LINE: f64 = 1e-6;

/// Where a mesh is fine and how it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grading {
    /// Where the projectile meets the pack's plane, in the pack's axes [m].
    pub hit: [f64; 2],
    /// How far it moves along X and Y on its way through the pack [m].
    pub way: [f64; 2],
    /// Around that way elements are of the finest size, up to this distance along X and Y [m].
    pub fine: [f64; 2],
    /// Largest ratio of neighbouring elements' lengths.
    pub growth: f64,
    /// Largest length of an element over the finest.
    pub coarsest: f64,
}

/// Reads the grading of a pack of which each element of the finest size has `side` crossovers along a side.
/// `refined`: it is graded where nothing is said.
pub(super) fn read(
    pack: &Scope<'_>,
    projectile: Option<&Projectile>,
    side: f64,
    refined: bool,
) -> Result<Option<Grading>, CaseError> {
    let choice = match pack.given("mesh_grading") {
        Some(_) => pack.choice("mesh_grading")?,
        None => {
            let word = if refined { "graded" } else { "none" };
            pack.derive_value("mesh_grading", word.to_owned(), false)?;
            Choice::Word(word.to_owned())
        }
    };
    let keys = match choice {
        Choice::Word(word) if word == "none" => return Ok(None),
        Choice::Word(_) => pack.defaults("mesh_grading")?,
        Choice::Keys(keys) => keys,
    };
    let fine = match (keys.number_if_given("fine_radius_mm")?, projectile) {
        (Some(radius), _) => radius,
        (None, Some(projectile)) => keys.derive("fine_radius_mm", fine_radius(projectile), false)?,
        (None, None) => {
            let error =
                CaseError::at(keys.at("fine_radius_mm"), "a radius", "nothing, and no projectile to take it from");
            return Err(
                error.help("give fine_radius_mm: without a projectile the mesh is fine around the pack's centre")
            );
        }
    };
    let growth = keys.number("growth")?;
    let coarsest = keys.whole("coarsest")?;
    if f64::from(coarsest) < side {
        let expected =
            format!("at least the crossovers along a side of the finest (crossovers_per_element), which are {side}");
        return Err(CaseError::at(keys.at("coarsest"), expected, coarsest.to_string()));
    }
    let along_bar = |axis: usize| match projectile.map(|p| p.shape) {
        Some(Shape::Bar { along, .. }) if along as usize == axis => f64::INFINITY,
        _ => fine,
    };
    Ok(Some(Grading {
        hit: projectile.map_or([0.0; 2], |p| p.offset),
        way: [0.0; 2],
        fine: [along_bar(0), along_bar(1)],
        growth,
        coarsest: f64::from(coarsest) / side,
    }))
}

/// The default of a projectile [m]: [`FINE_RADII`], and as far as a yawed body's tail swings out.
fn fine_radius(projectile: &Projectile) -> f64 {
    let (diameter, length) = match projectile.shape {
        Shape::Sphere { diameter } | Shape::Bar { diameter, .. } => (diameter, 0.0),
        Shape::Cylinder { diameter, length }
        | Shape::Cone { diameter, length, .. }
        | Shape::Ogive { diameter, length, .. }
        | Shape::Fragment { diameter, length, .. } => (diameter, length),
    };
    0.5 * diameter * (1.0 + FINE_RADII) + length * projectile.yaw.sin().abs()
}

impl Grading {
    /// Takes the projectile's way through a pack of this depth [m] in.
    #[must_use]
    pub(super) fn through(mut self, depth: f64, projectile: Option<&Projectile>) -> Self {
        if let Some(p) = projectile {
            let across = depth * p.obliquity.tan();
            self.way = [across * p.azimuth.cos(), across * p.azimuth.sin()];
        }
        self
    }

    /// From where to where elements are fine along the axes of a ply whose warp lies at the angle with this cosine and sine [m].
    fn range(&self, [c, s]: [f64; 2]) -> [[f64; 2]; 2] {
        let turned = |[x, y]: [f64; 2]| [c * x + s * y, c * y - s * x];
        let (from, way) = (turned(self.hit), turned(self.way));
        let reach = |share: [f64; 2]| {
            [0, 1]
                .map(|a: usize| if share[a].abs() > ON_LINE { share[a].abs() * self.fine[a] } else { 0.0 })
                .iter()
                .sum()
        };
        let reach: [f64; 2] = [reach([c, s]), reach([s, c])];
        [0, 1].map(|a| [from[a] + way[a].min(0.0) - reach[a], from[a] + way[a].max(0.0) + reach[a]])
    }
}

impl Layer {
    /// Places of the lines of nodes along warp and weft, counted in finest elements from the first; `None` where they are even.
    /// `turn`: cosine and sine of the warp's angle.
    pub fn lines(&self, turn: [f64; 2]) -> Option<[Vec<f64>; 2]> {
        let grading = self.grading?;
        let range = grading.range(turn);
        let (counts, length) = ([self.columns, self.rows], [self.element_length_x, self.element_length_y]);
        Some([0, 1].map(|axis| {
            let centre = 0.5 * counts[axis] as f64;
            let fine = range[axis].map(|at| at / length[axis] + centre);
            lines(counts[axis], fine, grading.growth, grading.coarsest)
        }))
    }

    /// Places of the lines of nodes along warp and weft, even or not, counted in finest elements from the first.
    pub fn node_lines(&self) -> [Vec<f64>; 2] {
        let (s, c) = self.orientation.sin_cos();
        let even = || [self.columns, self.rows].map(|count| (0..=count).map(|k| k as f64).collect());
        self.lines([c, s]).unwrap_or_else(even)
    }

    /// Reference places of the middles of elements along warp and weft, from the middle of the ply, in its own axes [m].
    pub fn middles(&self) -> [Vec<f64>; 2] {
        let (counts, length) = ([self.columns, self.rows], [self.element_length_x, self.element_length_y]);
        let lines = self.node_lines();
        [0, 1].map(|axis: usize| {
            let middle = |pair: &[f64]| (0.5 * (pair[0] + pair[1]) - 0.5 * counts[axis] as f64) * length[axis];
            lines[axis].windows(2).map(middle).collect()
        })
    }

    /// Elements along warp and weft.
    pub fn counts(&self) -> [usize; 2] {
        let (s, c) = self.orientation.sin_cos();
        self.lines([c, s]).map_or([self.columns, self.rows], |lines| lines.map(|lines| lines.len() - 1))
    }
}

/// Lines over `count` finest elements, fine `from` … `to`.
fn lines(count: usize, [from, to]: [f64; 2], growth: f64, coarsest: f64) -> Vec<f64> {
    let last = count as f64;
    let from = (from + ON_LINE).floor().clamp(0.0, last - 1.0);
    let to = (to - ON_LINE).ceil().clamp(from + 1.0, last);
    let before = growing(from, growth, coarsest);
    let after = growing(last - to, growth, coarsest);
    let fine = (0..=(to - from) as usize).map(|k| from + k as f64);
    let out = before.iter().rev().map(|at| from - at).chain(fine).chain(after.iter().map(|at| to + at));
    out.collect()
}

/// Ends of elements that grow by at most `growth` from 1 to `coarsest` and fill `room`: as few as that takes.
fn growing(room: f64, growth: f64, coarsest: f64) -> Vec<f64> {
    let ends = |count: usize, growth: f64| {
        let mut at = 0.0;
        let mut width = 1.0;
        let mut ends = Vec::with_capacity(count);
        for _ in 0..count {
            width = (width * growth).min(coarsest);
            at += width;
            ends.push(at);
        }
        ends
    };
    let length = |count: usize, growth: f64| ends(count, growth).last().copied().unwrap_or(0.0);
    let mut count = 0;
    while length(count, growth) < room {
        count += 1;
    }
    // The growth with which they fill it exactly.
    let (mut low, mut high) = (1.0, growth);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if length(count, middle) < room { low = middle } else { high = middle }
    }
    let mut ends = ends(count, if length(count, low) < room { high } else { low });
    if let Some(last) = ends.last_mut() {
        *last = room;
    }
    ends
}

/// The grading in words: how far it is fine.
pub(super) fn words(grading: &Grading) -> String {
    let fine = grading.fine.into_iter().fold(f64::INFINITY, f64::min);
    format!("fine up to {} from the hit, growing by {} to {}", millimetres(fine), grading.growth, grading.coarsest)
}
