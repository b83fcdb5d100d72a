//! The case document of a random scene: the plain shot with the changes that were drawn.

use serde_json::{Value, json};

use super::random::RandomScene;
use super::values::short;
use crate::case::{self, Case, Law};
use crate::model::Model;

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
