//! Plan of a pack: its opening, what clamps it, the warps of its plies, and where the projectile is aimed at.

use crate::case::{Case, Edge, Edges, Layer, Opening, Shape};
use crate::output::number::short;

/// Clamps and free sides of every ply, in words.
pub fn held(case: &Case) -> String {
    let mut words: Vec<String> = Vec::new();
    let layers = case.layers();
    for (index, layer) in layers.iter().enumerate() {
        let sides = of_sides(&layer.edges);
        let sides = match case.pack.window {
            Some(window) => format!("all outside a round window of {} mm", short(window.diameter * 1e3, 4)),
            None if layer.mesh.frame.corner > 0.0 => {
                format!("{sides}; {} mm at each corner clamped", short(layer.mesh.frame.corner * 1e3, 4))
            }
            None => sides,
        };
        let turned = if layer.mesh.frame.opening == Opening::Rectangle { ", cut to the frame" } else { "" };
        let alike = layers
            .iter()
            .all(|other| other.edges == layer.edges && other.mesh.frame.opening == layer.mesh.frame.opening);
        let text = if alike { sides + turned } else { format!("/pack/layup/{index}: {sides}{turned}") };
        if !words.contains(&text) {
            words.push(text);
        }
    }
    words.join("; ")
}

/// Backing of the pack, in words.
pub fn behind(case: &Case) -> String {
    let Some(clay) = case.backing else { return "nothing".to_owned() };
    let gap = if clay.gap > 0.0 { format!("{} mm of air, then ", short(clay.gap * 1e3, 4)) } else { String::new() };
    let deeper = clay.doubling_depth.map(|depth| format!(", twice that {} mm deep", short(depth * 1e3, 4)));
    format!("{gap}clay that resists with {} MPa{}", short(clay.pressure * 1e-6, 3), deeper.unwrap_or_default())
}

/// Sides by what holds them.
fn of_sides(edges: &Edges) -> String {
    let sides = [("left", edges.left), ("right", edges.right), ("bottom", edges.bottom), ("top", edges.top)];
    let of = |edge: Edge| {
        let names: Vec<&str> = sides.iter().filter(|(_, own)| *own == edge).map(|(name, _)| *name).collect();
        let names = if names.len() == sides.len() { "all sides".to_owned() } else { names.join(", ") };
        (!names.is_empty())
            .then(|| format!("{names} {}", if edge == Edge::Roller { "on rollers" } else { edge.word() }))
    };
    [Edge::Clamped, Edge::Roller, Edge::Free].into_iter().filter_map(of).collect::<Vec<_>>().join("; ")
}

/// Width of the drawing, and its margin.
const PAPER: [f64; 2] = [440.0, 12.0];

/// Corners of a rectangle of these half sizes, turned by the angle of this cosine and sine: left bottom, right bottom, right top, left top.
fn rectangle([a, b]: [f64; 2], [c, s]: [f64; 2]) -> [[f64; 2]; 4] {
    [[-a, -b], [a, -b], [a, b], [-a, b]].map(|[x, y]| [c * x - s * y, s * x + c * y])
}

/// The plan as SVG, Y upwards; classes as of the page.
pub(super) fn drawing(case: &Case) -> String {
    let (pack, layers) = (&case.pack, case.layers());
    let sizes = case.projectile.as_ref().map(|p| (p.offset, 0.5 * p.shape.diameter()));
    let aimed = sizes.map_or(0.0, |([x, y], radius)| x.abs().max(y.abs()) + radius);
    let [width, height] = pack.size();
    let half = (0.5 * width.max(height)).max(aimed);
    let [paper, margin] = PAPER;
    let scale = (0.5 * paper - margin) / half;
    let tall = 2.0 * (0.5 * height).max(aimed) * scale + 2.0 * margin;
    let at = |[x, y]: [f64; 2]| [0.5 * paper + scale * x, 0.5 * tall - scale * y];
    let points = |corners: &[[f64; 2]]| {
        corners.iter().map(|corner| at(*corner).map(|x| format!("{x:.1}")).join(",")).collect::<Vec<_>>().join(" ")
    };
    let mut out = format!("<svg viewBox=\"0 0 {paper} {tall:.1}\" role=\"img\" aria-label=\"{}\">", held(case));
    let whole = points(&rectangle([0.5 * width, 0.5 * height], [1.0, 0.0]));
    let held = if pack.window.is_some() { "clamp" } else { "cloth" };
    out += &format!("<polygon class=\"{held}\" points=\"{whole}\"/>");
    if let Some(window) = pack.window {
        let ([x, y], radius) = (at([0.0; 2]), 0.5 * window.diameter * scale);
        out += &format!("<circle class=\"cloth\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>");
    }
    for layer in layers.iter() {
        out += &sides(layer, &points);
        let (s, c) = layer.orientation.sin_cos();
        let length = 0.3 * width.min(height);
        out += &format!(
            "<polyline class=\"warp\" points=\"{}\"/>",
            points(&[[-c * length, -s * length], [c * length, s * length]])
        );
    }
    if let (Some(([x, y], radius)), Some(projectile)) = (sizes, &case.projectile) {
        out += &match projectile.shape {
            Shape::Bar { along, .. } => {
                let mut half = [radius; 2];
                half[along as usize] = 0.5 * [width, height][along as usize];
                format!(
                    "<polygon class=\"aim\" points=\"{}\"/>",
                    points(&rectangle(half, [1.0, 0.0]).map(|[a, b]| [a + x, b + y]))
                )
            }
            _ => {
                let [cx, cy] = at([x, y]);
                format!("<circle class=\"aim\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{:.1}\"/>", (radius * scale).max(1.0))
            }
        };
    }
    out + "</svg>"
}

/// Sides and corner clamps of a ply.
fn sides(layer: &Layer, points: &impl Fn(&[[f64; 2]]) -> String) -> String {
    let frame = &layer.mesh.frame;
    if frame.opening == Opening::Round {
        return String::new();
    }
    let (s, c) = layer.orientation.sin_cos();
    let corners = match frame.opening {
        Opening::Mesh => rectangle([0, 1].map(|a| 0.5 * layer.mesh.count[a] as f64 * layer.mesh.length[a]), [c, s]),
        _ => rectangle(frame.half, [1.0, 0.0]),
    };
    let Edges { left, right, bottom, top } = layer.edges;
    let of = [(0, 3, left), (1, 2, right), (0, 1, bottom), (3, 2, top)];
    let lines = of.map(|(from, to, edge)| {
        format!("<polyline class=\"{}\" points=\"{}\"/>", edge.word(), points(&[corners[from], corners[to]]))
    });
    let clamps = corners.map(|[x, y]| {
        let inner = [x - frame.corner.copysign(x), y - frame.corner.copysign(y)];
        format!("<polygon class=\"clamp\" points=\"{}\"/>", points(&[[x, y], [inner[0], y], inner, [x, inner[1]]]))
    });
    lines.into_iter().chain(clamps.into_iter().filter(|_| frame.corner > 0.0)).collect()
}
