//! The wavefront: which rows of a ply may have moved, so that the rest is not computed.
//!
//! In one step a node feels its own elements, and they its neighbours: motion spreads by one row a step, faster than the
//! projectile moves across. What lies beyond is exactly at rest, so leaving it out changes no bit. The rows follow
//! from the step number alone, never from how steps are grouped.

use std::ops::Range;

use crate::kernels::rigid_body::RigidBody;
use crate::model::{Mesh, Model};

/// Rows around the projectile that count as touched from the start.
const MARGIN: usize = 3;
/// Speed of any point of the projectile, over its impact speed, at most: all its energy in one motion.
const FASTER: f64 = 4.0;

/// Rows that may have moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Front {
    /// Rows of nodes the projectile may touch first.
    first: usize,
    last: usize,
    rows: usize,
}

impl Front {
    /// The front of a single ply at rest struck by a projectile; `None` where everything may move at once.
    pub fn new(model: &Model<f32>) -> Option<Self> {
        let mesh = &model.sheet(0).mesh;
        let body = model.projectile.as_ref()?;
        let slow = FASTER * body.speed_bound() * model.dt < mesh.length[1];
        (model.at_rest && slow && model.plies.len() == 1).then(|| Self::around(mesh, body))
    }

    fn around(grid: &Mesh, body: &RigidBody) -> Self {
        // Any turn of the body stays within its reach; a bar goes on across the ply.
        let reach = if body.body.profile.bar { f64::INFINITY } else { body.body.reach };
        let row = |y: f64| ((y - grid.origin[1]) / grid.length[1]).clamp(0.0, grid.rows as f64);
        let first = row(body.position.y - reach).floor() as usize;
        let last = row(body.position.y + reach).ceil() as usize;
        Self { first: first.saturating_sub(MARGIN), last: (last + MARGIN).min(grid.rows), rows: grid.rows }
    }

    /// Rows of nodes that may move in a step, counted from 0; the elements between them come with them.
    pub fn node_rows(&self, step: u64) -> Range<usize> {
        let spread = usize::try_from(step).unwrap_or(usize::MAX).min(self.rows);
        self.first.saturating_sub(spread)..(self.last + spread).min(self.rows) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_grows_by_a_row_a_step_to_the_edges() {
        let front = Front { first: 40, last: 45, rows: 50 };
        assert_eq!(front.node_rows(0), 40..46);
        assert_eq!(front.node_rows(3), 37..49);
        assert_eq!(front.node_rows(10), 30..51);
        assert_eq!(front.node_rows(u64::MAX), 0..51);
    }
}
