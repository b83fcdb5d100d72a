//! Variability from shot to shot, and the case of one shot.
//!
//! A case with `variability` and no `shot` is the nominal one: nothing varies, and nothing costs time. With a `shot` its values are drawn
//! and put in the places of the nominal ones, as if they were written there; only the strength of yarns, of which there is one for
//! each element, is left to the model. Draws are a function of seed and shot, see [`random`](crate::num::random).

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::error::short_number_text;
use super::keys::choices;
use super::{Case, CaseError, Fabric, Projectile};
use crate::num::link::Link;
use crate::num::random::DrawKey;

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

#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
struct VelocityKeys {
    /// Distribution about the nominal value.
    ///
    /// Default: assumed: many small causes.
    #[schemars(extend("default" = "normal"))]
    distribution: Distribution,
    /// Standard deviation of a normal distribution, half the width of a uniform one.
    #[schemars(range(max = 1000), extend("exclusiveMinimum" = 0))]
    scatter_m_s: f64,
}

#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
struct AngleKeys {
    /// Distribution about the nominal value.
    ///
    /// Default: assumed: many small causes.
    #[schemars(extend("default" = "normal"))]
    distribution: Distribution,
    /// Standard deviation of a normal distribution, half the width of a uniform one.
    #[schemars(range(max = 45), extend("exclusiveMinimum" = 0))]
    scatter_deg: f64,
}

choices! {
    /// A distribution about a nominal value.
    #[non_exhaustive]
    pub enum Distribution {
        /// Normal.
        Normal = "normal",
        /// Uniform.
        Uniform = "uniform",
    }
    /// Where the projectile of a shot hits.
    #[non_exhaustive]
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
    /// Weibull's shape m along a yarn; large: even.
    #[schemars(range(min = 1, max = 1000), extend("help" = "Kevlar 49 yarn has 8 to 22, by gauge length"))]
    pub shape: f64,
    /// Length of the yarns whose mean failure strain is the fabric's failure_strain; a shorter piece is stronger [m].
    #[schemars(rename = "gauge_length_mm", range(min = 0.01, max = 1e5))]
    pub gauge_length: f64,
    /// Weibull's shape of the distribution of whole yarns about mean 1.
    ///
    /// Left out: yarns do not differ but along their length.
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

/// Purposes of the draws of a whole shot: the `yarn` of their key.
mod stream {
    pub(super) const HIT: u32 = 0;
    pub(super) const VELOCITY: u32 = 1;
    pub(super) const OBLIQUITY: u32 = 2;
    pub(super) const YAW: u32 = 3;
    pub(super) const MODULUS: u32 = 4;
    pub(super) const CRIMP: u32 = 5;
}

/// Stream of the velocity that `ripstop shots --velocity A..B` draws.
pub(crate) const RANGE_STREAM: u32 = 6;

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl Scattered {
    /// Deviation from the nominal value for a number that is uniform between 0 and 1; in the unit of the scatter.
    fn deviation(&self, uniform: f64) -> f64 {
        match self.distribution {
            Distribution::Normal => self.scatter * Link::Probit.quantile(uniform),
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
    /// Refuses scatter of a flight without the body that flies.
    pub(super) fn check(&self, projectile: Option<&Projectile>) -> Result<(), CaseError> {
        let in_flight = [
            ("hit", self.hit == HitPlace::UnitCell),
            ("velocity", self.velocity.is_some()),
            ("obliquity", self.obliquity.is_some()),
            ("yaw", self.yaw.is_some()),
        ];
        let refused = |name: &str, expected: &str, found: &str| {
            Err(CaseError::at(format!("/variability/{name}"), expected, found))
        };
        match (in_flight.iter().find(|(_, varies)| *varies), projectile) {
            (Some((name, _)), None) => refused(name, "a projectile, whose flight varies", "none in the case"),
            (_, Some(projectile)) if self.yaw.is_some() && projectile.shape.is_bar() => {
                refused("yaw", "a projectile that can yaw", "a bar, which lies along the pack")
            }
            _ => Ok(()),
        }
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

    /// The key of the draws of a whole shot; `number` distinguishes several of one kind.
    fn key(&self, stream: u32, number: u32) -> DrawKey {
        let shot = self.shot.unwrap_or(0);
        DrawKey { seed: u64::from(self.seed), shot, ply: DrawKey::WHOLE, yarn: stream, element: number }
    }
}

/// A document whose values are being replaced.
struct Realisation<'a> {
    document: Value,
    case: &'a Case,
    drawn: Vec<Drawn>,
}

/// The document of the shot that a nominal case names, and what was drawn; `None` where it names none.
pub(super) fn realised(case: &Case, document: &Value) -> Option<(Value, Vec<Drawn>)> {
    let variability = case.variability.as_ref()?;
    variability.shot?;
    let mut shot = Realisation { document: document.clone(), case, drawn: Vec::new() };
    if let Some(projectile) = &case.projectile {
        shot.hit(variability, projectile);
        shot.flight(variability, projectile);
    }
    shot.fabrics(variability);
    Some((shot.document, shot.drawn))
}

impl Realisation<'_> {
    /// Puts a value in its key's unit in its place, with its source. `above`: where the distribution is described.
    fn put(&mut self, pointer: &str, value: Value, above: &str, words: &str) {
        let above = format!("/variability/{above}");
        let assumed = self.case.fields.iter().any(|field| field.assumed && field.pointer.starts_with(&above));
        let Some((object, name)) = pointer.rsplit_once('/') else { return };
        if let Some(object) = self.document.pointer_mut(object) {
            object[name] = value;
        }
        let word = if assumed { "assumed: " } else { "" };
        self.document["sources"][pointer] = json!(format!("{word}drawn, {words}"));
    }

    fn note(&mut self, column: impl Into<String>, value: f64) {
        self.drawn.push(Drawn { column: column.into(), value });
    }

    /// Uniform over the unit cell around the point of aim.
    fn hit(&mut self, variability: &Variability, projectile: &Projectile) {
        if variability.hit == HitPlace::Aimed {
            return;
        }
        let [u, v, ..] = variability.key(stream::HIT, 0).uniform();
        let fabric = &self.case.fabric;
        let cell = [2.0 * fabric.warp.half_span(), 2.0 * fabric.weft.half_span()];
        let [x, y] = [projectile.offset[0] + (u - 0.5) * cell[0], projectile.offset[1] + (v - 0.5) * cell[1]];
        let [x, y] = [x * 1e3, y * 1e3];
        self.put("/projectile/offset_mm", json!([x, y]), "hit", "uniform over the unit cell");
        self.note("offset_x_mm", x);
        self.note("offset_y_mm", y);
    }

    /// Velocity, obliquity with its direction, yaw. At normal incidence every direction of the deviation is alike.
    fn flight(&mut self, variability: &Variability, projectile: &Projectile) {
        if let Some(scattered) = &variability.velocity {
            let [u, ..] = variability.key(stream::VELOCITY, 0).uniform();
            let velocity = projectile.velocity + scattered.deviation(u);
            // Its column is that of the impact velocity.
            self.put("/projectile/velocity_m_s", json!(velocity), "velocity", &scattered.words(" m/s", 1.0));
        }
        let [u, direction, ..] = variability.key(stream::OBLIQUITY, 0).uniform();
        let mut azimuth = projectile.azimuth.to_degrees();
        let deviates = variability.obliquity.is_some() || variability.yaw.is_some();
        let azimuth_at = "/projectile/azimuth_deg";
        let any_direction = deviates && projectile.obliquity == 0.0;
        if any_direction {
            azimuth = 360.0 * direction;
            let above = if variability.obliquity.is_some() { "obliquity" } else { "yaw" };
            self.put(azimuth_at, json!(azimuth), above, "uniform over all directions");
        }
        if let Some(scattered) = &variability.obliquity {
            let mut obliquity = (projectile.obliquity + scattered.deviation(u)).to_degrees();
            if obliquity < 0.0 {
                // The other way: the same line of flight.
                obliquity = -obliquity;
                azimuth = if azimuth > 0.0 { azimuth - 180.0 } else { azimuth + 180.0 };
                let words = "turned by 180°: the obliquity drawn was negative";
                self.put(azimuth_at, json!(azimuth), "obliquity", words);
            }
            self.note("azimuth_deg", azimuth);
            self.put("/projectile/obliquity_deg", json!(obliquity), "obliquity", &scattered.words("°", DEGREES));
            self.note("obliquity_deg", obliquity);
        } else if any_direction {
            self.note("azimuth_deg", azimuth);
        }
        if let Some(scattered) = &variability.yaw {
            let [u, ..] = variability.key(stream::YAW, 0).uniform();
            let yaw = (projectile.yaw + scattered.deviation(u)).to_degrees();
            self.put("/projectile/yaw_deg", json!(yaw), "yaw", &scattered.words("°", DEGREES));
            self.note("yaw_deg", yaw);
        }
    }

    /// Modulus and crimp of both yarns of every fabric: one draw for a shot. A layer without a fabric of its own has the case's.
    fn fabrics(&mut self, variability: &Variability) {
        let case = self.case;
        let layers = case.pack.layup.iter().enumerate();
        let layers = layers.map(|(n, layer)| (format!("/pack/layup/{n}/fabric"), format!("layup_{n}_"), &layer.fabric));
        let all = std::iter::once(("/fabric".to_owned(), String::new(), &case.fabric)).chain(layers);
        for (number, (place, prefix, fabric)) in (0_u32..).zip(all) {
            if self.document.pointer(&place).is_some() {
                self.fabric(variability, number, &place, &prefix, fabric);
            }
        }
    }

    fn fabric(&mut self, variability: &Variability, number: u32, place: &str, prefix: &str, fabric: &Fabric) {
        let yarns = [("warp", &fabric.warp), ("weft", &fabric.weft)];
        let kinds = [
            (&variability.modulus, stream::MODULUS, "modulus", "modulus_gpa", 1e-9),
            (&variability.crimp, stream::CRIMP, "crimp", "crimp", 1.0),
        ];
        for (scattered, stream, section, name, unit) in kinds {
            let Some(scattered) = scattered else { continue };
            let uniform = variability.key(stream, number).uniform();
            for ((yarn, constants), u) in yarns.into_iter().zip(uniform).filter(|((_, yarn), _)| yarn.present) {
                let nominal = if section == "crimp" { constants.crimp } else { constants.modulus * unit };
                let value = nominal * (1.0 + scattered.deviation(u));
                let words = scattered.words(" of the nominal value", 1.0);
                self.put(&format!("{place}/{yarn}/{name}"), json!(value), section, &words);
                self.note(format!("{prefix}{yarn}_{name}"), value);
            }
        }
    }
}
