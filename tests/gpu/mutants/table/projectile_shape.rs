//! Defects of `projectile_points` in the shape of the body.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "projectile_points", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant("no rim zone", "rim of a flat cylinder", "below <= scene.rim_depth", "below <= 0.0"),
    mutant(
        "nodes beside the rim held",
        "rim of a flat cylinder",
        "select(1e30, g.distance, g.distance < 0.0)",
        "g.distance",
    ),
    mutant("rounding of the body missing", "cone", "signed - scene.profile_radius", "signed"),
    mutant(
        "nearest side instead of the deepest",
        "locked cylinder in a clamped corner",
        "if (deepest < height) {",
        "if (height < deepest || i == 0u) {",
    ),
    mutant(
        "bar as a sphere",
        "bar along warp, clamped ends",
        "abs(point.x), scene.body_bar != 0u",
        "abs(point.x), false",
    ),
    mutant("arc as its chord", "ogive, oblique, friction", "if (i == 0u && 0.0 < scene.profile_arc) {", "if (false) {"),
    mutant(
        "centre of the arc inside out",
        "ogive, oblique, friction",
        "let centre = start + arc * normal;",
        "let centre = start - arc * normal;",
    ),
    mutant(
        "arc flattened",
        "ogive, oblique, friction",
        "let past = 2.0 * arc * dot(normal, start) + dot(start, start);",
        "let past = 2.0 * arc * dot(normal, start);",
    ),
    mutant(
        "height over the arc doubled",
        "ogive, oblique, friction",
        "let rise = past / (size + arc);",
        "let rise = past / size;",
    ),
    mutant(
        "arc beyond its tip",
        "edges of an ogive",
        "let away = select(start, select(out * rise, start - edge, ended), begun);",
        "let away = select(out * rise, start - edge, ended);",
    ),
    mutant(
        "arc beyond its end",
        "edges of an ogive, tail first",
        "select(out * rise, start - edge, ended)",
        "out * rise",
    ),
    mutant("arc around the wall", "ogive, side first", "select(rise, start.x - edge.x, wall)", "rise"),
    mutant("normal of the arc on the wall", "ogive, side first", "select(out, vec2<f32>(1.0, 0.0), wall)", "out"),
    mutant("chisel as a flat nose", "fragment", "if (!RIM && scene.chisel != 0u) {", "if (false) {"),
    mutant(
        "recess from the middle of the strip",
        "rim of a fragment",
        "max((abs(point.y) - scene.chisel_half) * scene.chisel_slope, 0.0)",
        "abs(point.y) * scene.chisel_slope",
    ),
    mutant(
        "no recess behind the flats",
        "rim of a fragment",
        "scene.profile[1].y - recess(point) - point.z",
        "scene.profile[1].y - point.z",
    ),
    mutant(
        "held along the axis behind a flat",
        "rim of a fragment",
        "let on_flat = scene.chisel != 0u && scene.chisel_half < abs(point.y);",
        "let on_flat = false;",
    ),
    mutant(
        "held along the other flat",
        "rim of a fragment",
        "select(scene.chisel_sine, -scene.chisel_sine, point.y < 0.0)",
        "scene.chisel_sine",
    ),
    mutant(
        "flat begins in the middle",
        "fragment",
        "let over_flat = (at.y - scene.chisel_half) *",
        "let over_flat = at.y *",
    ),
    mutant(
        "one flat for two",
        "fragment",
        "let at = vec3<f32>(abs(point.xy), point.z - front);",
        "let at = vec3<f32>(abs(point.x), point.y, point.z - front);",
    ),
    mutant(
        "normals of one quarter",
        "fragment",
        "let turned = select(normal.xy, -normal.xy, point.xy < vec2<f32>(0.0));",
        "let turned = normal.xy;",
    ),
    mutant("distances as heights", "edges of a fragment", "if (0.0 < second) {", "if (false) {"),
    mutant(
        "least height for the largest",
        "fragment",
        "if (deepest < heights[i]) {",
        "if (heights[i] < deepest || i == 0u) {",
    ),
    mutant(
        "wall without its normal",
        "fragment, side first",
        "select(at.x / safe, 1.0, on_axis), at.y / safe, 0.0)",
        "1.0, 0.0, 0.0)",
    ),
    mutant("tail left out", "fragment, side first", "rho - radius, back - point.z)", "rho - radius, -1e30)"),
    mutant(
        "wall of a chisel not reached",
        "edges of a fragment",
        "let wall = vec3<f32>(point.xy * shrink, point.z);",
        "let wall = point;",
    ),
    mutant(
        "rim of the tail not reached",
        "edges of a fragment, tail first",
        "max(min(point.z, -recess(wall)), back)",
        "min(point.z, -recess(wall))",
    ),
    mutant(
        "rim of the strip not reached",
        "edges of a fragment",
        "max(min(point.z, -recess(wall)), back)",
        "max(point.z, back)",
    ),
    mutant(
        "edge of the strip left out",
        "edges of a fragment",
        "best = see(best, true, point - vec3<f32>(min(point.x, scene.chisel_corner), scene.chisel_half, 0.0));",
        "",
    ),
    mutant("edge of the strip without end", "edges of a fragment", "min(point.x, scene.chisel_corner)", "point.x"),
    mutant("flat left out", "rounded fragment", "best = see(best, on_flat, vec3<f32>(0.0, down));", ""),
    mutant(
        "flat without end",
        "edges of a fragment",
        "best = see(best, on_flat, vec3<f32>(0.0, down));",
        "best = see(best, true, vec3<f32>(0.0, down));",
    ),
    mutant(
        "edge between flat and wall left out",
        "edges of a fragment",
        "best = see(best, scene.chisel_half <= rim.y, point - vec3<f32>(rim, -drop));",
        "",
    ),
    mutant(
        "edge between flat and wall at one height",
        "edges of a fragment",
        "vec3<f32>(rim, -drop)",
        "vec3<f32>(rim, 0.0)",
    ),
    mutant("ellipse as a circle", "edges of a fragment", "let bend = squared(scene.chisel_slope);", "let bend = 0.0;"),
    mutant(
        "ellipse seen from above",
        "edges of a fragment",
        "(point.y - scene.chisel_slope * (point.z - scene.chisel_half * scene.chisel_slope)) / size",
        "point.y / size",
    ),
    mutant("no step along the ellipse", "edges of a fragment", "i < ELLIPSE_STEPS", "i < 0u"),
    mutant(
        "farthest candidate",
        "edges of a fragment",
        "if (there && square < best.square) {",
        "if (there && (square > best.square || best.square == 1e30)) {",
    ),
];
