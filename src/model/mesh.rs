//! The structured mesh of a ply, in its own axes: warp along X (columns), weft along Y (rows).

use std::ops::Range;

use crate::case::{Frame, Layer, Opening};
use crate::model::grid_lines::Lines;
use crate::physics::rigid_body::{Cut, MirrorPlanes};

/// Mesh of a ply, one element per crossover or a whole number of them, and how it lies in the pack.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Elements along weft.
    pub rows: usize,
    /// Elements along warp.
    pub columns: usize,
    /// Undeformed lengths Lx, Ly of the finest elements [m]; without grading all are alike.
    pub length: [f64; 2],
    /// Lines of nodes along X and Y.
    pub(crate) lines: [Lines; 2],
    /// Reference position of node (0, 0) in the ply's axes [m]; the pack's centre is the origin.
    pub origin: [f64; 2],
    /// A place between two yarns, along X and Y, counted in finest elements from node (0, 0).
    between_yarns: [f64; 2],
    /// Cosine and sine of the angle from the pack's X axis to the warp.
    pub rotation: [f64; 2],
    /// Cuts of mirror planes through the ply along its X and Y; the mesh is what is left of it.
    pub cut: [Cut; 2],
    /// Frame around it. Elements outside its opening are absent.
    pub frame: Frame,
}

impl Mesh {
    /// The whole mesh of a ply of a layer.
    pub(super) fn of_layer(layer: &Layer) -> Self {
        let length = layer.mesh.length;
        let mut mesh = Self::new(layer.mesh.count[0], layer.mesh.count[1], length, layer.orientation);
        mesh.between_yarns = layer.between_yarns(mesh.rotation);
        mesh.frame = layer.mesh.frame;
        if let Some([x, y]) = layer.lines(mesh.rotation) {
            [mesh.columns, mesh.rows] = [x.len() - 1, y.len() - 1];
            mesh.lines = [x, y].map(Lines::graded);
        }
        mesh
    }

    /// A mesh around the pack's centre, its warp at `orientation` [rad] to the pack's X axis.
    pub fn new(columns: usize, rows: usize, length: [f64; 2], orientation: f64) -> Self {
        // Quarter turns are exact, so that a ply laid at 90° is the mirror image of one laid at 0°.
        let quarters = orientation / std::f64::consts::FRAC_PI_2;
        let turn = if (quarters - quarters.round()).abs() < 1e-12 {
            [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][(quarters.round() as i64).rem_euclid(4) as usize]
        } else {
            [orientation.cos(), orientation.sin()]
        };
        let origin = [-0.5 * length[0] * columns as f64, -0.5 * length[1] * rows as f64];
        let lines = [Lines::even(columns), Lines::even(rows)];
        let between_yarns = [columns / 2, rows / 2].map(|middle| middle as f64);
        let (cut, frame) = ([Cut::Nowhere; 2], Frame::default());
        Self { rows, columns, length, lines, origin, between_yarns, rotation: turn, cut, frame }
    }

    /// Part of the mesh at x ≥ 0 and y ≥ 0 of the pack where those are mirror planes.
    #[must_use]
    pub fn part(mut self, planes: MirrorPlanes) -> Self {
        for axis in (0..2).filter(|axis| planes.0[*axis]) {
            let Some(own) = self.own_axis(axis) else { continue };
            let along = self.to_pack([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]][own])[axis];
            let count = if own == 0 { &mut self.columns } else { &mut self.rows };
            *count /= 2;
            let middle = self.lines[own].at(*count);
            self.lines[own] = self.lines[own].half(along > 0.0);
            if along > 0.0 {
                self.cut[own] = Cut::First;
                self.between_yarns[own] -= middle;
                self.origin[own] = 0.0;
            } else {
                self.cut[own] = Cut::Last;
            }
        }
        self
    }

    /// The axis of the ply that lies along one of the pack, and the other way round; `None` where it is laid at an odd angle.
    pub(crate) fn own_axis(&self, axis: usize) -> Option<usize> {
        match self.rotation {
            [_, 0.0] => Some(axis),
            [0.0, _] => Some(1 - axis),
            _ => None,
        }
    }

    /// Column, and row, of the nodes on mirror planes of the pack; `None` where there are none.
    pub(crate) fn on_planes(&self, planes: MirrorPlanes) -> [Option<usize>; 2] {
        let is_plane = |own: usize| self.own_axis(own).is_some_and(|axis| planes.0[axis]);
        [0, 1].map(|own| is_plane(own).then_some(self.centre()[own]))
    }

    /// Column and row of the nodes in the middle of the whole ply.
    pub fn centre(&self) -> [usize; 2] {
        [0, 1].map(|own| if self.cut[own] == Cut::First { 0 } else { self.whole_counts()[own] / 2 })
    }

    /// Whether a node lies on a plane that cuts the mesh across its X, across its Y.
    #[inline]
    pub(crate) fn cut_across(&self, row: usize, column: usize) -> [bool; 2] {
        let is_cut = |cut: Cut, at: usize, last: usize| match cut {
            Cut::Nowhere => false,
            Cut::First => at == 0,
            Cut::Last => at == last,
        };
        [is_cut(self.cut[0], column, self.columns), is_cut(self.cut[1], row, self.rows)]
    }

    /// The part of a node that the mesh has: a half where a plane cuts it, a quarter where two do.
    #[inline]
    pub(crate) fn part_of(&self, row: usize, column: usize) -> f64 {
        self.cut_across(row, column).into_iter().map(|cut| if cut { 0.5 } else { 1.0 }).product()
    }

    /// The whole ply that the mesh is a part of.
    #[must_use]
    pub fn whole(&self) -> Self {
        let [columns, rows] = self.whole_counts();
        let lines = [0, 1].map(|a| match self.cut[a] {
            Cut::Nowhere => self.lines[a].clone(),
            cut => self.lines[a].doubled(cut == Cut::First),
        });
        let origin = [0, 1].map(|a| -self.length[a] * (0.5 * lines[a].at(lines[a].elements())));
        let extent = self.extent();
        let between_yarns =
            [0, 1].map(|a| self.between_yarns[a] + if self.cut[a] == Cut::First { extent[a] } else { 0.0 });
        Self { rows, columns, origin, between_yarns, lines, cut: [Cut::Nowhere; 2], ..self.clone() }
    }

    /// Elements along X and Y of the whole ply.
    pub(crate) fn whole_counts(&self) -> [usize; 2] {
        let counts = [self.columns, self.rows];
        [0, 1].map(|a| if self.cut[a] == Cut::Nowhere { counts[a] } else { 2 * counts[a] })
    }

    /// Lengths of the whole ply along X and Y [m].
    pub(crate) fn whole_size(&self) -> [f64; 2] {
        let extent = self.extent();
        [0, 1].map(|a| self.length[a] * if self.cut[a] == Cut::Nowhere { extent[a] } else { 2.0 * extent[a] })
    }

    /// First element (or node) of the mesh along X and Y, counted in the whole ply.
    pub(crate) fn first_in_whole(&self) -> [usize; 2] {
        let counts = [self.columns, self.rows];
        [0, 1].map(|a| if self.cut[a] == Cut::First { counts[a] } else { 0 })
    }

    /// Places in the whole ply of an element (`last` = 1) or a node (`last` = 0) of the mesh, and those of its mirror images, as column and
    /// row, each with the signs of the components along X and Y of the ply.
    pub fn images(&self, place: [usize; 2], last: usize) -> impl Iterator<Item = ([usize; 2], [f32; 2])> + use<> {
        let (whole, first) = (self.whole_counts(), self.first_in_whole());
        let [columns, rows] = [0, 1].map(|a| {
            let own = first[a] + place[a];
            let image = (self.cut[a] != Cut::Nowhere).then(|| whole[a] - last - own).filter(|image| *image != own);
            std::iter::once((own, 1.0)).chain(image.map(|image| (image, -1.0)))
        });
        rows.flat_map(move |(row, y)| columns.clone().map(move |(column, x)| ([column, row], [x, y])))
    }

    /// Elements.
    pub fn elements(&self) -> usize {
        self.rows * self.columns
    }

    /// Reference position of a node in the ply's axes [m].
    pub fn reference(&self, row: usize, column: usize) -> [f64; 2] {
        let [x, y] = &self.lines;
        [self.origin[0] + self.length[0] * x.at(column), self.origin[1] + self.length[1] * y.at(row)]
    }

    /// Lengths of an element along X and Y over the finest [-].
    #[inline]
    pub fn widths(&self, row: usize, column: usize) -> [f64; 2] {
        [self.lines[0].width(column), self.lines[1].width(row)]
    }

    /// Lengths of an element along X and Y [m].
    #[inline]
    pub fn size(&self, row: usize, column: usize) -> [f64; 2] {
        let [x, y] = self.widths(row, column);
        [self.length[0] * x, self.length[1] * y]
    }

    /// Area of an element [m²].
    #[inline]
    pub fn area(&self, row: usize, column: usize) -> f64 {
        let [x, y] = self.size(row, column);
        x * y
    }

    /// Lengths of the mesh along X and Y, counted in finest elements.
    pub fn extent(&self) -> [f64; 2] {
        [self.lines[0].at(self.columns), self.lines[1].at(self.rows)]
    }

    /// Whether an element is there: its middle lies in the opening of the frame.
    pub fn is_present(&self, row: usize, column: usize) -> bool {
        if self.frame.opening == Opening::Mesh {
            return true;
        }
        let [first, _, last, _] = corners([row, column]).map(|(row, column)| self.reference(row, column));
        let [x, y, _] = self.to_pack([0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]), 0.0]);
        self.frame.contains([x, y])
    }

    /// Elements of the finest size that cover as much.
    pub fn finest_elements(&self) -> f64 {
        self.extent().into_iter().product()
    }

    /// Crossing of the lines in the middle of the finest elements, in the ply's axes, or the mirror planes through there [m].
    pub(crate) fn middle_of_finest(&self) -> [f64; 2] {
        let [column, row] = [0, 1].map(|axis| self.lines[axis].middle_of_finest());
        let place = self.reference(row, column);
        [0, 1].map(|axis| if self.cut[axis] == Cut::Nowhere { place[axis] } else { 0.0 })
    }

    /// Longest side of any element [m].
    pub fn longest(&self) -> f64 {
        (self.length[0] * self.lines[0].widest()).max(self.length[1] * self.lines[1].widest())
    }

    /// Whether elements differ in size.
    pub fn is_graded(&self) -> bool {
        self.lines.iter().any(|lines| lines.graded)
    }

    /// Elements within `reach` finest ones of the middle of every element along an axis, and how much of each; of the whole ply, of
    /// which the mesh may be a part.
    pub(super) fn overlaps(&self, axis: usize, reach: f64) -> Vec<(usize, Vec<f64>)> {
        let lines = &self.lines[axis];
        let mirrored = [Cut::First, Cut::Last].map(|cut| self.cut[axis] == cut);
        (0..lines.elements()).map(|element| lines.overlaps(element, reach, mirrored)).collect()
    }

    /// Number of the yarn across an axis that an element along it lies in, from the first on. `breadth`: of a yarn, in finest elements.
    pub(super) fn yarn(&self, axis: usize, element: usize, breadth: f64) -> u32 {
        self.lines[axis].yarn(element, self.between_yarns[axis], breadth)
    }

    /// The elements that lie side by side with one, along an axis, in the yarn across it.
    pub(crate) fn side_by_side(&self, axis: usize, element: usize, breadth: f64) -> Range<usize> {
        let yarn = |at: usize| self.yarn(axis, at, breadth);
        let before = (0..element).rev().take_while(|at| yarn(*at) == yarn(element)).count();
        let behind = (element + 1..self.lines[axis].elements()).take_while(|at| yarn(*at) == yarn(element)).count();
        element - before..element + behind + 1
    }

    /// A vector of the ply's axes in those of the pack.
    #[inline]
    pub fn to_pack(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [c, s] = self.rotation;
        [c * x - s * y, s * x + c * y, z]
    }

    /// A vector of the pack's axes in those of the ply.
    #[inline]
    pub fn to_ply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [c, s] = self.rotation;
        [c * x + s * y, c * y - s * x, z]
    }

    /// Row and column of the element nearest to a place in the ply's axes [m].
    pub fn element_at(&self, place: [f64; 2]) -> [usize; 2] {
        let index = |a: usize| self.lines[a].element_at((place[a] - self.origin[a]) / self.length[a]);
        [index(1), index(0)]
    }

    /// The lines of nodes between two places along an axis of the ply [m], and the next on either side.
    pub(crate) fn lines_between(&self, axis: usize, places: [f64; 2]) -> Range<usize> {
        let [from, to] = places.map(|place| (place - self.origin[axis]) / self.length[axis]);
        self.lines[axis].between(from, to)
    }

    /// The line of nodes nearest to a place along an axis of the ply [m].
    pub(crate) fn nearest_line(&self, axis: usize, place: f64) -> usize {
        self.lines[axis].nearest((place - self.origin[axis]) / self.length[axis])
    }

    /// Rows and columns of the up to four elements around a node.
    pub fn around(&self, row: usize, column: usize) -> impl Iterator<Item = [usize; 2]> + use<> {
        let rows = row.saturating_sub(1)..(row + 1).min(self.rows);
        let columns = column.saturating_sub(1)..(column + 1).min(self.columns);
        columns.flat_map(move |c| rows.clone().map(move |r| [r, c]))
    }

    /// Length of the shorter side of the finest elements [m].
    pub fn shortest(&self) -> f64 {
        self.length[0].min(self.length[1])
    }
}

/// Row and column of an element's corners, counter-clockwise.
#[inline]
pub fn corners([row, column]: [usize; 2]) -> [(usize, usize); 4] {
    [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)]
}

/// Numbers processed at once at most; rows are padded so that every load stays inside its row.
const PAD: usize = 32;

/// Storage of a pack. Every ply has room for the largest mesh among them; what a smaller one leaves is never computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Plies, the struck one first.
    pub plies: usize,
    /// Most elements along weft.
    pub rows: usize,
    /// Most elements along warp.
    pub columns: usize,
    /// Numbers stored per field of a row of nodes.
    pub node_stride: usize,
    /// Numbers stored per field of a row of elements; element c is at c + 1.
    pub element_stride: usize,
}

impl Grid {
    /// Storage for `plies` plies of these meshes.
    pub fn new<'a>(plies: usize, meshes: impl Iterator<Item = &'a Mesh>) -> Self {
        let [rows, columns] = meshes.fold([0; 2], |[r, c], mesh| [r.max(mesh.rows), c.max(mesh.columns)]);
        let node_stride = Self::node_stride(columns);
        Self { plies, rows, columns, node_stride, element_stride: node_stride + PAD }
    }

    /// Numbers stored per field of a row of nodes of a mesh with this number of columns.
    pub(crate) fn node_stride(columns: usize) -> usize {
        (columns + 1).next_multiple_of(PAD) + PAD
    }

    /// Rows of nodes over all plies.
    pub fn node_rows(&self) -> usize {
        self.plies * (self.rows + 1)
    }

    /// Rows of elements over all plies.
    pub fn element_rows(&self) -> usize {
        self.plies * self.rows
    }

    /// Ply and row within it of a row of nodes.
    pub(crate) fn node_row(&self, row: usize) -> (usize, usize) {
        (row / (self.rows + 1), row % (self.rows + 1))
    }

    /// Ply and row within it of a row of elements.
    pub(crate) fn element_row(&self, row: usize) -> (usize, usize) {
        (row / self.rows, row % self.rows)
    }

    /// First row of nodes of a ply.
    pub fn first_node_row(&self, ply: usize) -> usize {
        ply * (self.rows + 1)
    }

    /// First row of elements of a ply.
    pub fn first_element_row(&self, ply: usize) -> usize {
        ply * self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn a_part_of_a_mesh_keeps_its_places_and_its_images_make_the_whole() {
        for angle in [0.0, 0.5, 1.0, -0.5].map(|quarters| quarters * std::f64::consts::PI) {
            let whole = Mesh::new(6, 4, [1.1, 2.3], angle);
            for planes in [[true, false], [false, true], [true, true]] {
                let part = whole.clone().part(MirrorPlanes(planes));
                assert_eq!(part.whole_counts(), [6, 4]);
                let [right, up] = part.first_in_whole();
                let mut seen = vec![0; whole.elements()];
                for row in 0..=part.rows {
                    for column in 0..=part.columns {
                        let ([x, y], [p, q]) = (part.reference(row, column), whole.reference(row + up, column + right));
                        assert!((x - p).abs() < 1e-14 && (y - q).abs() < 1e-14, "{angle} {planes:?} {row} {column}");
                        let place = part.to_pack([x, y, 0.0]);
                        assert!((0..2).all(|a| !planes[a] || place[a] >= 0.0), "{angle} {planes:?} {place:?}");
                        if row < part.rows && column < part.columns {
                            part.images([column, row], 1).for_each(|([c, r], _)| seen[r * 6 + c] += 1);
                        }
                    }
                }
                assert!(seen.iter().all(|count| *count == 1), "{angle} {planes:?} {seen:?}");
            }
        }
        assert_eq!(Mesh::new(6, 4, [1.0; 2], 0.4).own_axis(0), None);
    }
}
