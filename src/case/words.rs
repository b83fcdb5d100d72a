//! The words of the case file and what they stand for.

use super::{
    Accuracy, Along, ContactSampling, Edge, Law, MembraneForce, Motion, Numerics, Rotation, RunUntil, ShearModulus,
    Symmetry, UnitCell,
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
    Law { "published" => Published, "variational" => Variational, "kawabata" => Kawabata }
    MembraneForce { "tension" => Tension, "projected" => Projected }
    ShearModulus { "tangent" => Tangent, "secant" => Secant }
    Edge { "clamped" => Clamped, "free" => Free, "roller" => Roller }
    Along { "warp" => Warp, "weft" => Weft }
    Motion { "free" => Free, "prescribed" => Prescribed }
    Rotation { "free" => Free, "locked" => Locked }
    Symmetry { "auto" => Auto, "none" => None }
    ContactSampling { "nodes" => Nodes, "rim" => Rim }
    Numerics { "default" => Default, "paper" => Paper }
    Accuracy { "default" => Default, "converged" => Converged }
    UnitCell { "joint" => Joint, "bracketed" => Bracketed }
    RunUntil { "outcome" => Outcome, "separation" => Separation, "end_time" => EndTime }
    ShapeWord {
        "cylinder" => Cylinder, "sphere" => Sphere, "cone" => Cone, "ogive" => Ogive, "fragment" => Fragment, "bar" => Bar
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
