//! Variability from shot to shot, and the case of one shot.
//!
//! A case with `variability` and no `shot` is the nominal one: nothing varies, and nothing costs time. With a `shot` its values are drawn
//! and replace the nominal ones, as if they were written there; only the strength of yarns, of which there is one for
//! each element, is left to the model. Draws are a function of seed and shot, see [`random`](crate::num::random).

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::error::short_number_text;
use super::keys::choices;
use super::provenance::Provenance;
use super::{Case, CaseError, Fabric, Projectile};
use crate::num::random::{DrawKey, normal};

/// Variability from shot to shot.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Variability {
    /// Number that all draws come from.
    ///
    /// Default: one sequence of shots.
    #[schemars(range(min = 0, max = u32::MAX), extend("default" = 1))]
    pub seed: u32,
    /// The shot whose draws this case has, counted from 0.
    ///
    /// Left out: the nominal case: nothing varies.
    #[schemars(range(min = 0, max = u32::MAX))]
    pub shot: Option<u32>,
    /// Where the projectile hits: the point of aim, or anywhere in the unit cell around it, evenly.
    ///
    /// Default: the point of aim.
    #[schemars(extend("default" = "aimed"))]
    pub hit: HitPlace,
    /// Impact velocity about the nominal one [m/s].
    ///
    /// Left out: it does not vary.
    #[schemars(with = "Option<VelocityKeys>")]
    pub velocity: Option<Scattered>,
    /// Angle of the line of flight about the nominal one; at normal incidence in any direction [rad].
    ///
    /// Left out: it does not vary.
    #[schemars(with = "Option<AngleKeys>")]
    pub obliquity: Option<Scattered>,
    /// Yaw about the nominal one, in the plane of the azimuth; at normal incidence in any direction [rad].
    ///
    /// Left out: it does not vary.
    #[schemars(with = "Option<AngleKeys>")]
    pub yaw: Option<Scattered>,
    /// Axial modulus of the fibre: one draw for warp, one for weft of a fabric.
    ///
    /// Left out: it does not vary.
    pub modulus: Option<Scattered>,
    /// Crimp: one draw for warp, one for weft of a fabric; an areal density that is given stays.
    ///
    /// Left out: it does not vary.
    pub crimp: Option<Scattered>,
    /// Strength of yarns along their length and between them, after Weibull.
    ///
    /// Left out: it does not vary.
    pub yarn_strength: Option<YarnStrength>,
}

/// Scatter about a nominal value.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Scattered {
    /// Distribution about the nominal value.
    ///
    /// Default: assumed: many small causes.
    #[schemars(extend("default" = "normal"))]
    pub distribution: Distribution,
    /// Standard deviation of a normal distribution, half the width of a uniform one, over the nominal value.
    #[schemars(range(max = 0.5), extend("exclusiveMinimum" = 0))]
    pub scatter: f64,
}

/// The keys of such a scatter in the unit of its value.
macro_rules! scatter_keys {
    ($($name:ident $key:ident $most:literal,)+) => {$(
        #[derive(JsonSchema)]
        #[allow(dead_code, reason = "for their schema")]
        struct $name {
            /// Distribution about the nominal value.
            ///
            /// Default: assumed: many small causes.
            #[schemars(extend("default" = "normal"))]
            distribution: Distribution,
            /// Standard deviation of a normal distribution, half the width of a uniform one.
            #[schemars(range(max = $most), extend("exclusiveMinimum" = 0))]
            $key: f64,
        }
    )+};
}
scatter_keys! { VelocityKeys scatter_m_s 1000, AngleKeys scatter_deg 45, }

choices! {
    /// A distribution about a nominal value.
    pub enum Distribution {
        /// Normal.
        Normal = "normal",
        /// Uniform.
        Uniform = "uniform",
    }
    /// Where the projectile of a shot hits.
    pub enum HitPlace {
        /// The point of aim.
        Aimed = "aimed",
        /// Anywhere in the unit cell around it.
        UnitCell = "unit_cell",
    }
}

/// Strength of yarns: Weibull's distribution along them, and another one between them.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct YarnStrength {
    /// Weibull's shape m along a yarn; the larger, the less the strength varies.
    #[schemars(range(min = 1, max = 1000), extend("help" = "Kevlar 49 yarn has 8 to 22, by gauge length"))]
    pub shape: f64,
    /// Length of the yarns whose mean failure strain is the fabric's failure_strain; a shorter piece is stronger [m].
    #[schemars(rename = "gauge_length_mm", range(min = 0.01, max = 1e5))]
    pub gauge_length: f64,
    /// Shortest length that was tested: a shorter piece is no stronger [m].
    ///
    /// Otherwise: 25 mm (assumed), or gauge_length_mm where that is shorter.
    #[serde(default)]
    #[schemars(rename = "shortest_gauge_mm", range(min = 0.01, max = 1e5), extend("at_most" = "gauge_length_mm"))]
    pub shortest_gauge: f64,
    /// Weibull's shape of the distribution of whole yarns about mean 1.
    ///
    /// Left out: yarns differ along their length only.
    #[schemars(range(min = 1, max = 1000))]
    pub yarn_shape: Option<f64>,
}

/// One value that was drawn for a shot.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Drawn {
    /// Column of `shots.csv`: the key, with its unit.
    pub column: String,
    /// The value in that unit.
    pub value: f64,
}

// Purposes of the draws of a whole shot: the `yarn` of their key.
const HIT: u32 = 0;
const VELOCITY: u32 = 1;
const OBLIQUITY: u32 = 2;
const YAW: u32 = 3;
const MODULUS: u32 = 4;
const CRIMP: u32 = 5;
/// Stream of the velocity that `ripstop shots --velocity A..B` draws.
pub(crate) const RANGE_STREAM: u32 = 6;

/// Shortest gauge length of tested yarns, where none is given [m].
const SHORTEST_GAUGE: f64 = 25e-3;
/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl Scattered {
    /// Deviation from the nominal value for a number that is uniform between 0 and 1; in the unit of the scatter.
    fn deviation(&self, uniform: f64) -> f64 {
        match self.distribution {
            Distribution::Normal => self.scatter * normal::quantile(uniform),
            Distribution::Uniform => self.scatter * (2.0 * uniform - 1.0),
        }
    }

    /// Words for the source of a drawn value; `per_si`: the unit's size.
    fn words(&self, unit: &str, per_si: f64) -> String {
        let scatter = short_number_text(self.scatter * per_si);
        match self.distribution {
            Distribution::Normal => format!("normal, standard deviation {scatter}{unit}"),
            Distribution::Uniform => format!("uniform, ± {scatter}{unit}"),
        }
    }
}

impl Variability {
    /// Completes the strength of yarns; refuses scatter of a flight without the body that flies.
    pub(super) fn complete(&mut self, projectile: Option<&Projectile>, record: &Provenance) -> Result<(), CaseError> {
        if let Some(YarnStrength { gauge_length, shortest_gauge, .. }) = &mut self.yarn_strength {
            let shortest = SHORTEST_GAUGE.min(*gauge_length);
            record.fill("/variability/yarn_strength/shortest_gauge_mm", shortest_gauge, shortest, "", true);
        }
        let in_flight = [
            ("hit", self.hit == HitPlace::UnitCell),
            ("velocity", self.velocity.is_some()),
            ("obliquity", self.obliquity.is_some()),
            ("yaw", self.yaw.is_some()),
        ];
        let lies_along = projectile.is_some_and(|projectile| projectile.shape.is_bar());
        let (name, expected, found) = match in_flight.iter().find(|(_, varies)| *varies) {
            Some((name, _)) if projectile.is_none() => (*name, "a projectile, whose flight varies", "none in the case"),
            _ if self.yaw.is_some() && lies_along => {
                ("yaw", "a projectile that can yaw", "a bar, which lies along the pack")
            }
            _ => return Ok(()),
        };
        Err(CaseError::at(format!("/variability/{name}"), expected, found))
    }

    /// Whether anything differs between two shots.
    pub fn varies(&self) -> bool {
        self.hit == HitPlace::UnitCell
            || [self.velocity, self.obliquity, self.yaw, self.modulus, self.crimp].iter().any(Option::is_some)
            || self.yarn_strength.is_some()
    }

    /// Whether the case is a shot whose yarns differ in strength.
    pub(crate) fn strength_varies(&self) -> bool {
        self.shot.is_some() && self.yarn_strength.is_some()
    }

    /// Numbers that are uniform between 0 and 1, for a purpose; `number` distinguishes several of one kind.
    fn uniform(&self, stream: u32, number: u32) -> [f64; 4] {
        let shot = self.shot.unwrap_or(0);
        DrawKey { seed: u64::from(self.seed), shot, ply: DrawKey::WHOLE, yarn: stream, element: number }.uniform()
    }
}

/// A document whose values are being replaced.
struct Realisation<'a> {
    document: Value,
    case: &'a Case,
    variability: &'a Variability,
    drawn: Vec<Drawn>,
}

/// The document of the shot that a nominal case names, and what was drawn; `None` where it names none.
pub(super) fn realised(case: &Case, document: &Value) -> Option<(Value, Vec<Drawn>)> {
    let variability = case.variability.as_ref().filter(|variability| variability.shot.is_some())?;
    let mut shot = Realisation { document: document.clone(), case, variability, drawn: Vec::new() };
    if let Some(projectile) = &case.projectile {
        shot.flight(projectile);
    }
    // A layer without a fabric of its own has the case's.
    let layers = case.pack.layup.iter().enumerate();
    let layers = layers.map(|(n, layer)| (format!("/pack/layup/{n}/fabric"), format!("layup_{n}_"), &layer.fabric));
    let all = std::iter::once(("/fabric".to_owned(), String::new(), &case.fabric)).chain(layers);
    for (number, (place, prefix, fabric)) in (0_u32..).zip(all) {
        if document.pointer(&place).is_some() {
            shot.fabric(number, &place, &prefix, fabric);
        }
    }
    Some((shot.document, shot.drawn))
}

impl Realisation<'_> {
    /// Puts a value in its key's unit in its place, with its source. `above`: where the distribution is described.
    fn put(&mut self, pointer: &str, value: Value, above: &str, words: &str) {
        let above = format!("/variability/{above}");
        let assumed = self.case.fields.iter().any(|field| field.assumed && field.pointer.starts_with(&above));
        let object =
            pointer.rsplit_once('/').and_then(|(object, name)| Some((self.document.pointer_mut(object)?, name)));
        if let Some((object, name)) = object {
            object[name] = value;
        }
        let word = if assumed { "assumed: " } else { "" };
        self.document["sources"][pointer] = json!(format!("{word}drawn, {words}"));
    }

    fn note(&mut self, column: impl Into<String>, value: f64) {
        self.drawn.push(Drawn { column: column.into(), value });
    }

    /// Hit, velocity, obliquity with its direction, yaw. At normal incidence every direction of the deviation is alike.
    fn flight(&mut self, projectile: &Projectile) {
        let Variability { hit, velocity, obliquity, yaw, .. } = self.variability;
        if *hit == HitPlace::UnitCell {
            let [u, v, ..] = self.variability.uniform(HIT, 0);
            let cell = [&self.case.fabric.warp, &self.case.fabric.weft].map(|yarn| 2.0 * yarn.half_span());
            let [x, y] = [projectile.offset[0] + (u - 0.5) * cell[0], projectile.offset[1] + (v - 0.5) * cell[1]];
            let [x, y] = [x * 1e3, y * 1e3];
            self.put("/projectile/offset_mm", json!([x, y]), "hit", "uniform over the unit cell");
            self.note("offset_x_mm", x);
            self.note("offset_y_mm", y);
        }
        if let Some(scattered) = velocity {
            let [u, ..] = self.variability.uniform(VELOCITY, 0);
            let velocity = projectile.velocity + scattered.deviation(u);
            // Its column is that of the impact velocity.
            self.put("/projectile/velocity_m_s", json!(velocity), "velocity", &scattered.words(" m/s", 1.0));
        }
        let [u, direction, ..] = self.variability.uniform(OBLIQUITY, 0);
        let mut azimuth = projectile.azimuth.to_degrees();
        let any_direction = (obliquity.is_some() || yaw.is_some()) && projectile.obliquity == 0.0;
        if any_direction {
            azimuth = 360.0 * direction;
            let above = if obliquity.is_some() { "obliquity" } else { "yaw" };
            self.put("/projectile/azimuth_deg", json!(azimuth), above, "uniform over all directions");
        }
        let drawn =
            obliquity.map(|scattered| (scattered, (projectile.obliquity + scattered.deviation(u)).to_degrees()));
        if drawn.is_some_and(|(_, obliquity)| obliquity < 0.0) {
            // The other way: the same line of flight.
            azimuth = if azimuth > 0.0 { azimuth - 180.0 } else { azimuth + 180.0 };
            let words = "turned by 180°: the obliquity drawn was negative";
            self.put("/projectile/azimuth_deg", json!(azimuth), "obliquity", words);
        }
        if any_direction || drawn.is_some() {
            self.note("azimuth_deg", azimuth);
        }
        if let Some((scattered, obliquity)) = drawn {
            self.angle("obliquity", obliquity.abs(), &scattered);
        }
        if let Some(scattered) = yaw {
            let [u, ..] = self.variability.uniform(YAW, 0);
            self.angle("yaw", (projectile.yaw + scattered.deviation(u)).to_degrees(), scattered);
        }
    }

    /// Puts an angle [deg] in its place.
    fn angle(&mut self, name: &str, angle: f64, scattered: &Scattered) {
        self.put(&format!("/projectile/{name}_deg"), json!(angle), name, &scattered.words("°", DEGREES));
        self.note(format!("{name}_deg"), angle);
    }

    /// Modulus and crimp of both yarns of a fabric: one draw each for a shot.
    fn fabric(&mut self, number: u32, place: &str, prefix: &str, fabric: &Fabric) {
        let Variability { modulus, crimp, .. } = self.variability;
        for (scattered, stream, name) in [(modulus, MODULUS, "modulus_gpa"), (crimp, CRIMP, "crimp")] {
            let Some(scattered) = scattered else { continue };
            let words = scattered.words(" of the nominal value", 1.0);
            let yarns = [("warp", &fabric.warp), ("weft", &fabric.weft)].into_iter();
            for ((yarn, constants), u) in yarns.zip(self.variability.uniform(stream, number)) {
                if constants.present {
                    let nominal = if name == "crimp" { constants.crimp } else { constants.modulus * 1e-9 };
                    let factor = 1.0 + scattered.deviation(u);
                    let value = nominal * factor;
                    let above = name.trim_end_matches("_gpa");
                    let curve = format!("{place}/{yarn}/curve");
                    // Of a yarn with a curve all stresses follow.
                    let points = self.document.pointer(&curve).filter(|_| above == "modulus");
                    let points = points.and_then(|points| Vec::<[f64; 2]>::deserialize(points).ok());
                    match points.map(|points| points.into_iter().map(|[strain, stress]| [strain, factor * stress])) {
                        Some(points) => self.put(&curve, json!(points.collect::<Vec<_>>()), above, &words),
                        None => self.put(&format!("{place}/{yarn}/{name}"), json!(value), above, &words),
                    }
                    self.note(format!("{prefix}{yarn}_{name}"), value);
                }
            }
        }
    }
}
