//! Changes of a JSON document: a value becomes another, moves or goes.

use serde_json::{Map, Value, json};

/// What separates the document from what comes after it.
const CUT: &[u8] = b"\n----\n";

struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % count.max(1) as u64) as usize
    }
}

/// A changed document, with what came after it; `None` where there is no document.
pub fn json(bytes: &[u8], seed: u32) -> Option<Vec<u8>> {
    let end = bytes.windows(CUT.len()).position(|window| window == CUT).unwrap_or(bytes.len());
    let mut document: Value = serde_json::from_slice(&bytes[..end]).ok()?;
    let mut random = Random(seed.into());
    for _ in 0..=random.below(3) {
        change(&mut document, &mut random);
    }
    let mut new = document.to_string().into_bytes();
    new.extend_from_slice(&bytes[end..]);
    Some(new)
}

fn change(document: &mut Value, random: &mut Random) {
    let mut pointers = Vec::new();
    collect(document, String::new(), &mut pointers);
    let pointer = pointers[random.below(pointers.len())].clone();
    let other = document.pointer(&pointers[random.below(pointers.len())]).cloned().unwrap_or_default();
    let Some(value) = document.pointer_mut(&pointer) else { return };
    match random.below(8) {
        0 => *value = other,
        1 => remove_one(value, random),
        2 => {
            if let Value::Object(map) = value {
                map.insert(WORDS[random.below(WORDS.len())].to_owned(), other);
            }
        }
        3 => {
            if let Value::Array(items) = value {
                items.insert(random.below(items.len() + 1), other);
            }
        }
        _ => *value = leaf(value, random),
    }
}

fn collect(value: &Value, pointer: String, found: &mut Vec<String>) {
    let escaped = |key: &str| key.replace('~', "~0").replace('/', "~1");
    match value {
        Value::Object(map) => {
            map.iter().for_each(|(key, inner)| collect(inner, format!("{pointer}/{}", escaped(key)), found))
        }
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(n, inner)| collect(inner, format!("{pointer}/{n}"), found))
        }
        _ => {}
    }
    found.push(pointer);
}

fn remove_one(value: &mut Value, random: &mut Random) {
    match value {
        Value::Object(map) => {
            if let Some(key) = map.keys().nth(random.below(map.len())).cloned() {
                map.shift_remove(&key);
            }
        }
        Value::Array(items) if !items.is_empty() => drop(items.remove(random.below(items.len()))),
        _ => {}
    }
}

/// Another leaf: of a number mostly one of its kind.
fn leaf(value: &Value, random: &mut Random) -> Value {
    if let (Some(number), true) = (value.as_f64(), random.below(4) > 0) {
        let factors = [-1.0, 0.0, 0.5, 0.99, 1.01, 2.0, 10.0, 0.1, 1e3, 1e-3, 1e9, 1e-9, 1e150, 1e-150];
        let changed =
            number * factors[random.below(factors.len())] + f64::from(random.below(3) as u32) * number.abs() * 1e-16;
        return if random.below(3) == 0 { json!(changed.round() as i64) } else { json!(changed) };
    }
    match random.below(6) {
        0 => Value::Null,
        1 => json!(random.below(2) == 0),
        2 => Value::Object(Map::new()),
        3 => json!([]),
        4 => {
            let numbers = [0.0, 1.0, -1.0, 2.0, 64.0, 65.0, 90.0, 180.0, 1e-300, 1e300, 4294967296.0, 1e-9];
            json!(numbers[random.below(numbers.len())])
        }
        _ => json!(WORDS[random.below(WORDS.len())]),
    }
}

/// Keys and words of cases.
const WORDS: &[&str] = &[
    "rad",
    "deg",
    "mm",
    "denier",
    "tex",
    "dtex",
    "title",
    "fabric",
    "pack",
    "projectile",
    "solver",
    "output",
    "expect",
    "sources",
    "notes",
    "name",
    "fibre_density_kg_m3",
    "areal_density_g_m2",
    "warp",
    "weft",
    "crossover",
    "thickness_mm",
    "shear",
    "none",
    "absent",
    "linear_density_denier",
    "false",
    "linear_density_tex",
    "linear_density_dtex",
    "modulus_gpa",
    "failure_strain",
    "count_per_inch",
    "count",
    "count_per_cm",
    "crimp",
    "law",
    "published",
    "membrane_force",
    "tension",
    "gap_mm",
    "compression",
    "rigid",
    "a_mm",
    "b_mm_n13",
    "g1_mpa",
    "g2_mpa",
    "gamma1",
    "gamma2",
    "modulus",
    "tangent",
    "plies",
    "width_mm",
    "height_mm",
    "edges",
    "clamped",
    "crossovers_per_element",
    "elements_per_crossover",
    "mesh_grading",
    "graded",
    "spacing_mm",
    "friction",
    "pretension",
    "initial_velocity_m_s",
    "initial_deflection",
    "flat",
    "layup",
    "fine_radius_mm",
    "growth",
    "coarsest",
    "orientation_deg",
    "left",
    "right",
    "bottom",
    "top",
    "warp_n_per_m",
    "weft_n_per_m",
    "amplitude_mm",
    "warp_half_waves",
    "weft_half_waves",
    "cylinder",
    "cone",
    "ogive",
    "fragment",
    "sphere",
    "shape",
    "diameter_mm",
    "length_mm",
    "nose_length_mm",
    "nose_flat_mm",
    "nose_angle_deg",
    "roll_deg",
    "edge_radius_mm",
    "along",
    "bar",
    "mass_g",
    "motion",
    "prescribed",
    "density_kg_m3",
    "axial_inertia_g_mm2",
    "transverse_inertia_g_mm2",
    "velocity_m_s",
    "offset_mm",
    "centred",
    "standoff_mm",
    "obliquity_deg",
    "azimuth_deg",
    "yaw_deg",
    "angular_velocity_rad_s",
    "free",
    "rotation",
    "end_time_us",
    "numerics",
    "default",
    "accuracy",
    "courant",
    "hourglass",
    "shock_viscosity",
    "failure_length_mm",
    "symmetry",
    "auto",
    "contact_sampling",
    "unit_cell",
    "joint",
    "run_until",
    "outcome",
    "history_interval_us",
    "frames",
    "profile_times_us",
    "profile_along",
    "quantity",
    "value",
    "min",
    "max",
    "tolerance",
    "at_us",
    "between_us",
    "source",
    "known_difference",
    "variational",
    "roller",
    "locked",
    "nodes",
    "rim",
    "paper",
    "converged",
    "bracketed",
    "separation",
    "end_time",
    "ball",
    "fsp",
    "rcc",
    "5%",
    "fabrics/s-720.json",
    "fabrics/own.json",
    "stopped",
    "perforated",
    "residual_velocity_m_s",
    "energy_error",
    "$schema",
];
