//! Random scenes as users write them: a fabric from a table or a data ply type, a pack in a frame, a projectile from a range, and the defaults
//! for the rest.

use proptest::option::weighted;
use proptest::prelude::{Just, Strategy, prop_oneof};
use proptest::sample::select;
use serde_json::{Value, json};

use super::values::{any_sides, log, number, short, sides};

/// How many of the random scenes are such.
const SHARE: f64 = 0.05;
/// Steel [g/mm³].
const STEEL: f64 = 7.85e-3;

/// A whole case, now and then.
pub(super) fn scenes() -> impl Strategy<Value = Option<Value>> {
    let scene = (fabric(), pack(), projectile(), number(20.0..200.0));
    let scene = scene.prop_map(|(fabric, pack, projectile, end)| {
        json!({
            "title": "random scene",
            "fabric": fabric,
            "pack": pack,
            "projectile": projectile,
            "solver": {"end_time_us": end, "run_until": "end_time"},
        })
    });
    weighted(SHARE, scene)
}

/// A fabric file that comes with the program, or a data ply type.
fn fabric() -> impl Strategy<Value = Value> {
    let law = select(vec!["published", "variational"]);
    let yarn = || [number(0.003..0.03), number(10.0..40.0)];
    let ply_type = (log(200.0..3000.0), number(60.0..180.0), number(0.02..0.045), yarn(), yarn(), law);
    let ply_type = ply_type.prop_map(|(denier, modulus, strain, warp, weft, law)| {
        // Yarns that fill the cloth lie closer the finer they are.
        let yarn = |[crimp, count]: [f64; 2]| {
            json!({"linear_density_denier": denier, "modulus_gpa": modulus, "failure_strain": strain,
                "count_per_inch": short(count * (800.0 / denier).sqrt()), "crimp": crimp})
        };
        json!({"name": "data sheet", "fibre_density_kg_m3": 1440, "warp": yarn(warp), "weft": yarn(weft),
            "crossover": {"law": law}, "shear": {}})
    });
    prop_oneof![3 => file(), 2 => ply_type]
}

fn file() -> impl Strategy<Value = Value> {
    select(vec!["fabrics/s-720.json", "fabrics/s-728.json", "fabrics/twaron-ct709.json"])
        .prop_map(|file| json!({"file": file}))
}

/// One to eight plies in a frame, alike or not.
fn pack() -> impl Strategy<Value = Value> {
    let size = [number(50.0..200.0), number(50.0..200.0)];
    let few = prop_oneof![3 => 1_u32..3, 2 => 3_u32..5, 1 => 5_u32..9];
    // One of these angles, or beside a roller, which holds plies at multiples of 90° only, the one after it.
    let turn = select(vec![[0.0, 0.0], [90.0, 90.0], [45.0, 0.0], [-45.0, 90.0], [30.0, 0.0]]);
    let group = (turn, 1_u32..4, weighted(0.3, file()));
    let groups = weighted(0.2, proptest::collection::vec(group, 2..4));
    let pretension = weighted(0.1, [log(100.0..20_000.0), log(100.0..20_000.0)]);
    (size, few, edges(), groups, pretension).prop_map(|([width, height], plies, edges, groups, pretension)| {
        let mut pack = json!({"width_mm": width, "height_mm": height, "edges": edges});
        let rollers = edges.to_string().contains("roller");
        if let Some([warp, weft]) = pretension {
            pack["pretension"] = json!({"warp_n_per_m": warp, "weft_n_per_m": weft});
        }
        let Some(groups) = groups else {
            pack["plies"] = plies.into();
            return pack;
        };
        let group = |([turn, square], plies, fabric): ([f64; 2], u32, Option<Value>)| {
            let mut group = json!({"plies": plies, "orientation_deg": if rollers { square } else { turn }});
            if let Some(fabric) = fabric {
                group["fabric"] = fabric;
            }
            group
        };
        pack["layup"] = groups.into_iter().map(group).collect();
        pack
    })
}

fn edges() -> impl Strategy<Value = Value> {
    prop_oneof![
        4 => Just(json!("clamped")),
        1 => Just(sides(["clamped", "clamped", "free", "free"])),
        1 => Just(sides(["free", "free", "clamped", "clamped"])),
        1 => Just(json!("free")),
        2 => any_sides(),
    ]
}

/// Of steel, of the sizes that are shot at fabric, from any side.
fn projectile() -> impl Strategy<Value = Value> {
    let place = || [number(-0.7..0.7), number(-0.7..0.7)];
    let aim = prop_oneof![
        2 => Just([0.0; 2]),
        1 => place(),
        1 => [number(-15.0..15.0), number(-15.0..15.0)],
    ];
    let oblique = weighted(0.3, [number(0.0..60.0), number(-180.0..180.0)]);
    let yaw = weighted(0.1, number(-30.0..30.0));
    (body(), log(50.0..800.0), aim, oblique, yaw).prop_map(|(mut projectile, velocity, aim, oblique, yaw)| {
        projectile["velocity_m_s"] = velocity.into();
        projectile["offset_mm"] = json!(aim);
        if let Some([obliquity, azimuth]) = oblique {
            projectile["obliquity_deg"] = obliquity.into();
            projectile["azimuth_deg"] = azimuth.into();
        }
        if let Some(yaw) = yaw {
            projectile["yaw_deg"] = yaw.into();
        }
        projectile
    })
}

fn body() -> impl Strategy<Value = Value> {
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
