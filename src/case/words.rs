//! The words of the case file and what they stand for.

use serde_json::{Map, Value};

use super::{
    Accuracy, Along, ContactSampling, Distribution, Edge, HitPlace, Law, LinesFrom, MembraneForce, Motion, Numerics,
    Rotation, RunUntil, ShearModulus, StretchSampling, Symmetry,
};

/// A choice that the case file names by a word.
pub(crate) trait Word: Copy + Sized + 'static {
    const WORDS: &'static [&'static str];

    fn from_word(word: &str) -> Option<Self>;

    fn word(self) -> &'static str;
}

macro_rules! words {
    ($($choice:ident { $($word:literal => $variant:ident),+ })+) => {$(
        impl Word for $choice {
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn from_word(word: &str) -> Option<Self> {
                match word {
                    $($word => Some(Self::$variant),)+
                    _ => None,
                }
            }

            fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }
    )+};
}

words! {
    Law { "published" => Published, "variational" => Variational }
    MembraneForce { "tension" => Tension }
    ShearModulus { "tangent" => Tangent }
    Edge { "clamped" => Clamped, "free" => Free, "roller" => Roller }
    Along { "warp" => Warp, "weft" => Weft }
    Motion { "free" => Free, "prescribed" => Prescribed }
    Rotation { "free" => Free, "locked" => Locked }
    LinesFrom { "hit" => Hit, "edges" => Edges }
    Symmetry { "auto" => Auto, "none" => None }
    ContactSampling { "nodes" => Nodes, "edges" => Edges }
    StretchSampling { "centre" => Centre, "mean" => Mean }
    Numerics { "default" => Default, "paper" => Paper }
    Accuracy { "default" => Default, "converged" => Converged }
    Distribution { "normal" => Normal, "uniform" => Uniform }
    HitPlace { "aimed" => Aimed, "unit_cell" => UnitCell }
    RunUntil { "outcome" => Outcome, "separation" => Separation, "end_time" => EndTime }
    ShapeWord {
        "cylinder" => Cylinder, "sphere" => Sphere, "cone" => Cone, "ogive" => Ogive, "fragment" => Fragment, "bar" => Bar
    }
}

/// Other words that people have for a shape, and the word of the case file.
const SHAPE_ALIASES: &[(&str, &str)] = &[("ball", "sphere"), ("fsp", "fragment"), ("rcc", "cylinder")];

/// Other words for a word of the case file.
pub(super) fn aliases(word: &str) -> impl Iterator<Item = &'static str> {
    SHAPE_ALIASES.iter().filter(move |(_, meant)| *meant == word).map(|(alias, _)| *alias)
}

/// Puts the words of the case file in place of others for them.
pub(super) fn without_aliases(document: &mut Map<String, Value>) {
    let Some(shape) = document.get_mut("projectile").and_then(|projectile| projectile.get_mut("shape")) else { return };
    if let Some((_, meant)) = SHAPE_ALIASES.iter().find(|(alias, _)| shape.as_str() == Some(*alias)) {
        *shape = Value::from(*meant);
    }
}

/// The shape of a projectile before its lengths are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ShapeWord {
    Cylinder,
    Sphere,
    Cone,
    Ogive,
    Fragment,
    Bar,
}
