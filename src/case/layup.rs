//! The layup of a pack: groups of consecutive plies that are alike, from the struck side.

use std::f64::consts::FRAC_PI_2;

use super::error::CaseError;
use super::pack_keys::MAX_PLIES;
use super::places::{COMMON, LAYUP};
use super::record::Provenance;
use super::scope::ObjectReader;
use super::value::short_number_text;
use super::{Edges, Fabric, Layer, build};

/// What holds for a group that says nothing else.
pub(super) struct Common<'a> {
    pub fabric: &'a Fabric,
    /// Width and height asked for [m].
    pub size: [f64; 2],
    /// Crossovers along the side of an element.
    pub side: f64,
    pub edges: Edges,
    /// [m/s]
    pub initial_velocity: [f64; 3],
}

/// The groups of a pack; none where it has no layup.
pub(super) fn read(pack: &ObjectReader<'_>, common: &Common<'_>, record: &Provenance) -> Result<Vec<Layer>, CaseError> {
    pack.items("layup")?.iter().map(|group| layer(group, common, record)).collect()
}

fn layer(group: &ObjectReader<'_>, common: &Common<'_>, record: &Provenance) -> Result<Layer, CaseError> {
    let plies = group.whole("plies")?;
    let fabric = match group.object_if_given("fabric")? {
        Some(own) => build::fabric(&own, record)?,
        None => {
            group.derive_value("fabric", common.fabric.name.clone(), false)?;
            common.fabric.clone()
        }
    };
    let orientation = group.number("orientation_deg")?;
    // What the pack says, where the group says nothing.
    let of_pack = |name: &str| {
        let above = format!("/pack/{name}");
        group.derive_value(name, record.values_below(&above), record.any_assumed_below(&[&above]))
    };
    let edges = match group.given("edges") {
        Some(_) => build::edges(group)?,
        None => of_pack("edges").map(|()| common.edges)?,
    };
    let initial_velocity = match group.given("initial_velocity_m_s") {
        Some(_) => group.vector("initial_velocity_m_s")?,
        None => of_pack("initial_velocity_m_s").map(|()| common.initial_velocity)?,
    };
    let [width, height] = common.size;
    let size = if lies_across(orientation) { [height, width] } else { [width, height] };
    let ([columns, rows], [element_length_x, element_length_y]) = build::mesh(group, &fabric, size, common.side)?;
    Ok(Layer {
        plies,
        fabric,
        orientation,
        edges,
        initial_velocity,
        columns,
        rows,
        element_length_x,
        element_length_y,
        grading: None,
    })
}

/// Whether the warp lies along the pack's Y axis: then the ply's own width is the pack's height.
fn lies_across(orientation: f64) -> bool {
    let quarters = orientation / FRAC_PI_2;
    let whole = quarters.round();
    // Degrees become radians with a rounding error.
    (quarters - whole).abs() < 1e-9 && whole.rem_euclid(2.0) == 1.0
}

/// Plies of a pack: the sum over its layup, where it has one.
pub(super) fn plies(pack: &ObjectReader<'_>, layup: &[Layer]) -> Result<u32, CaseError> {
    if layup.is_empty() {
        return pack.whole("plies");
    }
    let sum: u32 = layup.iter().map(|layer| layer.plies).sum();
    if sum > MAX_PLIES {
        let expected = format!("at most {MAX_PLIES} plies over all groups");
        return Err(CaseError::at(LAYUP, expected, format!("{sum} plies")));
    }
    if pack.given("plies").is_none() {
        pack.derive_text("plies", sum.to_string(), "the sum over the layup");
        return Ok(sum);
    }
    match pack.whole("plies")? {
        given if given == sum => Ok(sum),
        given => {
            let expected = format!("{sum}, the sum of the plies of {LAYUP}");
            let error = CaseError::at(pack.at("plies"), expected, given.to_string());
            Err(error.help("leave \"plies\" out: the layup says how many there are"))
        }
    }
}

/// Largest thickness of any ply [m].
pub(super) fn thickest(layup: &[Layer], common: &Fabric) -> f64 {
    layup.iter().map(|layer| layer.fabric.thickness).reduce(f64::max).unwrap_or(common.thickness)
}

/// Records the spacing that follows from the thicknesses of neighbouring plies.
pub(super) fn derive_spacing(pack: &ObjectReader<'_>, layup: &[Layer], record: &Provenance) -> Result<(), CaseError> {
    let own = |place: usize| format!("{LAYUP}/{place}{COMMON}/thickness_mm");
    let common = format!("{COMMON}/thickness_mm");
    let of_group = |place| if record.has(&own(place)) { own(place) } else { common.clone() };
    let assumed = (0..layup.len()).any(|place| record.is_assumed(&of_group(place)));
    let within = layup.iter().filter(|layer| layer.plies > 1 || layup.len() == 1).map(|layer| layer.fabric.thickness);
    let between = layup.windows(2).map(|pair| 0.5 * (pair[0].fabric.thickness + pair[1].fabric.thickness));
    let spacings = within.chain(between);
    let (least, most) = spacings.fold((f64::INFINITY, 0.0_f64), |(least, most), s| (least.min(s), most.max(s)));
    let how = "the mean of the thickness_mm of the two plies";
    if least == most {
        pack.derive_as("spacing_mm", least, how, assumed)?;
    } else {
        let [least, most] = [least, most].map(|spacing| short_number_text(spacing * 1e3));
        pack.derive_value_as("spacing_mm", format!("{least} to {most}"), how, assumed)?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "layup_tests.rs"]
mod tests;
