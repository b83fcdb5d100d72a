//! Random scenes: a plain shot with some of its keys changed, as a complete case document.
//!
//! Each change is drawn, or not, on its own, so that shrinking takes away one after the other and what is left of a
//! failing scene is the plain shot with the few changes that matter. Seed and number give the same scene on every machine.

use std::ops::Range;

use proptest::option::weighted;
use proptest::prelude::{BoxedStrategy, Just, Strategy, any, prop_oneof};
use proptest::sample::select;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde_json::{Value, json};

use super::user;
use crate::case::{self, Case, Law};
use crate::model::Model;

/// Keys of the case, by JSON pointer, with their values.
type Change = Vec<(&'static str, Value)>;

/// What a scene is made of.
#[derive(Clone, Debug)]
pub(super) struct RandomScene {
    /// Elements along warp and weft.
    cells: [u32; 2],
    changes: Vec<Change>,
    /// Point of aim from the centre, over the size of the pack.
    aim: Option<[f64; 2]>,
    /// Initial tension over what breaks the yarns.
    pretension: Option<[f64; 2]>,
    /// Steps of the run, about.
    steps: u32,
    /// A whole case instead, as a user would write it.
    user: Option<Value>,
    /// What not every machine computes; drawn last, so that the rest is the same scene without them.
    further: Vec<Change>,
}

impl RandomScene {
    /// The scene without some of what not every machine computes, the fewest left out first; the whole is not among them.
    pub(super) fn with_less(&self) -> impl Iterator<Item = Self> + '_ {
        // A user's scene has none of them.
        let drawn = if self.user.is_some() { 0 } else { self.further.len() };
        let given: Vec<usize> = (0..drawn).filter(|at| !self.further[*at].is_empty()).collect();
        let mut without: Vec<u32> = (1..1 << given.len()).collect();
        without.sort_by_key(|left_out| left_out.count_ones());
        without.into_iter().map(move |left_out| {
            let mut less = self.clone();
            let gone = given.iter().enumerate().filter(|(bit, _)| left_out >> bit & 1 == 1);
            gone.for_each(|(_, at)| less.further[*at].clear());
            less
        })
    }
}

/// A tree of the scene with this number, to be shrunk; `None` does not happen.
pub(super) fn tree(seed: u64, number: u64) -> Option<impl proptest::strategy::ValueTree<Value = RandomScene>> {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..16].copy_from_slice(&number.to_le_bytes());
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &bytes));
    draws().new_tree(&mut runner).ok()
}

fn draws() -> impl Strategy<Value = RandomScene> {
    let anywhere = || number(-0.6..0.6);
    let side = || select(vec![0.5, -0.5]);
    let aim = prop_oneof![
        3 => [anywhere(), anywhere()],
        1 => [side().boxed(), anywhere().boxed()],
        1 => [anywhere().boxed(), side().boxed()],
        1 => [side(), side()],
    ];
    let pretension = [number(0.0..0.4), number(0.0..0.4)];
    let cells = [1_u32..25, 1_u32..25];
    let parts =
        (cells, changes(), weighted(0.5, aim), weighted(0.2, pretension), 20_u32..400, user::scenes(), further());
    parts.prop_map(|(cells, changes, aim, pretension, steps, user, further)| RandomScene {
        cells,
        changes,
        aim,
        pretension,
        steps,
        user,
        further,
    })
}

/// Four significant digits: a case that people can read.
pub(super) fn short(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// Values of a range: few enough to be shrunk in a dozen trials, to zero in a range around it, else to the start.
const VALUES: i32 = 1000;

/// Uniform; a range that begins below zero is as wide above it.
pub(super) fn number(range: Range<f64>) -> BoxedStrategy<f64> {
    let Range { start, end } = range;
    if start < 0.0 {
        return (-VALUES..VALUES + 1).prop_map(move |i| short(end * f64::from(i) / f64::from(VALUES))).boxed();
    }
    (0..VALUES + 1).prop_map(move |i| short(start + (end - start) * f64::from(i) / f64::from(VALUES))).boxed()
}

/// Uniform in the logarithm.
pub(super) fn log(range: Range<f64>) -> BoxedStrategy<f64> {
    let Range { start, end } = range;
    (0..VALUES + 1).prop_map(move |i| short(start * (end / start).powf(f64::from(i) / f64::from(VALUES)))).boxed()
}

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

/// Zero now and then, else in the logarithm.
pub(super) fn zero_or(range: Range<f64>) -> BoxedStrategy<f64> {
    prop_oneof![1 => Just(0.0), 3 => log(range)].boxed()
}

fn changes() -> Vec<BoxedStrategy<Change>> {
    let mut all = fabric();
    all.extend(pack());
    all.extend(projectile());
    all.extend([
        key(0.5, "/solver/courant", number(0.2..0.95)),
        key(0.3, "/solver/hourglass", zero_or(1e-4..1.0)),
        word(0.5, "/solver/unit_cell", &["newton", "safeguarded"]),
        word(0.3, "/solver/symmetry", &["auto", "none"]),
        word(0.5, "/solver/run_until", &["end_time", "outcome"]),
    ]);
    all
}

/// Meshes other than even ones of whole crossovers, failure and contact other than the paper's.
fn further() -> Vec<BoxedStrategy<Change>> {
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
    let law =
        prop_oneof![Just(("published", "projected")), Just(("variational", "tension")), Just(("kawabata", "tension")),];
    let law = law.prop_map(|(law, force)| {
        vec![("/fabric/crossover/law", law.into()), ("/fabric/crossover/membrane_force", force.into())]
    });
    let angles = [number(0.0..0.7), number(0.0..0.7)];
    let stiff = [zero_or(0.1..100.0), log(1.0..10.0)];
    let shear = (angles, stiff, select(vec!["tangent", "secant"])).prop_map(|([first, more], [g, times], modulus)| {
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
        keys(0.6, law),
        key(0.2, "/fabric/crossover/gap_mm", log(1e-4..0.1)),
        key(0.5, "/fabric/crossover/compression", compression),
        key(0.4, "/fabric/shear", shear),
    ]
}

fn pack() -> Vec<BoxedStrategy<Change>> {
    const EDGES: [&str; 3] = ["clamped", "free", "roller"];
    let sides = [(); 4].map(|()| select(EDGES.to_vec()));
    let sides = sides
        .prop_map(|[left, right, bottom, top]| json!({"left": left, "right": right, "bottom": bottom, "top": top}));
    let edges = prop_oneof![1 => Just(json!("free")), 1 => Just(json!("roller")), 2 => sides];
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
    let ogive = size().prop_map(move |(d, l, nose, _)| {
        let l = l.max(0.6 * d);
        let nose = (0.51 * d + nose * (l - 0.51 * d)).min(l);
        let [l, nose] = [l, nose].map(short);
        whole(json!({"shape": "ogive", "diameter_mm": d, "length_mm": l, "nose_length_mm": nose.min(l)}))
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

/// What a bar has not.
const TURNING: [&str; 5] =
    ["yaw_deg", "angular_velocity_rad_s", "rotation", "axial_inertia_g_mm2", "transverse_inertia_g_mm2"];

/// Largest hourglass coefficient of a pack, five times the default: where plies are moved apart, its energy is booked to first
/// order, and the ledger's error grows with it.
const PACK_HOURGLASS: f64 = 0.005;

/// The plain shot.
fn plain() -> Value {
    json!({
        "title": "random scene",
        "fabric": {
            "name": "S-720", "fibre_density_kg_m3": 1440,
            "warp": {"linear_density_denier": 1420, "modulus_gpa": 96, "failure_strain": 0.035, "count_per_inch": 20, "crimp": 0.0218},
            "weft": {"linear_density_denier": 1420, "modulus_gpa": 96, "failure_strain": 0.035, "count_per_inch": 20, "crimp": 0.0139},
            "crossover": {},
            "shear": {},
        },
        "pack": {},
        "projectile": {"mass_g": 1, "velocity_m_s": 200},
        "solver": {"end_time_us": 1, "run_until": "end_time"},
        "output": {"history_interval_us": 1},
    })
}

/// Sets the value at a pointer; objects on the way are made where they are missing.
fn put(document: &mut Value, pointer: &str, value: Value) {
    let place = pointer.split('/').skip(1).fold(document, |at, part| &mut at[part]);
    *place = value;
}

/// The document of a draw, but for its end.
pub(super) fn document(draw: &RandomScene) -> Value {
    if let Some(user) = &draw.user {
        return user.clone();
    }
    let mut document = plain();
    let mut shape = json!({"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 10});
    let mut nothing = false;
    let absent = |document: &Value, yarn: &str| document.pointer(&format!("/fabric/{yarn}/absent")).is_some();
    for (pointer, value) in draw.changes.iter().chain(&draw.further).flatten() {
        match *pointer {
            "/projectile/shape" => shape = value.clone(),
            "/projectile" => nothing = true,
            // A yarn that is not there has nothing but its count.
            of_yarn
                if ["warp", "weft"]
                    .iter()
                    .any(|y| of_yarn.starts_with(&format!("/fabric/{y}/")) && absent(&document, y)) =>
            {
                if of_yarn.ends_with("count_per_inch") {
                    put(&mut document, pointer, value.clone());
                }
            }
            _ => put(&mut document, pointer, value.clone()),
        }
    }
    let size = size(&mut document, draw);
    if let Some(share) = draw.pretension {
        pretension(&mut document, share);
    }
    // Plies that lie differently would bulge into each other.
    if let (true, Some(pack)) = (document["pack"].get("layup").is_some(), document["pack"].as_object_mut()) {
        pack.shift_remove("initial_deflection");
    }
    let several = ["plies", "layup"].iter().any(|key| document["pack"].get(key).is_some());
    if several && document["solver"]["hourglass"].as_f64().is_some_and(|h| h > PACK_HOURGLASS) {
        put(&mut document, "/solver/hourglass", PACK_HOURGLASS.into());
    }
    if nothing {
        document["projectile"] = Value::Null;
        return document;
    }
    let never_turns = shape["shape"] == "bar";
    if let (Some(projectile), Value::Object(shape)) = (document["projectile"].as_object_mut(), shape) {
        projectile.extend(shape);
        for key in TURNING.iter().filter(|_| never_turns) {
            projectile.shift_remove(*key);
        }
    }
    if let Some(aim) = draw.aim {
        put(&mut document, "/projectile/offset_mm", json!([0, 1].map(|i| short(aim[i] * size[i]))));
    }
    document
}

/// Gives the pack the number of elements drawn; returns its size [mm].
fn size(document: &mut Value, draw: &RandomScene) -> [f64; 2] {
    let given = |key: &str| document["pack"][key].as_f64().unwrap_or(1.0);
    let per_element = given("crossovers_per_element") / given("elements_per_crossover");
    let length = ["warp", "weft"].map(|yarn| {
        let count = document["fabric"][yarn]["count_per_inch"].as_f64().unwrap_or(20.0);
        per_element * 25.4 / count
    });
    let size = [0, 1].map(|i| short(f64::from(draw.cells[i]) * length[i]));
    put(document, "/pack/width_mm", size[0].into());
    put(document, "/pack/height_mm", size[1].into());
    size
}

/// Stretches each direction by a share of what breaks its yarns.
fn pretension(document: &mut Value, share: [f64; 2]) {
    let per_metre = 1.0 / 0.0254;
    for (i, [yarn, other, key]) in
        [["warp", "weft", "warp_n_per_m"], ["weft", "warp", "weft_n_per_m"]].into_iter().enumerate()
    {
        let number = |yarn: &str, key: &str| document["fabric"][yarn][key].as_f64();
        let properties =
            (number(yarn, "modulus_gpa"), number(yarn, "linear_density_denier"), number(yarn, "failure_strain"));
        if let (Some(modulus), Some(denier), Some(limit)) = properties {
            let stiffness = modulus * 1e9 * denier / 9e6 / 1440.0;
            let count = number(other, "count_per_inch").unwrap_or(20.0) * per_metre;
            let force = short(share[i] * limit.min(0.03) * stiffness * count);
            put(document, &format!("/pack/pretension/{key}"), force.into());
        }
    }
}

/// Elements times steps of a user's scene, about.
const USER_WORK: f64 = 2e6;
/// Steps of a user's scene, at least.
const USER_STEPS: f64 = 60.0;

/// The model of a case, with a law whose energy needs no table: its mesh and step are the same.
fn model(mut case: Case) -> Result<Model<f64>, String> {
    let layers = case.pack.layup.iter_mut().map(|layer| &mut layer.fabric);
    for fabric in layers.chain([&mut case.fabric]).filter(|fabric| fabric.crossover.law == Law::Published) {
        fabric.crossover.law = Law::Variational;
    }
    Model::new(&case).map_err(|error| error.to_string())
}

/// The case of a draw, or why there is none.
pub(super) fn case(draw: &RandomScene, name: &str) -> Result<Case, String> {
    let mut document = document(draw);
    document["title"] = name.into();
    let read = |document: &Value| case::from_str(name, &document.to_string(), &[]).map_err(|error| error.to_string());
    if draw.user.is_some() {
        // As long as was drawn, or as time allows.
        let model = model(read(&document)?)?;
        let steps = (USER_WORK / model.elements() as f64).max(USER_STEPS);
        let end = document["solver"]["end_time_us"].as_f64().unwrap_or(f64::INFINITY);
        document["solver"]["end_time_us"] = short(end.min(steps * model.dt * 1e6)).into();
        return read(&document);
    }
    // As many steps as were drawn, whatever the step is.
    let step = model(read(&document)?)?.dt;
    let end = short(f64::from(draw.steps) * step * 1e6);
    document["solver"]["end_time_us"] = end.into();
    document["output"]["history_interval_us"] = short(end / 20.0).into();
    read(&document)
}
