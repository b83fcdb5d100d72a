//! The fabrics that are built into the program.

/// A fabric that comes with ripstop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BuiltInFabric {
    /// Kevlar 129, 1420 denier, 20 per inch, 255 g/m²: the paper's first.
    S720,
    /// Kevlar 129, 1500 denier, 17 per inch, 231 g/m²: the paper's second.
    S728,
    /// Twaron CT 612, 550 dtex, 11 per cm, 121 g/m²; mostly assumed.
    TwaronCt612,
    /// Twaron CT 709, 930 dtex, 10.5 per cm, 200 g/m²; moduli and crimp are assumed.
    TwaronCt709,
}

impl BuiltInFabric {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::S720, Self::S728, Self::TwaronCt612, Self::TwaronCt709];

    /// Its name in a case.
    pub fn file(self) -> &'static str {
        match self {
            Self::S720 => "fabrics/s-720.json",
            Self::S728 => "fabrics/s-728.json",
            Self::TwaronCt612 => "fabrics/twaron-ct612.json",
            Self::TwaronCt709 => "fabrics/twaron-ct709.json",
        }
    }

    /// Its keys and values, with their sources, as JSON.
    pub fn text(self) -> &'static str {
        match self {
            Self::S720 => include_str!("../../cases/fabrics/s-720.json"),
            Self::S728 => include_str!("../../cases/fabrics/s-728.json"),
            Self::TwaronCt612 => include_str!("../../cases/fabrics/twaron-ct612.json"),
            Self::TwaronCt709 => include_str!("../../cases/fabrics/twaron-ct709.json"),
        }
    }
}

/// The text of a fabric that is built into the program, by its name in a case: `fabrics/s-720.json`.
pub fn builtin_fabric(file: &str) -> Option<&'static str> {
    BuiltInFabric::ALL.into_iter().find(|fabric| fabric.file() == file).map(BuiltInFabric::text)
}
