//! Units of the case file.

use std::f64::consts::PI;

use super::fields::Unit;

pub(super) const NONE: Unit = Unit::new("", 1.0, 1.0);
pub(super) const RAD: Unit = Unit::new("rad", 1.0, 1.0);
pub(super) const DEG: Unit = Unit::new("deg", PI, 180.0);
pub(super) const MM: Unit = Unit::new("mm", 1.0, 1e3);
pub(super) const MM_N13: Unit = Unit::new("mm·N^(1/3)", 1.0, 1e3);
pub(super) const US: Unit = Unit::new("µs", 1.0, 1e6);
pub(super) const M_S: Unit = Unit::new("m/s", 1.0, 1.0);
pub(super) const RAD_S: Unit = Unit::new("rad/s", 1.0, 1.0);
pub(super) const GRAM: Unit = Unit::new("g", 1.0, 1e3);
pub(super) const G_MM2: Unit = Unit::new("g·mm²", 1.0, 1e9);
pub(super) const KG_M3: Unit = Unit::new("kg/m³", 1.0, 1.0);
pub(super) const G_M2: Unit = Unit::new("g/m²", 1.0, 1e3);
/// Grams per 9000 m.
pub(super) const DENIER: Unit = Unit::new("denier", 1.0, 9e6);
/// Grams per 1000 m.
pub(super) const TEX: Unit = Unit::new("tex", 1.0, 1e6);
pub(super) const DTEX: Unit = Unit::new("dtex", 1.0, 1e7);
pub(super) const PER_INCH: Unit = Unit::new("1/inch", 1e4, 254.0);
pub(super) const PER_CM: Unit = Unit::new("1/cm", 100.0, 1.0);
pub(super) const GPA: Unit = Unit::new("GPa", 1e9, 1.0);
pub(super) const MPA: Unit = Unit::new("MPa", 1e6, 1.0);
pub(super) const N_M: Unit = Unit::new("N/m", 1.0, 1.0);
