//! What a random scene changes of the plain shot.

use proptest::option::weighted;
use proptest::prelude::{BoxedStrategy, Just, Strategy, any, prop_oneof};
use proptest::sample::select;
use serde_json::{Value, json};

use super::values::{any_sides, log, number, short, zero_or};

/// Keys of the case, by JSON pointer, with their values.
pub(super) type Change = Vec<(&'static str, Value)>;

/// Changes one key, or leaves it.
fn key<T>(share: f64, pointer: &'static str, value: impl Strategy<Value = T> + 'static) -> BoxedStrategy<Change>
where
    T: Into<Value> + std::fmt::Debug + Clone,
{
    keys(share, value.prop_map(move |value| vec![(pointer, value.into())]))
}

/// Changes some keys, or leaves them.
fn keys(share: f64, change: impl Strategy<Value = Change> + 'static) -> BoxedStrategy<Change> {
    weighted(share, change).prop_map(Option::unwrap_or_default).boxed()
}

fn word(share: f64, pointer: &'static str, words: &[&'static str]) -> BoxedStrategy<Change> {
    key(share, pointer, select(words.to_vec()))
}

/// What every machine computes.
pub(super) fn changes() -> Vec<BoxedStrategy<Change>> {
    let mut all = fabric();
    all.extend(pack());
    all.extend(projectile());
    all.extend([
        key(0.5, "/solver/courant", number(0.2..0.95)),
        key(0.3, "/solver/hourglass", zero_or(1e-4..1.0)),
        word(0.3, "/solver/symmetry", &["auto", "none"]),
        word(0.5, "/solver/run_until", &["end_time", "outcome"]),
    ]);
    all
}

/// Meshes other than even ones of whole crossovers, failure and contact other than the paper's.
pub(super) fn further() -> Vec<BoxedStrategy<Change>> {
    // From no fine elements but those struck, to nothing but fine ones; no element may be finer than the finest.
    let grading = (log(0.1..30.0), number(1.0..2.0), 4_u32..33).prop_map(
        |(fine, growth, coarsest)| json!({"fine_radius_mm": fine, "growth_ratio": growth, "max_crossovers": coarsest}),
    );
    let grading = prop_oneof![1 => Just(json!("graded")), 3 => grading];
    vec![
        key(0.2, "/pack/elements_per_crossover", 2_u32..5),
        key(0.25, "/pack/mesh_grading", grading),
        word(0.35, "/solver/contact_sampling", &["edges"]),
    ]
}

fn fabric() -> Vec<BoxedStrategy<Change>> {
    let crimp = || prop_oneof![1 => Just(0.0), 3 => number(0.0..0.25)];
    let breaks = || prop_oneof![4 => log(1e-3..0.3), 1 => Just(1.0)];
    let pressed = [log(0.005..0.3), log(0.005..0.3)].prop_map(|[a, b]| json!({"a_mm": a, "b_mm_n13": b}));
    let compression = prop_oneof![1 => Just(json!("rigid")), 2 => pressed];
    let angles = [number(0.0..0.7), number(0.0..0.7)];
    let stiff = [zero_or(0.1..100.0), log(1.0..10.0)];
    let shear = (angles, stiff, Just("tangent")).prop_map(|([first, more], [g, times], modulus)| {
        json!({"g1_mpa": g, "g2_mpa": short(g * times), "gamma1": first, "gamma2": short(first + more), "modulus": modulus})
    });
    let shear = prop_oneof![1 => Just(json!("none")), 2 => shear];
    let absent = select(vec!["/fabric/warp", "/fabric/weft"])
        .prop_map(|yarn| vec![(yarn, json!({"absent": true, "count_per_inch": 20}))]);
    vec![
        keys(0.05, absent),
        key(0.4, "/fabric/warp/crimp", crimp()),
        key(0.4, "/fabric/weft/crimp", crimp()),
        key(0.25, "/fabric/warp/modulus_gpa", log(0.1..300.0)),
        key(0.25, "/fabric/weft/modulus_gpa", log(0.1..300.0)),
        key(0.3, "/fabric/warp/failure_strain", breaks()),
        key(0.3, "/fabric/weft/failure_strain", breaks()),
        key(0.25, "/fabric/warp/count_per_inch", log(8.0..80.0)),
        key(0.25, "/fabric/weft/count_per_inch", log(8.0..80.0)),
        key(0.2, "/fabric/warp/linear_density_denier", log(100.0..5000.0)),
        key(0.2, "/fabric/weft/linear_density_denier", log(100.0..5000.0)),
        key(0.2, "/fabric/areal_density_g_m2", log(50.0..2000.0)),
        key(0.3, "/fabric/thickness_mm", log(0.05..1.0)),
        key(0.6, "/fabric/crossover/law", "variational"),
        key(0.2, "/fabric/crossover/gap_mm", log(1e-4..0.1)),
        key(0.5, "/fabric/crossover/compression", compression),
        key(0.4, "/fabric/shear", shear),
    ]
}

fn pack() -> Vec<BoxedStrategy<Change>> {
    let edges = prop_oneof![1 => Just(json!("free")), 1 => Just(json!("roller")), 2 => any_sides()];
    let velocity = [(); 3].map(|()| number(-50.0..50.0)).prop_map(Vec::from);
    // What bulges towards the projectile must not start inside it.
    let bulge = (log(1e-4..1.0), any::<bool>(), [0_u32..5, 0_u32..5]).prop_map(|(size, down, [m, n])| {
        let shape =
            json!({"amplitude_mm": if down { -size } else { size }, "warp_half_waves": m, "weft_half_waves": n});
        vec![("/pack/initial_deflection", shape), ("/projectile/standoff_mm", size.into())]
    });
    let turn = prop_oneof![Just(0.0), select(vec![90.0, -90.0, 180.0]), number(-90.0..90.0),];
    // Rollers hold plies at multiples of 90° only.
    let group =
        (turn, 1_u32..3, select(vec!["clamped", "free"]), any::<bool>()).prop_map(|(turn, plies, edges, other)| {
            let mut group = json!({"plies": plies, "orientation_deg": turn, "edges": edges});
            if other {
                group["fabric"] = json!({"file": "fabrics/s-728.json"});
            }
            group
        });
    let layup = proptest::collection::vec(group, 1..4).prop_map(Value::Array);
    let plies = prop_oneof![
        2 => (1_u32..4).prop_map(|plies| vec![("/pack/plies", plies.into())]),
        1 => layup.prop_map(|layup| vec![("/pack/layup", layup)]),
    ];
    vec![
        keys(0.5, plies),
        key(0.3, "/pack/spacing_mm", zero_or(0.02..2.0)),
        key(0.3, "/pack/friction", number(0.0..2.0)),
        key(0.5, "/pack/edges", edges),
        key(0.15, "/pack/crossovers_per_element", 1_u32..5),
        key(0.1, "/pack/initial_velocity_m_s", velocity),
        keys(0.15, bulge),
    ]
}

fn projectile() -> Vec<BoxedStrategy<Change>> {
    let spin = [(); 3].map(|()| number(-1e5..1e5)).prop_map(Vec::from);
    // No body has more than twice its transverse moment about its axis.
    let inertia = (number(0.01..2.0), log(1.0..1e4)).prop_map(|(ratio, transverse)| {
        vec![
            ("/projectile/axial_inertia_g_mm2", (0.999 * ratio * transverse).into()),
            ("/projectile/transverse_inertia_g_mm2", transverse.into()),
        ]
    });
    vec![
        keys(0.8, shape()),
        key(0.6, "/projectile/mass_g", log(0.01..1e5)),
        key(0.7, "/projectile/velocity_m_s", log(1.0..2000.0)),
        key(0.2, "/projectile/standoff_mm", number(0.0..2.0)),
        key(0.4, "/projectile/obliquity_deg", number(0.0..80.0)),
        key(0.3, "/projectile/azimuth_deg", number(-180.0..180.0)),
        key(0.2, "/projectile/yaw_deg", number(-180.0..180.0)),
        key(0.2, "/projectile/angular_velocity_rad_s", spin),
        key(0.4, "/projectile/friction", number(0.0..2.0)),
        word(0.1, "/projectile/motion", &["prescribed"]),
        word(0.1, "/projectile/rotation", &["locked"]),
        keys(0.05, inertia),
        keys(0.04, Just(vec![("/projectile", Value::Null)])),
    ]
}

/// Every shape, with what it alone has.
fn shape() -> impl Strategy<Value = Change> {
    let whole = |shape: Value| vec![("/projectile/shape", shape)];
    let size = || (log(0.5..15.0), log(0.5..40.0), number(0.0..1.0), number(0.0..1.0));
    let cylinder = size().prop_map(move |(d, l, edge, _)| {
        whole(json!({"shape": "cylinder", "diameter_mm": d, "length_mm": l, "edge_radius_mm": short(0.45 * edge * d.min(l))}))
    });
    let sphere = log(0.5..15.0).prop_map(move |d| whole(json!({"shape": "sphere", "diameter_mm": d})));
    let cone = size().prop_map(move |(d, l, nose, edge)| {
        let nose = (l * (0.1 + 0.9 * nose)).max(0.01);
        // A ball of this radius fits into the thinnest of these cones.
        let edge = 0.2 * edge * d.min(l) * nose / (nose + d);
        let [nose, edge] = [nose.min(l), edge].map(short);
        whole(json!({"shape": "cone", "diameter_mm": d, "length_mm": l, "nose_length_mm": nose.min(l), "edge_radius_mm": edge}))
    });
    let ogive = size().prop_map(move |(d, l, nose, edge)| {
        let l = l.max(0.6 * d);
        let nose = (0.51 * d + nose * (l - 0.51 * d)).min(l);
        let [l, nose, edge] = [l, nose, 0.1 * edge * d].map(short);
        whole(json!({"shape": "ogive", "diameter_mm": d, "length_mm": l, "nose_length_mm": nose.min(l), "edge_radius_mm": edge}))
    });
    let fragment =
        (size(), number(5.0..75.0), number(-180.0..180.0)).prop_map(move |((d, l, flat, _), angle, roll)| {
            let flat = d * (0.2 + 0.7 * flat);
            let l = l.max(1.1 * 0.5 * (d - flat) * angle.to_radians().tan()).max(0.3 * d);
            let [flat, l] = [flat, l].map(short);
            whole(json!({"shape": "fragment", "diameter_mm": d, "length_mm": l, "nose_flat_mm": flat,
            "nose_angle_deg": angle, "roll_deg": roll}))
        });
    let bar = (log(0.1..10.0), select(vec!["warp", "weft"]))
        .prop_map(move |(d, along)| whole(json!({"shape": "bar", "diameter_mm": d, "along": along})));
    prop_oneof![cylinder, sphere, cone, ogive, fragment, bar]
}
