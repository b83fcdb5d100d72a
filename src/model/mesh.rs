//! The structured mesh of a ply, in its own axes: warp along X (columns), weft along Y (rows).

/// Mesh of a ply, one element per crossover or a whole number of them, and how it lies in the pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh {
    /// Elements along weft.
    pub rows: usize,
    /// Elements along warp.
    pub columns: usize,
    /// Undeformed element lengths Lx, Ly [m].
    pub length: [f64; 2],
    /// Reference position of node (0, 0) in the ply's axes [m]; the pack's centre is the origin.
    pub origin: [f64; 2],
    /// Cosine and sine of the angle from the pack's X axis to the warp.
    pub turn: [f64; 2],
}

impl Mesh {
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
        Self { rows, columns, length, origin, turn }
    }

    /// Elements.
    pub fn elements(&self) -> usize {
        self.rows * self.columns
    }

    /// Reference position of a node in the ply's axes [m].
    pub fn reference(&self, row: usize, column: usize) -> [f64; 2] {
        [self.origin[0] + self.length[0] * column as f64, self.origin[1] + self.length[1] * row as f64]
    }

    /// A vector of the ply's axes in those of the pack.
    #[inline]
    pub fn to_pack(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [c, s] = self.turn;
        [c * x - s * y, s * x + c * y, z]
    }

    /// A vector of the pack's axes in those of the ply.
    #[inline]
    pub fn to_ply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [c, s] = self.turn;
        [c * x + s * y, c * y - s * x, z]
    }

    /// Row and column of the element nearest to a place in the ply's axes [m].
    pub fn element_at(&self, place: [f64; 2]) -> [usize; 2] {
        let index = |a: usize, count: usize| {
            let at = (place[a] - self.origin[a]) / self.length[a];
            (at.max(0.0) as usize).min(count - 1)
        };
        [index(1, self.rows), index(0, self.columns)]
    }

    /// Rows and columns of the up to four elements around a node.
    pub fn around(&self, row: usize, column: usize) -> impl Iterator<Item = [usize; 2]> + use<> {
        let rows = row.saturating_sub(1)..(row + 1).min(self.rows);
        let columns = column.saturating_sub(1)..(column + 1).min(self.columns);
        columns.flat_map(move |c| rows.clone().map(move |r| [r, c]))
    }

    /// Length of the shorter side of an element [m].
    pub fn shortest(&self) -> f64 {
        self.length[0].min(self.length[1])
    }
}

/// Row and column of an element's corners, counter-clockwise.
#[inline]
pub fn corners([row, column]: [usize; 2]) -> [(usize, usize); 4] {
    [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_turn_there_and_back() {
        for angle in [0.0, 0.3, std::f64::consts::FRAC_PI_2, -std::f64::consts::PI, 5.0] {
            let mesh = Mesh::new(3, 2, [1.0, 2.0], angle);
            let v = mesh.to_ply(mesh.to_pack([0.3, -2.0, 7.0]));
            assert!((v[0] - 0.3).abs() < 1e-15 && (v[1] + 2.0).abs() < 1e-15 && v[2] == 7.0, "{angle}: {v:?}");
        }
        assert_eq!(Mesh::new(1, 1, [1.0; 2], std::f64::consts::FRAC_PI_2).turn, [0.0, 1.0]);
        assert_eq!(Mesh::new(1, 1, [1.0; 2], -std::f64::consts::FRAC_PI_2).to_pack([1.0, 2.0, 0.0]), [2.0, -1.0, 0.0]);
    }
}
