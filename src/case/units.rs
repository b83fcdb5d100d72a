//! Values of the case file: numbers with a unit, and words.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;

/// Unit of a key: SI = value · numerator / denominator, so that decimal factors round once.
pub(super) struct Unit {
    /// End of the names of its keys.
    end: &'static str,
    /// Its sign.
    pub(super) name: &'static str,
    numerator: f64,
    denominator: f64,
}

/// Units by the ends of the names of their keys; of several that fit the first is meant.
#[rustfmt::skip]
const UNITS: [Unit; 18] = [
    Unit { end: "_deg", name: "deg", numerator: PI, denominator: 180.0 },
    Unit { end: "_mm", name: "mm", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_mm_n13", name: "mm·N^(1/3)", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_us", name: "µs", numerator: 1.0, denominator: 1e6 },
    Unit { end: "_m_s", name: "m/s", numerator: 1.0, denominator: 1.0 },
    Unit { end: "_rad_s", name: "rad/s", numerator: 1.0, denominator: 1.0 },
    Unit { end: "_g", name: "g", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_g_mm2", name: "g·mm²", numerator: 1.0, denominator: 1e9 },
    Unit { end: "_kg_m3", name: "kg/m³", numerator: 1.0, denominator: 1.0 },
    Unit { end: "_g_m2", name: "g/m²", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_denier", name: "denier", numerator: 1.0, denominator: 9e6 },
    Unit { end: "_tex", name: "tex", numerator: 1.0, denominator: 1e6 },
    Unit { end: "_dtex", name: "dtex", numerator: 1.0, denominator: 1e7 },
    Unit { end: "_per_inch", name: "1/inch", numerator: 1e4, denominator: 254.0 },
    Unit { end: "_per_cm", name: "1/cm", numerator: 100.0, denominator: 1.0 },
    Unit { end: "_gpa", name: "GPa", numerator: 1e9, denominator: 1.0 },
    Unit { end: "_mpa", name: "MPa", numerator: 1e6, denominator: 1.0 },
    Unit { end: "_n_per_m", name: "N/m", numerator: 1.0, denominator: 1.0 },
];

/// A key's name without its unit, and the unit.
pub(super) fn split_unit(key: &str) -> (&str, Option<&'static Unit>) {
    let found = UNITS.iter().find_map(|unit| Some((key.strip_suffix(unit.end)?, Some(unit))));
    found.unwrap_or((key, None))
}

impl Unit {
    pub(super) fn to_si(&self, value: f64) -> f64 {
        value * self.numerator / self.denominator
    }

    pub(super) fn of_si(&self, si: f64) -> f64 {
        si * self.denominator / self.numerator
    }
}

/// A word, or the object that stands in its place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum WordOr<W, K> {
    Word(W),
    Keys(K),
}

/// A choice that the case file names by a word.
pub(crate) trait Word: Copy {
    /// The word of the case file.
    fn word(self) -> &'static str;
}

/// Choices with the word of the case file for each, and other words that are read as it.
macro_rules! choices {
    ($($(#[$doc:meta])* $vis:vis enum $name:ident {
        $($(#[$about:meta])* $variant:ident = $word:literal $(or $alias:literal)*,)+
    })+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Deserialize)]
        $vis enum $name {
            $($(#[$about])* #[serde(rename = $word)] $variant,)+
        }

        impl $crate::case::units::Word for $name {
            fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({"enum": [$($word),+], "aliases": {$($($alias: $word,)*)+}})
            }
        }
    )+};
}
pub(super) use choices;
