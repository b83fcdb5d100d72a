//! Random scenes as users write them: a fabric from a table or a data sheet, a pack in a frame, a projectile from a range, and the defaults
//! for the rest.

use proptest::option::weighted;
use proptest::prelude::{Just, Strategy, prop_oneof};
use proptest::sample::select;
use serde_json::{Value, json};

use super::random::{log, number, short};

/// How many of the random scenes are such.
const SHARE: f64 = 0.03;
/// Steel [g/mm³].
const STEEL: f64 = 7.85e-3;

/// A whole case, now and then.
pub(super) fn scenes() -> impl Strategy<Value = Option<Value>> {
    let size = [number(40.0..120.0), number(40.0..120.0)];
    let edges = prop_oneof![
        3 => Just(json!("clamped")),
        1 => Just(json!({"left": "clamped", "right": "clamped", "bottom": "free", "top": "free"})),
        1 => Just(json!({"left": "free", "right": "free", "bottom": "clamped", "top": "clamped"})),
    ];
    let aim = prop_oneof![2 => Just([0.0; 2]), 1 => [number(-0.7..0.7), number(-0.7..0.7)], 1 => [number(-12.0..12.0), number(-12.0..12.0)]];
    let scene = (fabric(), 1_u32..5, size, edges, projectile(), log(50.0..900.0), aim, number(20.0..60.0));
    let scene = scene.prop_map(|(fabric, plies, [width, height], edges, mut projectile, velocity, aim, end)| {
        projectile["velocity_m_s"] = velocity.into();
        projectile["offset_mm"] = json!(aim);
        json!({
            "title": "random scene",
            "fabric": fabric,
            "pack": {"plies": plies, "width_mm": width, "height_mm": height, "edges": edges},
            "projectile": projectile,
            "solver": {"end_time_us": end, "run_until": "end_time"},
        })
    });
    weighted(SHARE, scene)
}

fn fabric() -> impl Strategy<Value = Value> {
    let law = select(vec!["published", "variational", "kawabata"]);
    let yarn = || [number(0.003..0.03), number(10.0..40.0)];
    let sheet = (log(200.0..3000.0), number(60.0..180.0), number(0.02..0.045), yarn(), yarn(), law);
    let sheet = sheet.prop_map(|(denier, modulus, strain, warp, weft, law)| {
        // Yarns that fill the cloth lie closer the finer they are.
        let yarn = |[crimp, count]: [f64; 2]| {
            json!({"linear_density_denier": denier, "modulus_gpa": modulus, "failure_strain": strain,
                "count_per_inch": short(count * (800.0 / denier).sqrt()), "crimp": crimp})
        };
        json!({"name": "data sheet", "fibre_density_kg_m3": 1440, "warp": yarn(warp), "weft": yarn(weft),
            "crossover": {"law": law}, "shear": {}})
    });
    let table = select(vec!["fabrics/s-720.json", "fabrics/s-728.json"]).prop_map(|file| json!({"file": file}));
    prop_oneof![1 => table, 2 => sheet]
}

/// Of steel, of the sizes that are shot at fabric.
fn projectile() -> impl Strategy<Value = Value> {
    let long = (number(4.5..9.0), number(1.0..4.0));
    let cylinder = |d: f64, l: f64| short(STEEL * std::f64::consts::FRAC_PI_4 * d * d * l);
    let sphere = number(4.0..12.0).prop_map(|d| {
        json!({"shape": "sphere", "diameter_mm": d, "mass_g": short(STEEL * std::f64::consts::FRAC_PI_6 * d.powi(3))})
    });
    let blunt = long.clone().prop_map(move |(d, times)| {
        let l = short(d * times);
        json!({"shape": "cylinder", "diameter_mm": d, "length_mm": l, "mass_g": cylinder(d, l)})
    });
    let pointed = (long.clone(), select(vec!["cone", "ogive"])).prop_map(move |((d, times), shape)| {
        let l = short(d * (1.0 + times));
        json!({"shape": shape, "diameter_mm": d, "length_mm": l, "nose_length_mm": d, "mass_g": cylinder(d, l)})
    });
    let fragment = number(4.5..13.0).prop_map(move |d| {
        let l = short(1.17 * d);
        json!({"shape": "fragment", "diameter_mm": d, "length_mm": l, "mass_g": cylinder(d, l)})
    });
    prop_oneof![2 => sphere, 2 => blunt, 1 => pointed, 2 => fragment]
}
