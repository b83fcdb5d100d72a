// projectile_shape: gap and outward normal of a point near an analytic body.
// Twin: src/kernels/projectile_shape.rs

struct Gap {
    /// Negative inside [m].
    distance: f32,
    /// Body frame.
    normal: vec3<f32>,
}

/// Distance of a point from the body's axis [m] (from its midplane for a bar).
fn axis_distance(point: vec3<f32>) -> f32 {
    return select(sqrt(squared(point.x) + squared(point.y)), abs(point.x), scene.body_bar != 0u);
}

/// Gap of a point given in the body's frame [m]: x, y across the axis, z along it from the tip of the nose.
fn surface_gap(point: vec3<f32>) -> Gap {
    let rho = axis_distance(point);
    let s = point.z;
    var best = 1e30;
    var normal = vec2<f32>(0.0, 1.0);
    var offset = vec2<f32>(0.0);
    var beside = false;
    var deepest = -1e30;
    var deepest_normal = vec2<f32>(0.0, 1.0);
    let sides = max(scene.profile_count, 2u) - 1u;
    for (var i = 0u; i < sides; i++) {
        let a = scene.profile[i];
        let b = scene.profile[min(i + 1u, scene.profile_count - 1u)];
        let edge = b.xy - a.xy;
        let start = vec2<f32>(rho, s) - a.xy;
        let length = max(dot(edge, edge), 1e-30);
        let along = min(max(dot(start, edge) / length, 0.0), 1.0);
        let away = start - along * edge;
        let square = dot(away, away);
        if (square < best) {
            best = square;
            normal = a.zw;
            offset = away;
            beside = 0.0 < along && along < 1.0;
        }
        let height = dot(start, a.zw);
        if (deepest < height) {
            deepest = height;
            deepest_normal = a.zw;
        }
    }
    let inside = scene.profile_count > 1u && deepest <= 0.0;
    let distance = sqrt(best);
    // Near the surface the direction to it is noise: beside a side that side's own normal holds.
    let resolved = !beside && 1e-9 < distance;
    let outside = select(normal, offset / select(1.0, distance, resolved), resolved);
    let n = select(outside, deepest_normal, inside);
    let signed = select(distance, deepest, inside);
    let on_axis = rho <= 1e-30;
    let spread = select(n.x / select(rho, 1.0, on_axis), 0.0, on_axis);
    let y = select(spread * point.y, 0.0, scene.body_bar != 0u);
    return Gap(signed - scene.profile_radius, vec3<f32>(spread * point.x, y, n.y));
}

/// The gap that contact acts on: the surface's, except behind the rim of a flat nose.
fn holding_gap(point: vec3<f32>) -> Gap {
    var g = surface_gap(point);
    let below = scene.profile[1].y - point.z;
    if (scene.profile_flat != 0u && 0.0 < below && below <= scene.rim_depth) {
        g.distance = select(1e30, g.distance, g.distance < 0.0);
        g.normal = vec3<f32>(0.0, 0.0, 1.0);
    }
    return g;
}
