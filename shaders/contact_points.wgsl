// contact_points: nodes near the projectile, and where it may touch: at them, and between two of them where its rim crosses the edge of an
// element. What `projectile_points` finds, `projectile_contact` lets meet. Needs `points` and `touches`.
// Twin: src/kernels/projectile_contact.rs and src/kernels/projectile_rim.rs

/// A node near the body during one step.
struct Point {
    /// Inverse mass by direction, 0 where held [1/kg].
    inverse: vec4<f32>,
    /// Velocity relative to the body's material before contact [m/s], and the mass [kg].
    relative: vec4<f32>,
    /// In the body's frame, without the fabric in front of it [m], and the thickness of that [m].
    pressed: vec4<f32>,
    /// Impulse of the points of the rim on its edges [N·s], and the sum of their weights.
    edge_impulse: vec4<f32>,
    /// Relative velocity without normal impulses; in the end before the step [m/s].
    free: vec4<f32>,
    /// Relative velocity with all impulses found so far [m/s].
    slip: vec4<f32>,
    node: u32,
    // Where the rim is sampled.
    /// Points of the rim on the edges to the next node of the row, then of the column: the first, and how many of each.
    first: u32,
    to_right: u32,
    to_above: u32,
    /// The points before this one in its row, in its column, where a point of the rim lies between; or `NONE`.
    left: u32,
    below: u32,
    /// Whether a point of the rim lies on an edge that ends here: 1 or 0.
    constrained: u32,
    /// The first of the points that it is tied to by points of the rim, over any number of edges.
    block: u32,
}

/// Where the body may touch: a node, or a point of the rim on an edge. Those of the nodes come first; before them is one whose `ends` tell
/// how many are of nodes, and how many there are.
struct Touch {
    /// Outward normal, and the gap [m].
    normal: vec4<f32>,
    /// From the centre of mass [m], and the mass that friction meets [kg].
    arm: vec4<f32>,
    /// Friction impulse and normal impulse [N·s].
    friction_impulse: vec4<f32>,
    /// L⁻¹ [G | n·v − target]: impulse, then turn and excess [m/s].
    moved: vec4<f32>,
    turned: vec4<f32>,
    /// The nodes at the ends of the edge, by their points; a node's own is both.
    ends: vec2<u32>,
    /// What the second has of it [-]; the first has the rest.
    weight: f32,
    /// Coulomb coefficient.
    friction: f32,
    state: u32,
    // Of those that push.
    /// On the diagonal of K [1/kg], of L.
    diagonal: f32,
    root: f32,
    /// On the way to the normal impulse.
    normal_impulse: f32,
    /// Its place among those that share nodes, or `NONE`; the first of its block; the first that its row has an entry for.
    member: u32,
    begin: u32,
    entry: u32,
    /// Where its row of the matrix begins.
    row: u32,
}

const NONE: u32 = 0xffffffffu;
