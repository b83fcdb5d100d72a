//! What varies from shot to shot, and the case of one shot.
//!
//! A case with `variability` and no `shot` is the nominal one: nothing varies, and nothing costs time. With a `shot` its values are drawn
//! and put in the places of the nominal ones, as if somebody had written them there; only the strength of yarns, of which there is one for
//! each element, is left to the model. Draws are a function of seed and shot, see [`counter_random`](crate::num::random).

use serde_json::{Map, Value, json};

use super::error::CaseError;
use super::scope::ObjectReader;
use super::value::short_number_text;
use super::{Case, Fabric, Projectile, Shape};
use crate::num::link::Link;
use crate::num::random::DrawKey;

/// What varies from shot to shot.
#[derive(Clone, Debug, PartialEq)]
pub struct Variability {
    /// What all draws come from.
    pub seed: u32,
    /// The shot that the case is; `None`: the nominal one.
    pub shot: Option<u32>,
    /// Where the projectile hits.
    pub hit: HitPlace,
    /// Impact velocity [m/s].
    pub velocity: Option<Scattered>,
    /// Obliquity [rad].
    pub obliquity: Option<Scattered>,
    /// Yaw [rad].
    pub yaw: Option<Scattered>,
    /// Modulus of warp and weft, one draw each, over the nominal one [-].
    pub modulus: Option<Scattered>,
    /// Crimp of warp and weft, one draw each, over the nominal one [-].
    pub crimp: Option<Scattered>,
    /// Strength along the yarns.
    pub yarn_strength: Option<YarnStrength>,
}

/// Scatter about a nominal value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Scattered {
    /// Its distribution.
    pub distribution: Distribution,
    /// Standard deviation of a normal distribution, half the width of a uniform one.
    pub scatter: f64,
}

/// A distribution about a nominal value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Distribution {
    /// Normal.
    Normal,
    /// Uniform.
    Uniform,
}

/// Where the projectile of a shot hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HitPlace {
    /// The point of aim.
    Aimed,
    /// Anywhere in the unit cell around it.
    UnitCell,
}

/// Strength of yarns: Weibull's distribution along them, and another one between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YarnStrength {
    /// Shape m along a yarn [-].
    pub shape: f64,
    /// Length of the yarns whose mean failure strain the fabric's is [m].
    pub gauge_length: f64,
    /// Shape of the distribution of yarns, its mean 1 [-]; `None`: they do not differ but along their length.
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

/// What the draws of a whole shot are for: the `yarn` of their key.
mod stream {
    pub(super) const HIT: u32 = 0;
    pub(super) const VELOCITY: u32 = 1;
    pub(super) const OBLIQUITY: u32 = 2;
    pub(super) const YAW: u32 = 3;
    pub(super) const MODULUS: u32 = 4;
    pub(super) const CRIMP: u32 = 5;
}

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Stream of the velocity that `ripstop shots --velocity A..B` draws.
pub(crate) const RANGE_STREAM: u32 = 6;

/// Reads the section. What flies must be there for its scatter to mean anything.
pub(super) fn read(scope: &ObjectReader<'_>, projectile: Option<&Projectile>) -> Result<Variability, CaseError> {
    let seed = scope.whole("seed")?;
    let shot = if scope.given("shot").is_some() { Some(scope.whole("shot")?) } else { None };
    let hit: HitPlace = scope.word("hit")?;
    let scattered = |name: &str, key: &str| -> Result<Option<Scattered>, CaseError> {
        let Some(keys) = scope.object_if_given(name)? else { return Ok(None) };
        Ok(Some(Scattered { distribution: keys.word("distribution")?, scatter: keys.number(key)? }))
    };
    let velocity = scattered("velocity", "scatter_m_s")?;
    let obliquity = scattered("obliquity", "scatter_deg")?;
    let yaw = scattered("yaw", "scatter_deg")?;
    let flying =
        [("hit", hit == HitPlace::UnitCell), ("velocity", velocity.is_some()), ("obliquity", obliquity.is_some())];
    for (name, varies) in flying.into_iter().chain([("yaw", yaw.is_some())]) {
        if varies && projectile.is_none() {
            return Err(CaseError::at(scope.at(name), "a projectile, whose flight varies", "none in the case"));
        }
    }
    if yaw.is_some() && projectile.is_some_and(|projectile| matches!(projectile.shape, Shape::Bar { .. })) {
        return Err(CaseError::at(scope.at("yaw"), "a projectile that can yaw", "a bar, which lies along the pack"));
    }
    let modulus = scattered("modulus", "scatter")?;
    let crimp = scattered("crimp", "scatter")?;
    let strength = |keys: ObjectReader<'_>| -> Result<YarnStrength, CaseError> {
        let (shape, gauge_length) = (keys.number("shape")?, keys.number("gauge_length_mm")?);
        Ok(YarnStrength { shape, gauge_length, yarn_shape: keys.number_if_given("yarn_shape")? })
    };
    let yarn_strength = scope.object_if_given("yarn_strength")?.map(strength).transpose()?;
    Ok(Variability { seed, shot, hit, velocity, obliquity, yaw, modulus, crimp, yarn_strength })
}

impl Scattered {
    /// Deviation from the nominal value for a number that is uniform between 0 and 1; in the unit of the scatter.
    fn deviation(&self, uniform: f64) -> f64 {
        match self.distribution {
            Distribution::Normal => self.scatter * Link::Probit.quantile(uniform),
            Distribution::Uniform => self.scatter * (2.0 * uniform - 1.0),
        }
    }

    /// In words, for the source of a drawn value; `per_si`: the unit's size.
    fn words(&self, unit: &str, per_si: f64) -> String {
        let scatter = short_number_text(self.scatter * per_si);
        match self.distribution {
            Distribution::Normal => format!("normal, standard deviation {scatter}{unit}"),
            Distribution::Uniform => format!("uniform, ± {scatter}{unit}"),
        }
    }
}

impl Variability {
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

    /// The key of the draws of a whole shot; `number` tells several of one kind apart.
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
        let assumed = self.case.fields.iter().any(|field| field.assumed && field.pointer.starts_with(above));
        let Some((object, name)) = pointer.rsplit_once('/') else { return };
        if let Some(Value::Object(map)) = self.document.pointer_mut(object) {
            map.insert(name.to_owned(), value);
        }
        let Some(document) = self.document.as_object_mut() else { return };
        if let Value::Object(sources) = document.entry("sources").or_insert_with(|| Value::Object(Map::new())) {
            let word = if assumed { "assumed: " } else { "" };
            sources.insert(pointer.to_owned(), Value::from(format!("{word}drawn, {words}")));
        }
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
        self.put("/projectile/offset_mm", json!([x, y]), "/variability/hit", "uniform over the unit cell");
        self.note("offset_x_mm", x);
        self.note("offset_y_mm", y);
    }

    /// Velocity, obliquity with its direction, yaw. At normal incidence every direction of the deviation is alike.
    fn flight(&mut self, variability: &Variability, projectile: &Projectile) {
        if let Some(scattered) = &variability.velocity {
            let [u, ..] = variability.key(stream::VELOCITY, 0).uniform();
            let velocity = projectile.velocity + scattered.deviation(u);
            self.put(
                "/projectile/velocity_m_s",
                json!(velocity),
                "/variability/velocity",
                &scattered.words(" m/s", 1.0),
            );
            // Its column is that of the impact velocity.
        }
        let [u, direction, ..] = variability.key(stream::OBLIQUITY, 0).uniform();
        let mut azimuth = projectile.azimuth.to_degrees();
        let deviates = variability.obliquity.is_some() || variability.yaw.is_some();
        if deviates && projectile.obliquity == 0.0 {
            azimuth = 360.0 * direction;
            let above = if variability.obliquity.is_some() { "/variability/obliquity" } else { "/variability/yaw" };
            self.put("/projectile/azimuth_deg", json!(azimuth), above, "uniform over all directions");
            self.note("azimuth_deg", azimuth);
        }
        if let Some(scattered) = &variability.obliquity {
            let mut obliquity = (projectile.obliquity + scattered.deviation(u)).to_degrees();
            if obliquity < 0.0 {
                // The other way: the same line of flight.
                obliquity = -obliquity;
                azimuth = if azimuth > 0.0 { azimuth - 180.0 } else { azimuth + 180.0 };
                let words = "turned by 180°: the obliquity drawn was negative";
                self.put("/projectile/azimuth_deg", json!(azimuth), "/variability/obliquity", words);
                self.drawn.retain(|drawn| drawn.column != "azimuth_deg");
                self.note("azimuth_deg", azimuth);
            } else if projectile.obliquity != 0.0 {
                self.note("azimuth_deg", azimuth);
            }
            self.put(
                "/projectile/obliquity_deg",
                json!(obliquity),
                "/variability/obliquity",
                &scattered.words("°", DEGREES),
            );
            self.note("obliquity_deg", obliquity);
        }
        if let Some(scattered) = &variability.yaw {
            let [u, ..] = variability.key(stream::YAW, 0).uniform();
            let yaw = (projectile.yaw + scattered.deviation(u)).to_degrees();
            self.put("/projectile/yaw_deg", json!(yaw), "/variability/yaw", &scattered.words("°", DEGREES));
            self.note("yaw_deg", yaw);
        }
    }

    /// Modulus and crimp of both yarns of every fabric: one draw for a shot.
    fn fabrics(&mut self, variability: &Variability) {
        let layers = self.case.pack.layup.iter().enumerate();
        let mut places = vec![("/fabric".to_owned(), String::new(), self.case.fabric.clone())];
        places.extend(
            layers.map(|(n, layer)| (format!("/pack/layup/{n}/fabric"), format!("layup_{n}_"), layer.fabric.clone())),
        );
        for (number, (place, prefix, fabric)) in (0_u32..).zip(places) {
            // A layer without a fabric of its own has the case's.
            if self.document.pointer(&place).is_some() {
                self.fabric(variability, number, &place, &prefix, &fabric);
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
                self.put(&format!("{place}/{yarn}/{name}"), json!(value), &format!("/variability/{section}"), &words);
                self.note(format!("{prefix}{yarn}_{name}"), value);
            }
        }
    }
}
