//! The projectile of a case.

use super::error::CaseError;
use super::scope::Scope;
use super::value::millimetres;
use super::words::ShapeWord;
use super::{Projectile, Rotation, Shape};

/// Reads the projectile in the order of the table.
pub(super) fn read(scope: &Scope<'_>) -> Result<Projectile, CaseError> {
    let word: ShapeWord = scope.word("shape")?;
    let shape = shape(scope, word)?;
    let long = matches!(word, ShapeWord::Cylinder | ShapeWord::Cone);
    let turning = word != ShapeWord::Bar;
    let edge_radius = if long { edge_radius(scope, &shape)? } else { 0.0 };
    let mass = scope.number("mass_g")?;
    let inertia = if turning { inertia(scope)? } else { None };
    Ok(Projectile {
        shape,
        edge_radius,
        mass,
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

fn shape(scope: &Scope<'_>, word: ShapeWord) -> Result<Shape, CaseError> {
    let diameter = scope.number("diameter_mm")?;
    Ok(match word {
        ShapeWord::Cylinder => Shape::Cylinder { diameter, length: scope.number("length_mm")? },
        ShapeWord::Sphere => Shape::Sphere { diameter },
        ShapeWord::Bar => Shape::Bar { diameter, along: scope.word("along")? },
        ShapeWord::Cone => {
            let length = scope.number("length_mm")?;
            let nose_length = match scope.number_if_given("nose_length_mm")? {
                Some(given) if given > length => {
                    let expected = format!("at most length_mm, which is {}", millimetres(length));
                    return Err(CaseError::at(scope.at("nose_length_mm"), expected, millimetres(given)));
                }
                Some(given) => given,
                None => scope.derive("nose_length_mm", length, false)?,
            };
            Shape::Cone { diameter, length, nose_length }
        }
    })
}

/// The rounding must leave room for itself: a ball of its radius fits into the body.
fn edge_radius(scope: &Scope<'_>, shape: &Shape) -> Result<f64, CaseError> {
    let radius = scope.number("edge_radius_mm")?;
    let largest = match *shape {
        Shape::Cylinder { diameter, length } => (0.5 * diameter).min(0.5 * length),
        Shape::Cone { diameter, length, nose_length } => {
            let sine = 0.5 * diameter / nose_length.hypot(0.5 * diameter);
            (0.5 * diameter).min(length * sine / (1.0 + sine))
        }
        Shape::Sphere { .. } | Shape::Bar { .. } => 0.0,
    };
    if radius > largest {
        let expected = format!("at most {}, the largest that this shape has room for", millimetres(largest));
        return Err(CaseError::at(scope.at("edge_radius_mm"), expected, millimetres(radius)));
    }
    Ok(radius)
}

fn inertia(scope: &Scope<'_>) -> Result<Option<[f64; 2]>, CaseError> {
    let axial = scope.number_if_given("axial_inertia_g_mm2")?;
    let transverse = scope.number_if_given("transverse_inertia_g_mm2")?;
    if axial.is_none() {
        for name in ["axial_inertia_g_mm2", "transverse_inertia_g_mm2"] {
            scope.derive_text(name, "of the body".to_owned(), "a uniform solid of this shape and mass");
        }
    }
    // The table refuses one without the other.
    Ok(axial.zip(transverse).map(Into::into))
}

fn bar_rotation(scope: &Scope<'_>) -> Result<Rotation, CaseError> {
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
