//! Fabrics and projectiles that `ripstop new` knows by name.

use ripstop::case::{Shape, builtin_fabric};
use serde_json::{Map, Value, json};

/// Density of steel [kg/m³].
const STEEL: f64 = 7850.0;
/// Proportions of a fragment simulator's nose: width of the strip over the diameter, angle of the flats [deg].
const NOSE: (f64, f64) = (0.46, 35.0);

/// Fabrics that are built in, by name.
pub(crate) const FABRICS: [(&str, &str); 3] = [
    ("s-720", "Kevlar 129, 1420 denier, 20 per inch, 255 g/m²: the paper's first"),
    ("s-728", "Kevlar 129, 1500 denier, 17 per inch, 231 g/m²: the paper's second"),
    ("twaron-ct709", "Twaron, 930 dtex, 10.5 per cm, 200 g/m²; moduli and crimp assumed"),
];

/// The text of a fabric that is built in.
pub(crate) fn fabric(name: &str) -> Option<&'static str> {
    builtin_fabric(&format!("fabrics/{name}.json"))
}

/// What a projectile known by name is made from.
enum KnownProjectile {
    /// The paper's.
    Paper,
    /// A fragment simulator: diameter [mm] and mass [g] of the standard.
    Fragment(f64, f64),
    /// A right circular cylinder as long as it is wide: mass [g].
    Cylinder(f64),
    /// A steel ball: diameter [mm].
    Ball(f64),
}

use KnownProjectile::{Ball, Cylinder, Fragment, Paper};

/// Every projectile by name, and what it is.
const PROJECTILES: [(&str, &str, KnownProjectile); 11] = [
    ("rcc-paper", "the paper's cylinder: 3 g, 5.5 × 42.1 mm, hollow steel", Paper),
    ("fsp-22", "chisel-nosed fragment simulator, .22 calibre, 17 grains", Fragment(5.46, 1.10)),
    ("fsp-30", "chisel-nosed fragment simulator, .30 calibre, 44 grains", Fragment(7.49, 2.85)),
    ("fsp-50", "chisel-nosed fragment simulator, .50 calibre, 207 grains", Fragment(12.57, 13.41)),
    ("rcc-2gr", "right circular cylinder, 2 grains, as long as wide", Cylinder(0.130)),
    ("rcc-4gr", "right circular cylinder, 4 grains, as long as wide", Cylinder(0.259)),
    ("rcc-16gr", "right circular cylinder, 16 grains, as long as wide", Cylinder(1.037)),
    ("rcc-64gr", "right circular cylinder, 64 grains, as long as wide", Cylinder(4.147)),
    ("ball-5.56", "steel ball, 7/32 inch, 0.70 g", Ball(5.556)),
    ("ball-6.35", "steel ball, 1/4 inch, 1.05 g", Ball(6.35)),
    ("ball-7.94", "steel ball, 5/16 inch, 2.06 g", Ball(7.938)),
];

/// The names, and what they stand for.
pub(crate) fn projectiles() -> Vec<(&'static str, &'static str)> {
    PROJECTILES.iter().map(|(name, what, _)| (*name, *what)).collect()
}

/// A projectile as it stands in a case, with the sources of its values.
#[derive(Debug)]
pub(crate) struct Preset {
    pub(crate) what: String,
    pub(crate) keys: Map<String, Value>,
    /// Key, empty for the whole, and text.
    pub(crate) sources: Vec<(&'static str, String)>,
}

impl Preset {
    fn new(what: impl Into<String>, keys: Value, sources: Vec<(&'static str, String)>) -> Self {
        let keys = if let Value::Object(keys) = keys { keys } else { Map::new() };
        Self { what: what.into(), keys, sources }
    }
}

/// A projectile by its name, or by shape and size: `sphere:6.35`, `rcc:5.5`, `cylinder:5.5x8` [mm].
pub(crate) fn projectile(name: &str) -> Option<Preset> {
    if let Some((_, what, known)) = PROJECTILES.iter().find(|(known, ..)| *known == name) {
        return Some(match *known {
            Paper => paper(),
            Fragment(diameter, mass) => fragment(what, diameter, mass),
            Cylinder(mass) => as_long_as_wide(what, mass),
            Ball(diameter) => solid(*what, json!({"shape": "sphere", "diameter_mm": diameter})),
        });
    }
    let (shape, size) = name.split_once(':')?;
    let sizes: Vec<f64> =
        size.split('x').map(|part| part.parse().ok().filter(|size| *size > 0.0)).collect::<Option<_>>()?;
    match (shape, &sizes[..]) {
        ("sphere" | "ball", [d]) => {
            Some(solid(format!("{d} mm steel ball"), json!({"shape": "sphere", "diameter_mm": d})))
        }
        ("rcc", [d]) => {
            Some(solid(format!("{d} mm steel RCC"), json!({"shape": "cylinder", "diameter_mm": d, "length_mm": d})))
        }
        ("cylinder", [d, length]) => Some(solid(
            format!("{d} × {length} mm steel cylinder"),
            json!({"shape": "cylinder", "diameter_mm": d, "length_mm": length}),
        )),
        _ => None,
    }
}

fn paper() -> Preset {
    let keys = json!({"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 42.1, "mass_g": 3.0});
    Preset::new("RCC", keys, vec![("", "Shahkarami & Vaziri 2006, ballistic impact simulations".to_owned())])
}

/// A cylinder of this mass [g].
fn as_long_as_wide(what: &str, mass: f64) -> Preset {
    let diameter = round((4.0 * mass * 1e-3 / (std::f64::consts::PI * STEEL)).cbrt() * 1e3);
    let keys = json!({"shape": "cylinder", "diameter_mm": diameter, "length_mm": diameter, "mass_g": mass});
    let of_mass = "assumed: a solid of steel, 7850 kg/m3, as long as wide".to_owned();
    let of_name = ("", "grains of the name".to_owned());
    Preset::new(what, keys, vec![of_name, ("diameter_mm", of_mass.clone()), ("length_mm", of_mass)])
}

/// A solid body of steel: its mass follows from its size.
fn solid(what: impl Into<String>, mut keys: Value) -> Preset {
    keys["density_kg_m3"] = json!(STEEL);
    Preset::new(what, keys, vec![("", "size of the name".to_owned()), ("density_kg_m3", "handbooks: steel".to_owned())])
}

/// Diameter [mm] and mass [g] are the standard's; the length is that of a solid of steel.
fn fragment(what: &str, diameter: f64, mass: f64) -> Preset {
    let (flat, angle) = NOSE;
    let mass_of = |length: f64| {
        let [diameter, length] = [diameter * 1e-3, length * 1e-3];
        let (nose_flat, nose_angle, roll) = (flat * diameter, angle.to_radians(), 0.0);
        Shape::Fragment { diameter, length, nose_flat, nose_angle, roll }.volume() * STEEL * 1e3
    };
    // Mass grows with length in proportion, but for the nose.
    let per_mm = mass_of(2.0 * diameter) - mass_of(2.0 * diameter - 1.0);
    let length = round(2.0 * diameter - (mass_of(2.0 * diameter) - mass) / per_mm);
    let keys = json!({
        "shape": "fragment", "diameter_mm": diameter, "length_mm": length,
        "nose_flat_mm": round(flat * diameter), "nose_angle_deg": angle, "mass_g": mass,
    });
    let nose = "assumed: about as chisel-nosed fragment simulators have it";
    let sources = vec![
        ("", "MIL-DTL-46593B, nominal mass and diameter, read second-hand".to_owned()),
        ("length_mm", "assumed: a solid of steel, 7850 kg/m3, of this mass".to_owned()),
        ("nose_flat_mm", nose.to_owned()),
        ("nose_angle_deg", nose.to_owned()),
    ];
    Preset::new(what, keys, sources)
}

/// To hundredths.
fn round(size: f64) -> f64 {
    (size * 100.0).round() / 100.0
}
