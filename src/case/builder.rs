//! A case written in Rust: the same document as a file's, through the same checks.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::error::json_number;
use super::fabric_file::FabricSource;
use super::keys::Word as _;
use super::set::{self, Set};
use super::{BuiltInFabric, Case, CaseError, Edge, read};

/// The source of a value of which nothing else is said.
const BY: &str = "set by a program";

/// A case in the making. Methods are named as the keys of a case file, units included.
///
/// A key that has no method here is given by [`CaseBuilder::set`]. Nothing is checked before [`CaseBuilder::build`]. A value of which
/// nothing else is said has the source `set by a program`.
///
/// ```
/// use ripstop::{BuiltInFabric, Case, Edge};
///
/// let case = Case::builder("a small ply")
///     .fabric(BuiltInFabric::S720)
///     .size_mm(40.0, 40.0)
///     .edges(Edge::Clamped)
///     .sphere_mm(6.0)
///     .density_kg_m3(7850.0)
///     .velocity_m_s(120.0)
///     .set("/projectile/obliquity_deg", 30)
///     .build()?;
/// assert_eq!(case.pack.plies, 1);
/// # Ok::<(), ripstop::CaseError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use]
pub struct CaseBuilder {
    name: String,
    folder: Option<PathBuf>,
    keys: Vec<(String, Value)>,
}

impl Case {
    /// A case to be written in Rust, with this title. Fabric and size have to be given, and all of a projectile where there is one.
    pub fn builder(title: impl Into<String>) -> CaseBuilder {
        let keys = vec![("/title".to_owned(), Value::from(title.into()))];
        CaseBuilder { name: "case".to_owned(), folder: None, keys }
    }

    /// The case with another value for the key that a JSON pointer names, checked like a new one; name and title stay.
    ///
    /// ```
    /// # let case = ripstop::Case::builder("a ply").fabric(ripstop::BuiltInFabric::S720).size_mm(40.0, 40.0)
    /// #     .sphere_mm(6.0).mass_g(1.0).velocity_m_s(120.0).build()?;
    /// let faster = case.with("/projectile/velocity_m_s", 150)?;
    /// # assert_eq!(faster.projectile.map(|projectile| projectile.velocity), Some(150.0));
    /// # Ok::<(), ripstop::CaseError>(())
    /// ```
    ///
    /// # Errors
    /// The refusal of the case so changed.
    pub fn with(&self, pointer: &str, value: impl Into<Value>) -> Result<Self, CaseError> {
        let document = self.as_run.clone();
        let file = Some(&self.path).filter(|path| path.is_file());
        let source = file.map_or(FabricSource::BuiltIn, |path| FabricSource::Folder(read::folder_of(path)));
        let changed = Set::new(pointer, value.into())
            .and_then(|set| read::assemble_document(&self.name, document, &[set], BY, &source));
        let changed = changed.map_err(|error| without_flag(error).in_file(&self.name))?;
        Ok(Self { name: self.name.clone(), path: self.path.clone(), ..changed })
    }
}

impl CaseBuilder {
    /// The name of the case in errors, and of the folder of its results; `case` where none is given.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// A fabric that comes with ripstop.
    pub fn fabric(self, fabric: BuiltInFabric) -> Self {
        self.set("/fabric", json!({"file": fabric.file()}))
    }

    /// A fabric from a file in `folder`, where all other files of fabrics lie too.
    pub fn fabric_file(mut self, folder: impl Into<PathBuf>, file: &str) -> Self {
        self.folder = Some(folder.into());
        self.set("/fabric", json!({"file": file}))
    }

    /// Size of the pack along warp and along weft [mm].
    pub fn size_mm(self, width: f64, height: f64) -> Self {
        self.number("/pack/width_mm", width).number("/pack/height_mm", height)
    }

    /// Plies of the pack; one where nothing is said.
    pub fn plies(self, plies: u32) -> Self {
        self.set("/pack/plies", plies)
    }

    /// Boundary condition of all four edges.
    pub fn edges(self, edges: Edge) -> Self {
        self.set("/pack/edges", edges.word())
    }

    /// A sphere strikes the pack.
    pub fn sphere_mm(self, diameter: f64) -> Self {
        self.set("/projectile/shape", "sphere").number("/projectile/diameter_mm", diameter)
    }

    /// A cylinder strikes the pack with its flat face.
    pub fn cylinder_mm(self, diameter: f64, length: f64) -> Self {
        let cylinder = self.set("/projectile/shape", "cylinder").number("/projectile/diameter_mm", diameter);
        cylinder.number("/projectile/length_mm", length)
    }

    /// Mass of the projectile [g].
    pub fn mass_g(self, mass: f64) -> Self {
        self.number("/projectile/mass_g", mass)
    }

    /// Density of the projectile, from which its mass follows [kg/m³].
    pub fn density_kg_m3(self, density: f64) -> Self {
        self.number("/projectile/density_kg_m3", density)
    }

    /// Impact velocity [m/s].
    pub fn velocity_m_s(self, velocity: f64) -> Self {
        self.number("/projectile/velocity_m_s", velocity)
    }

    /// When the run ends, if its outcome is not known before [µs].
    pub fn end_time_us(self, time: f64) -> Self {
        self.number("/solver/end_time_us", time)
    }

    /// Interval of the history [µs].
    pub fn history_interval_us(self, interval: f64) -> Self {
        self.number("/output/history_interval_us", interval)
    }

    /// Where the value of a key, or of all keys below it, comes from; a text that begins with `assumed` marks it as assumed.
    pub fn source(mut self, pointer: &str, text: impl Into<String>) -> Self {
        let text = Value::from(text.into());
        match self.keys.iter_mut().find(|(key, _)| key == "/sources") {
            Some((_, sources)) => sources[pointer] = text,
            None => self.keys.push(("/sources".to_owned(), json!({pointer: text}))),
        }
        self
    }

    /// Any key of a case file by its JSON pointer, in the unit that the key ends in.
    pub fn set(mut self, pointer: &str, value: impl Into<Value>) -> Self {
        self.keys.push((pointer.to_owned(), value.into()));
        self
    }

    fn number(self, pointer: &str, number: f64) -> Self {
        // JSON has no word for what is not finite: as text it is refused by name.
        let value = if number.is_finite() { json_number(number) } else { Value::from(number.to_string()) };
        self.set(pointer, value)
    }

    /// The case, completed and checked like that of a file.
    ///
    /// # Errors
    /// Everything that is wrong key by key, else the first thing that does not go together.
    pub fn build(self) -> Result<Case, CaseError> {
        let source = self.folder.as_deref().map_or(FabricSource::BuiltIn, FabricSource::Folder);
        let mut document = json!({});
        let put = |(pointer, value): (String, Value)| Set::new(&pointer, value)?.put(&mut document);
        let done = self.keys.into_iter().try_for_each(put);
        done.map_err(|error| without_flag(error).in_file(&self.name))?;
        if let Some(sources) = set::sources(&mut document) {
            sources.entry("").or_insert_with(|| json!(BY));
        }
        let case = read::assemble_document(&self.name, document, &[], BY, &source)?;
        Ok(Case { name: self.name, ..case })
    }
}

/// An error without the name of the option that makes such changes on the command line.
fn without_flag(mut error: CaseError) -> CaseError {
    if let Some(pointer) = error.of_set() {
        error.location = pointer.to_owned();
    }
    error
}
