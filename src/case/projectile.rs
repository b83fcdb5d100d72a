//! The projectile of a case.

use super::error::CaseError;
use super::scope::ObjectReader;
use super::value::{millimetres, short_number_text};
use super::words::ShapeWord;
use super::{Projectile, Rotation, Shape};

/// Rounding of a point that says nothing [m]. Under a sharp one a node stands on the tip or slips off it, which is a matter of the last bit:
/// the limit of a cone is 93 or 76 m/s. From 0.15 to 0.5 mm it is 95 to 99 m/s (`benches/NOTES.md`).
const TIP_RADIUS: f64 = 0.5e-3;
/// The most of it, over the diameter [-].
const TIP_PART: f64 = 0.1;

/// Reads the projectile in the order of the table.
pub(super) fn read(scope: &ObjectReader<'_>) -> Result<Projectile, CaseError> {
    let word: ShapeWord = scope.word("shape")?;
    let shape = shape(scope, word)?;
    let long = !matches!(word, ShapeWord::Sphere | ShapeWord::Bar);
    let turning = word != ShapeWord::Bar;
    let edge_radius = if long { edge_radius(scope, &shape)? } else { 0.0 };
    let density = if turning { scope.number_if_given("density_kg_m3")? } else { None };
    let mass = match (scope.number_if_given("mass_g")?, density) {
        (Some(mass), _) => mass,
        (None, Some(density)) => {
            let assumed = scope.is_assumed("density_kg_m3");
            scope.derive_as(
                "mass_g",
                density * shape.volume(),
                "density_kg_m3 times the volume of the body",
                assumed,
            )?
        }
        (None, None) => return Err(CaseError::at(scope.at("mass_g"), "a mass or a density", "neither")),
    };
    let inertia = if turning { inertia(scope)? } else { None };
    Ok(Projectile {
        shape,
        edge_radius,
        mass,
        density,
        inertia,
        velocity: scope.number("velocity_m_s")?,
        offset: scope.vector("offset_mm")?,
        standoff: scope.number("standoff_mm")?,
        obliquity: scope.number("obliquity_deg")?,
        azimuth: scope.number("azimuth_deg")?,
        yaw: if turning { scope.number("yaw_deg")? } else { 0.0 },
        angular_velocity: if turning { scope.vector("angular_velocity_rad_s")? } else { [0.0; 3] },
        friction: scope.number("friction")?,
        motion: scope.word("motion")?,
        rotation: if turning { scope.word("rotation")? } else { bar_rotation(scope)? },
    })
}

fn shape(scope: &ObjectReader<'_>, word: ShapeWord) -> Result<Shape, CaseError> {
    let diameter = scope.number("diameter_mm")?;
    let length = || scope.number("length_mm");
    Ok(match word {
        ShapeWord::Cylinder => Shape::Cylinder { diameter, length: length()? },
        ShapeWord::Sphere => Shape::Sphere { diameter },
        ShapeWord::Bar => Shape::Bar { diameter, along: scope.word("along")? },
        ShapeWord::Cone => {
            let length = length()?;
            let nose_length = match scope.number_if_given("nose_length_mm")? {
                Some(given) => at_most(scope, "nose_length_mm", given, "length_mm", length)?,
                None => scope.derive_as("nose_length_mm", length, "length_mm: a plain cone", false)?,
            };
            Shape::Cone { diameter, length, nose_length }
        }
        ShapeWord::Ogive => ogive(scope, diameter, length()?)?,
        ShapeWord::Fragment => fragment(scope, diameter, length()?)?,
    })
}

/// Refuses a length above another one [m].
fn at_most(scope: &ObjectReader<'_>, name: &str, given: f64, limit_name: &str, limit: f64) -> Result<f64, CaseError> {
    if given > limit {
        let expected = format!("at most {limit_name}, which is {}", millimetres(limit));
        return Err(CaseError::at(scope.at(name), expected, millimetres(given)));
    }
    Ok(given)
}

/// A tangent arc is at least as long as the radius that it closes.
fn ogive(scope: &ObjectReader<'_>, diameter: f64, length: f64) -> Result<Shape, CaseError> {
    let too_short = |name: &str, found: f64| {
        let expected = format!("at least half of diameter_mm, which is {}", millimetres(0.5 * diameter));
        let error = CaseError::at(scope.at(name), expected, millimetres(found));
        Err(error.help("a tangent ogive of that length is a hemisphere, a shorter one there is not"))
    };
    if length < 0.5 * diameter {
        return too_short("length_mm", length);
    }
    let nose_length = match scope.number_if_given("nose_length_mm")? {
        Some(given) if given < 0.5 * diameter => return too_short("nose_length_mm", given),
        Some(given) => at_most(scope, "nose_length_mm", given, "length_mm", length)?,
        None => {
            let how = "assumed: 1.5 × diameter_mm, at most length_mm";
            scope.derive_as("nose_length_mm", length.min(1.5 * diameter), how, true)?
        }
    };
    Ok(Shape::Ogive { diameter, length, nose_length })
}

/// The slanted flats must meet the wall before the tail.
fn fragment(scope: &ObjectReader<'_>, diameter: f64, length: f64) -> Result<Shape, CaseError> {
    let nose_flat = scope.number_or("nose_flat_mm", 0.46 * diameter, true)?;
    let nose_flat = at_most(scope, "nose_flat_mm", nose_flat, "diameter_mm", diameter)?;
    let nose_angle = scope.number("nose_angle_deg")?;
    let nose = 0.5 * (diameter - nose_flat) * nose_angle.tan();
    if nose > length {
        let expected = format!("flats that end within length_mm, which is {}", millimetres(length));
        let found = format!("a nose of {}", millimetres(nose));
        return Err(CaseError::at(scope.at("nose_angle_deg"), expected, found));
    }
    Ok(Shape::Fragment { diameter, length, nose_flat, nose_angle, roll: scope.number("roll_deg")? })
}

/// The rounding must leave room for itself: a ball of its radius fits into the body, and each face is left in part.
fn edge_radius(scope: &ObjectReader<'_>, shape: &Shape) -> Result<f64, CaseError> {
    let largest = match *shape {
        Shape::Cylinder { diameter, length } => (0.5 * diameter).min(0.5 * length),
        Shape::Cone { diameter, length, nose_length } => {
            let sine = 0.5 * diameter / nose_length.hypot(0.5 * diameter);
            (0.5 * diameter).min(length * sine / (1.0 + sine))
        }
        Shape::Ogive { diameter, length, nose_length } => {
            let (r, shank) = (0.5 * diameter, length - nose_length);
            // Of the ball that touches arc and tail, where it is no wider than the wall.
            let arc = (r * r + nose_length * nose_length) / (2.0 * r);
            if shank < r { (nose_length * nose_length - shank * shank) / (2.0 * (arc - shank)) } else { r }
        }
        Shape::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
            let turn = (0.5 * nose_angle).tan();
            let nose = 0.5 * (diameter - nose_flat) * nose_angle.tan();
            let room = 0.5 * (length - nose) * (1.0 + turn);
            (0.5 * diameter).min(0.5 * length).min(0.5 * nose_flat / turn).min(room)
        }
        Shape::Sphere { .. } | Shape::Bar { .. } => 0.0,
    };
    let radius = match scope.number_if_given("edge_radius_mm")? {
        Some(given) => given,
        None if shape.is_pointed() => {
            let how = "assumed: 0.5 mm, at most a tenth of diameter_mm and what the shape has room for";
            scope.derive_as("edge_radius_mm", TIP_RADIUS.min(TIP_PART * shape.diameter()).min(largest), how, true)?
        }
        None => scope.derive_as("edge_radius_mm", 0.0, "sharp edges", false)?,
    };
    if radius > largest {
        let expected = format!("at most {}, the largest that this shape has room for", millimetres(largest));
        return Err(CaseError::at(scope.at("edge_radius_mm"), expected, millimetres(radius)));
    }
    Ok(radius)
}

fn inertia(scope: &ObjectReader<'_>) -> Result<Option<[f64; 2]>, CaseError> {
    let axial = scope.number_if_given("axial_inertia_g_mm2")?;
    let transverse = scope.number_if_given("transverse_inertia_g_mm2")?;
    if axial.is_none() {
        for name in ["axial_inertia_g_mm2", "transverse_inertia_g_mm2"] {
            scope.derive_text(name, "of the body".to_owned(), "a uniform solid of this shape and mass");
        }
    }
    if let (Some(axial), Some(transverse)) = (axial, transverse)
        && axial > 2.0 * transverse
    {
        let g_mm2 = |inertia: f64| format!("{} g·mm²", short_number_text(inertia * 1e9));
        let expected = format!("at most twice transverse_inertia_g_mm2, which is {}", g_mm2(2.0 * transverse));
        let error = CaseError::at(scope.at("axial_inertia_g_mm2"), expected, g_mm2(axial));
        return Err(error.help("no body has a moment of inertia above the sum of the other two"));
    }
    // The table refuses one without the other.
    Ok(axial.zip(transverse).map(Into::into))
}

fn bar_rotation(scope: &ObjectReader<'_>) -> Result<Rotation, CaseError> {
    if scope.given("rotation").is_none() {
        scope.derive_text("rotation", "locked".to_owned(), "a bar never turns");
        return Ok(Rotation::Locked);
    }
    match scope.word("rotation")? {
        Rotation::Locked => Ok(Rotation::Locked),
        Rotation::Free => {
            let error = CaseError::at(scope.at("rotation"), "\"locked\" for a bar", "\"free\"");
            Err(error.help("a bar never turns; leave \"rotation\" out"))
        }
    }
}
