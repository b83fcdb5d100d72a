//! The animation as the page carries it, and its player: a description in JSON, and numbers that were rounded, written as differences in
//! time, deflated and put into base64.
//!
//! Bytes, before deflating: reference positions of all nodes (x, y, z, each all low bytes, then all high bytes); keyframe by keyframe
//! the change of the displacements since the last one in the same way; keyframe by keyframe the change of the tensions
//! of all cells, warp, then weft, one byte each, 255 where the yarn is broken.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};

use crate::case::{Case, Layer};
use crate::output::animation::{AnimatedPly, Animation};
use crate::output::number::short;
use crate::output::surface::SurfaceMesh;
use crate::run::frame::Pose;

/// Byte of a broken yarn; tensions go from 0 to the one below.
const BROKEN: u8 = 255;

/// Colour of a share of the largest value.
fn colour(share: f64) -> [u8; 3] {
    let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(share);
    [r, g, b]
}

/// All colours as a gradient of CSS, from left to right.
pub(crate) fn gradient() -> String {
    let stops = (0..=16).map(|n| colour(f64::from(n) / 16.0)).map(|[r, g, b]| format!(",#{r:02x}{g:02x}{b:02x}"));
    format!("linear-gradient(to right{})", stops.collect::<String>())
}

/// Worth of one step of the rounded numbers.
struct Rounding {
    /// [m]
    reference: f64,
    /// [m]
    displacement: f64,
    /// [N]
    tension: f64,
}

impl Rounding {
    fn of(animation: &Animation) -> Self {
        let largest = |vectors: &mut dyn Iterator<Item = &[f32; 3]>| {
            let sizes = vectors.flatten().map(|x| f64::from(x.abs())).filter(|x| x.is_finite());
            sizes.fold(1e-9, f64::max)
        };
        let reference = largest(&mut animation.plies.iter().flat_map(|ply| &ply.reference));
        let displacement = largest(&mut animation.keyframes.iter().flat_map(|keyframe| &keyframe.displacement));
        Self {
            reference: reference / 32_000.0,
            displacement: displacement / 8000.0,
            tension: f64::from(animation.peak_tension().max(1e-9)) / f64::from(BROKEN - 1),
        }
    }
}

fn bytes(animation: &Animation, steps: &Rounding) -> Vec<u8> {
    let mut out = Vec::new();
    let whole = |x: f32, step: f64| (f64::from(x) / step).round().clamp(-32_767.0, 32_767.0) as i16;
    let byte = |tension: Option<f32>| match tension {
        Some(tension) => (f64::from(tension) / steps.tension).round().clamp(0.0, f64::from(BROKEN - 1)) as u8,
        None => BROKEN,
    };
    let reference: Vec<[f32; 3]> = animation.plies.iter().flat_map(|ply| ply.reference.iter().copied()).collect();
    for axis in 0..3 {
        put_words(&mut out, reference.iter().map(|at| whole(at[axis], steps.reference)));
    }
    let mut last = vec![[0_i16; 3]; reference.len()];
    for keyframe in &animation.keyframes {
        let now: Vec<[i16; 3]> =
            keyframe.displacement.iter().map(|u| u.map(|x| whole(x, steps.displacement))).collect();
        for axis in 0..3 {
            put_words(&mut out, now.iter().zip(&last).map(|(now, last)| now[axis].wrapping_sub(last[axis])));
        }
        last = now;
    }
    let mut last = vec![[0_u8; 2]; animation.keyframes.first().map_or(0, |keyframe| keyframe.tension.len())];
    for keyframe in &animation.keyframes {
        let now: Vec<[u8; 2]> = keyframe.tension.iter().map(|cell| cell.map(byte)).collect();
        for yarn in 0..2 {
            out.extend(now.iter().zip(&last).map(|(now, last)| now[yarn].wrapping_sub(last[yarn])));
        }
        last = now;
    }
    out
}

/// Adds all low bytes, then all high ones.
fn put_words(out: &mut Vec<u8>, words: impl Iterator<Item = i16>) {
    let words: Vec<[u8; 2]> = words.map(i16::to_le_bytes).collect();
    (0..2).for_each(|half| out.extend(words.iter().map(|word| word[half])));
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default()
}

/// The projectile: points in whole steps [m], and corners of triangles.
fn body(surface: &SurfaceMesh) -> Value {
    let largest = surface.points.iter().flatten().fold(1e-9, |largest: f64, x| largest.max(x.abs()));
    let step = largest / 32_000.0;
    json!({
        "step": step,
        "points": surface.points.iter().flatten().map(|x| (x / step).round() as i64).collect::<Vec<_>>(),
        "triangles": surface.triangles().flatten().collect::<Vec<_>>(),
    })
}

fn describe(case: &Case, animation: &Animation, steps: &Rounding) -> Value {
    let layers = case.layers();
    let plies: Vec<&Layer> = layers.iter().flat_map(|layer| vec![layer; layer.plies as usize]).collect();
    let side = case.pack.crossovers_along_element();
    // Grid lines, counted in yarns: on a graded mesh they do not lie evenly.
    let yarns = |ply: &AnimatedPly, axis: usize| -> Vec<f64> {
        let places = plies.get(ply.ply).map(|layer| layer.node_lines()[axis].clone()).unwrap_or_default();
        ply.lines[axis].iter().map(|line| places.get(*line).map_or(0.0, |place| place * side)).collect()
    };
    let grid = |ply: &AnimatedPly| json!({ "ply": ply.ply, "columns": yarns(ply, 0), "rows": yarns(ply, 1) });
    let pose = |pose: Pose| [&pose.position[..], &pose.rotation].concat();
    let colours = (0..256).flat_map(|n| colour(f64::from(n) / 255.0));
    json!({
        "times": animation.keyframes.iter().map(|keyframe| keyframe.time * 1e6).collect::<Vec<_>>(),
        "opening": animation.opening(),
        "deepest": 1e3 * animation.deflection(),
        "plies": animation.plies.iter().map(grid).collect::<Vec<_>>(),
        "mirror": animation.planes.0,
        "step": { "reference": steps.reference, "displacement": steps.displacement, "tension": steps.tension },
        "poses": animation.keyframes.iter().map(|keyframe| keyframe.pose.map(pose)).collect::<Option<Vec<_>>>(),
        "body": animation.body.as_ref().map(body),
        "colours": BASE64_STANDARD.encode(colours.collect::<Vec<u8>>()),
    })
}

/// The player: its controls, which the script brings to life, and the numbers it needs.
pub(crate) fn player(case: &Case, animation: &Animation) -> Markup {
    let steps = Rounding::of(animation);
    let description = describe(case, animation, &steps);
    let numbers = BASE64_STANDARD.encode(deflated(&bytes(animation, &steps)));
    // No `<` in a script element: nothing can end it.
    let description = description.to_string().replace('<', "\\u003c");
    let shown: Vec<String> = animation.plies.iter().map(|ply| (ply.ply + 1).to_string()).collect();
    let peak = format!("{} N", short(f64::from(animation.peak_tension()), 3));
    let colours = ["tension, both yarns", "tension, warp", "tension, weft", "deflection"];
    let views = ["section", "oblique", "side", "exit side", "struck side"];
    html! {
        section id="playback" {
            h2 { "The shot in motion" }
            div class="player" hidden {
                canvas id="scene" tabindex="0" role="img" aria-label="Fabric and projectile in three dimensions" {}
                div class="controls" {
                    button type="button" id="play" aria-pressed="false" { "Play" }
                    input type="range" id="scrub" min="0" value="0" step="1" aria-label="Time";
                    output id="clock" for="scrub" { "0 µs" }
                }
                div class="controls" {
                    @for (name, id, options) in [("Colour", "colour", &colours[..]), ("View", "view", &views)] {
                        label { (name) " " select id=(id) {
                            @for (n, option) in options.iter().enumerate() { option value=(n) { (option) } }
                        } }
                    }
                    label { input type="checkbox" id="cut"; " cut open" }
                }
                p class="scale" { span id="low" { "0 N" } i {} span id="high" data-tension=(peak) { (peak) } }
                p class="note" {
                    "Space plays and pauses, ← → step, Home and End jump, drag turns, wheel or + − zoom. "
                    @if animation.ply_count > shown.len() {
                        "Of " (animation.ply_count) " plies these are shown: " (shown.join(", ")) ". "
                    }
                    "The projectile comes from below. Drawn to scale from a thinned mesh; the numbers are in the files."
                }
            }
            figure class="printed" id="paper" hidden {}
            p id="instead" { "The playback needs a screen, JavaScript and WebGL 2." }
            script type="application/json" id="animation" { (PreEscaped(description)) }
            script type="application/octet-stream" id="animation-numbers" { (PreEscaped(numbers)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;

    use super::*;
    use crate::output::animation::Keyframe;

    fn case() -> Case {
        crate::case::shipped(&["/expect=[]"])
    }

    /// An animation of one ply whose numbers follow a rule.
    fn animation(keyframes: usize, nodes: usize) -> Animation {
        let mut animation = Animation::new(&case());
        // Like noise, so that it cannot be packed.
        let rough = |n: usize| ((n * n % 99_991 * 7919) % 100_003) as f32 * 1e-8;
        let lines: [Vec<usize>; 2] = [(0..nodes).collect(), vec![0]];
        let reference = (0..nodes).map(|n| [rough(n), rough(n + 1), 0.0]).collect();
        animation.plies = vec![AnimatedPly { ply: 0, reference, own: lines.clone(), lines }];
        for at in 0..keyframes {
            animation.keyframes.push(Keyframe {
                step: at as u64,
                time: at as f64,
                deflections: vec![0.0],
                displacement: (0..nodes).map(|n| [rough(n + at), -rough(n * at), rough(at)]).collect(),
                tension: (0..nodes).map(|n| [(n % 5 > 0).then_some(n as f32), (at < 2).then_some(at as f32)]).collect(),
                pose: None,
            });
        }
        animation
    }

    #[test]
    fn numbers_come_back_to_half_a_step() {
        let animation = animation(4, 50);
        let steps = Rounding::of(&animation);
        let packed = deflated(&super::bytes(&animation, &steps));
        let mut bytes = Vec::new();
        assert!(ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).is_ok());
        let (nodes, first) = (50, 2 * 50 * (3 + 3 * animation.keyframes.len()));
        let word = |block: usize, n: usize| {
            i16::from_le_bytes([bytes[2 * nodes * block + n], bytes[2 * nodes * block + nodes + n]])
        };
        let (mut moved, mut load) = (vec![[0_i16; 3]; nodes], vec![[0_u8; 2]; nodes]);
        let half = |got: f64, step: f64, expected: f32| (got * step - f64::from(expected)).abs() <= 0.51 * step;
        for (at, keyframe) in animation.keyframes.iter().enumerate() {
            for n in 0..nodes {
                for axis in 0..3 {
                    moved[n][axis] = moved[n][axis].wrapping_add(word(3 + 3 * at + axis, n));
                    let got = f64::from(moved[n][axis]);
                    assert!(half(got, steps.displacement, keyframe.displacement[n][axis]), "{at} {n} {axis}");
                }
                for yarn in 0..2 {
                    load[n][yarn] = load[n][yarn].wrapping_add(bytes[first + nodes * (2 * at + yarn) + n]);
                    let whole = |tension| load[n][yarn] < BROKEN && half(load[n][yarn].into(), steps.tension, tension);
                    let right = keyframe.tension[n][yarn].map_or(load[n][yarn] == BROKEN, whole);
                    assert!(right, "{at} {n} {yarn}: {}", load[n][yarn]);
                }
            }
        }
        assert_eq!(bytes.len(), first + 2 * nodes * animation.keyframes.len());
    }
}
