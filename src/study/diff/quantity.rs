//! Names of columns, and their units.
//!
//! A heading is a column of `history.csv`, or the same quantity in another unit: `time_ms`, `velocity_ft_s`, `Velocity (m/s)`.

use crate::output::history;

/// The column that holds time.
pub(super) const TIME: &str = "time_us";

/// A unit as names end with it, as people write it, and how much of the history's unit it is.
struct DisplayUnit {
    suffix: &'static str,
    text: &'static str,
    factor: f64,
}

const fn unit(suffix: &'static str, text: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit { suffix, text, factor }
}

/// The units of each dimension; the first is that of the history.
const DIMENSIONS: [&[DisplayUnit]; 5] = [
    &[unit("us", "µs", 1.0), unit("ns", "ns", 1e-3), unit("ms", "ms", 1e3), unit("s", "s", 1e6)],
    &[
        unit("m_s", "m/s", 1.0),
        unit("km_s", "km/s", 1e3),
        unit("mm_us", "mm/µs", 1e3),
        unit("mm_s", "mm/s", 1e-3),
        unit("ft_s", "ft/s", 0.3048),
    ],
    &[
        unit("mm", "mm", 1.0),
        unit("um", "µm", 1e-3),
        unit("cm", "cm", 10.0),
        unit("m", "m", 1e3),
        unit("in", "in", 25.4),
    ],
    &[unit("n", "N", 1.0), unit("kn", "kN", 1e3), unit("lbf", "lbf", 4.448_221_615_260_5)],
    &[unit("j", "J", 1.0), unit("kj", "kJ", 1e3)],
];

/// Short names of what cameras measure.
const SHORT: [(&str, &str); 6] = [
    ("t", TIME),
    ("velocity", "projectile_velocity_m_s"),
    ("displacement", "projectile_displacement_mm"),
    ("deflection", "max_deflection_mm"),
    ("force", "contact_force_n"),
    ("energy", "projectile_energy_j"),
];

/// What a heading stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quantity {
    /// Column of `history.csv`.
    pub(super) name: &'static str,
    /// A number under the heading times this is in the unit of that column.
    pub(super) factor: f64,
}

/// The quantity of a heading; `None` where `history.csv` has none like it.
pub(super) fn of(heading: &str) -> Option<Quantity> {
    let key = key(heading);
    let columns = || history::COLUMNS.iter().map(|column| column.name);
    let short = SHORT.iter().filter_map(|(short, name)| Some((*short, *name, split(name)?.1)));
    let long = columns().filter_map(|name| split(name).map(|(base, units)| (base, name, units)));
    let with_unit = long.chain(short).find_map(|(base, name, units)| {
        let rest = key.strip_prefix(base)?.strip_prefix('_')?;
        let unit = units.iter().find(|unit| unit.suffix == rest)?;
        Some(Quantity { name, factor: unit.factor })
    });
    with_unit.or_else(|| columns().find(|name| *name == key).map(|name| Quantity { name, factor: 1.0 }))
}

/// Every name that there is, short ones in the history's unit.
pub(super) fn names() -> Vec<String> {
    let short = SHORT.iter().filter_map(|(short, name)| Some(format!("{short}_{}", split(name)?.1.first()?.suffix)));
    history::COLUMNS.iter().map(|column| column.name.to_owned()).chain(short).collect()
}

/// Small letters, and `_` for everything that is neither letter nor digit.
fn key(heading: &str) -> String {
    let plain = heading.trim().replace(['µ', 'μ'], "u").to_lowercase();
    plain.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
}

/// A name of the history without its unit, and the units that it may have instead.
fn split(name: &str) -> Option<(&str, &'static [DisplayUnit])> {
    DIMENSIONS.iter().find_map(|units| {
        let base = name.strip_suffix(units.first()?.suffix)?.strip_suffix('_')?;
        Some((base, *units))
    })
}

/// A column in words: `projectile velocity [m/s]`.
pub(super) fn words(name: &str) -> String {
    match split(name) {
        Some((base, units)) => format!("{} [{}]", base.replace('_', " "), units[0].text),
        None => name.replace('_', " "),
    }
}

/// Whether a quantity is a share already, of the initial energy, say: differences of it are not made relative once more.
pub(super) fn is_share(name: &str) -> bool {
    ["energy_error", "energy_gained", "momentum_error", "hourglass_fraction"].contains(&name)
}

/// The unit of a column, after a blank; nothing where it has none.
pub(super) fn unit_of(name: &str) -> String {
    split(name).map_or_else(String::new, |(_, units)| format!(" {}", units[0].text))
}

#[cfg(test)]
#[path = "quantity_tests.rs"]
mod tests;
