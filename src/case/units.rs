//! What values of the case file are made of: numbers with a unit, and words.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;

/// Number of the case file with its unit: SI = value · numerator / denominator, so that decimal factors round once.
macro_rules! units {
    ($($(#[$doc:meta])* $unit:ident $name:literal $numerator:literal $($factor:ident)? / $denominator:literal;)+) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
            #[serde(transparent)]
            #[schemars(extend("unit" = $name))]
            pub(super) struct $unit(pub(super) f64);

            impl $unit {
                /// The number in SI units.
                pub(super) fn si(self) -> f64 {
                    self.0 * ($numerator $(* $factor)?) / $denominator
                }
            }
        )+

        /// Number of SI units in the unit of this name.
        pub(super) fn of_si(unit: &str, si: f64) -> f64 {
            match unit {
                $($name => si * $denominator / ($numerator $(* $factor)?),)+
                _ => si,
            }
        }
    };
}

units! {
    Rad "rad" 1.0 / 1.0;
    Deg "deg" 1.0 PI / 180.0;
    Mm "mm" 1.0 / 1e3;
    MmN13 "mm·N^(1/3)" 1.0 / 1e3;
    Us "µs" 1.0 / 1e6;
    MS "m/s" 1.0 / 1.0;
    RadS "rad/s" 1.0 / 1.0;
    Gram "g" 1.0 / 1e3;
    GMm2 "g·mm²" 1.0 / 1e9;
    KgM3 "kg/m³" 1.0 / 1.0;
    GM2 "g/m²" 1.0 / 1e3;
    /// Grams per 9000 m.
    Denier "denier" 1.0 / 9e6;
    /// Grams per 1000 m.
    Tex "tex" 1.0 / 1e6;
    Dtex "dtex" 1.0 / 1e7;
    PerInch "1/inch" 1e4 / 254.0;
    PerCm "1/cm" 100.0 / 1.0;
    Gpa "GPa" 1e9 / 1.0;
    Mpa "MPa" 1e6 / 1.0;
    NM "N/m" 1.0 / 1.0;
}

/// Text that is not empty.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(super) struct Text(#[schemars(length(min = 1))] pub(super) String);

/// A word, or the object that stands in its place.
#[derive(Debug, Deserialize, JsonSchema)]
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
