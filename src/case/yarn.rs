//! Yarns of a fabric: their keys, and numbers of a data sheet in the place of those that the model needs: a curve of stress over strain for
//! the modulus, strength for failure strain, areal density for crimp.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::error::short_number_text;
use super::provenance::Provenance;
use super::{CaseError, Fabric};

/// Keys that give a strength.
const STRENGTHS: [&str; 4] = ["tenacity_g_den", "tenacity_cn_tex", "strength_mpa", "strength_gpa"];
/// Difference from the chord, over the last stress, of a curve that is straight [-].
const STRAIGHT: f64 = 1e-12;
/// Largest crimp that follows from an areal density [-]: more is a slip of a unit.
const MAX_CRIMP: f64 = 0.25;

/// One yarn system.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default)]
pub struct Yarn {
    /// False when this yarn direction is absent (`"absent": true`): no tension, no crimp, only its count.
    #[serde(rename = "absent", deserialize_with = "not")]
    pub present: bool,
    /// Mass per length of the straight yarn [kg/m].
    pub linear_density: f64,
    /// Fibre elastic modulus; of a yarn with a curve, its steepest slope [Pa].
    pub modulus: f64,
    /// Strain [-] and stress [Pa] of points of a curve from nothing to break, both rising; none: stress is modulus times strain.
    pub curve: Vec<[f64; 2]>,
    /// Axial strain at which the virgin yarn breaks [-].
    pub failure_strain: f64,
    /// Part of that strain, and so of the strength, that is left in the fabric [-].
    pub strength_retention: f64,
    /// Crossovers per metre along this yarn, m in (12): undeformed cell length 2·w0 = 1/count [1/m].
    pub count: f64,
    /// Crimp (14): yarn length over fabric length minus one [-].
    pub crimp: f64,
}

impl Default for Yarn {
    /// A yarn that carries nothing, weighs nothing and never breaks.
    fn default() -> Self {
        let [linear_density, modulus, count, crimp] = [0.0; 4];
        let [failure_strain, strength_retention] = [1.0; 2];
        let curve = Vec::new();
        Self { present: false, linear_density, modulus, curve, failure_strain, strength_retention, count, crimp }
    }
}

fn not<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    bool::deserialize(deserializer).map(|flag| !flag)
}

/// Keys of a yarn.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
pub(super) struct YarnKeys {
    /// True: no yarn in this direction, its count still sets the element size.
    ///
    /// Default: a woven fabric has both yarns.
    #[schemars(extend("default" = false))]
    absent: bool,
    /// Mass of 9000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_denier: Option<f64>,
    /// Mass of 1000 m of yarn.
    #[schemars(range(min = 0.001, max = 1e5), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_tex: Option<f64>,
    /// Mass of 10 000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_dtex: Option<f64>,
    /// Axial modulus of the fibre.
    #[schemars(range(min = 1e-6, max = 1e4), extend("group" = "modulus or curve", "only" = {"absent": "false"}))]
    modulus_gpa: Option<f64>,
    /// Strain and stress [GPa] of points from [0, 0] on, both rising, straight in between: in place of the modulus.
    #[schemars(length(min = 2, max = 16), inner(inner(range(min = 0, max = 1e4))))]
    #[schemars(extend("group" = "modulus or curve", "only" = {"absent": "false"}))]
    curve: Option<Vec<[f64; 2]>>,
    /// Axial strain at which the yarn breaks; 1: never.
    #[schemars(range(max = 1), extend("help" = "a part of one: 0.035, or \"3.5 %\"", "exclusiveMinimum" = 0, "group" = "failure strain or strength", "only" = {"absent": "false"}))]
    failure_strain: Option<f64>,
    /// Strength over linear density, in its place.
    #[schemars(range(min = 1e-3, max = 1e3), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    tenacity_g_den: Option<f64>,
    /// Strength over linear density, in its place.
    #[schemars(range(min = 1e-2, max = 1e4), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    tenacity_cn_tex: Option<f64>,
    /// Strength of the fibre, in its place.
    #[schemars(range(min = 1e-2, max = 1e6), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    strength_mpa: Option<f64>,
    /// Strength of the fibre, in its place.
    #[schemars(range(min = 1e-5, max = 1e3), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    strength_gpa: Option<f64>,
    /// Part of failure_strain, and so of strength, that a woven yarn keeps; assumed unless `sources` has this very key.
    ///
    /// Default: virgin yarn, as published.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0, "default" = 1, "only" = {"absent": "false"}, "own_source" = true))]
    strength_retention: f64,
    /// Crossovers along this yarn per inch: along the warp, the picks of a data sheet.
    #[schemars(range(min = 0.1, max = 1000), extend("group" = "count"))]
    count_per_inch: Option<f64>,
    /// Crossovers along this yarn per cm: along the warp, the picks of a data sheet.
    #[schemars(range(min = 0.04, max = 400), extend("group" = "count"))]
    count_per_cm: Option<f64>,
    /// Yarn length over fabric length, minus one.
    ///
    /// Otherwise: areal density over that of straight yarns, minus one; the same in both where both are left out.
    #[schemars(range(min = 0, max = 0.5), extend("only" = {"absent": "false"}))]
    crimp: Option<f64>,
}

impl Yarn {
    /// Fibre cross-section A = linear density / fibre density [m²].
    pub fn area(&self, fibre_density: f64) -> f64 {
        self.linear_density / fibre_density
    }

    /// Axial strain at which the yarn breaks as woven; `None`: never [-].
    pub fn breaking_strain(&self) -> Option<f64> {
        (self.failure_strain < 1.0).then_some(self.failure_strain * self.strength_retention)
    }

    /// Undeformed half-span w0 = 1/(2·count) (12) [m].
    pub fn half_span(&self) -> f64 {
        0.5 / self.count
    }

    /// Completes the yarn whose keys stand at the pointer `at`, of fibres of this density [kg/m³].
    pub(super) fn complete(&mut self, at: &str, fibre_density: f64, record: &Provenance) -> Result<(), CaseError> {
        let points = self.complete_modulus(at, record)?;
        self.complete_failure_strain(at, &points, fibre_density, record)
    }

    /// Points of the curve [-], [Pa], none of a yarn without one. They give the modulus, which stands alone for a straight curve.
    fn complete_modulus(&mut self, at: &str, record: &Provenance) -> Result<Vec<[f64; 2]>, CaseError> {
        let Some(&[end, top]) = self.curve.last() else { return Ok(Vec::new()) };
        let refused = |index: usize, expected: String| {
            let [strain, stress] = self.curve[index].map(short_number_text);
            let error = CaseError::at(format!("{at}/curve/{index}"), expected, format!("[{strain}, {stress}]"));
            let units = "strain [-], 0.035 for 3.5 %, and stress [GPa]";
            Err(error.help(format!("points of {units}, both rising, from [0, 0] to where the yarn breaks")))
        };
        if self.curve[0] != [0.0; 2] {
            return refused(0, "[0, 0], a yarn without load".to_owned());
        }
        let mut steepest: f64 = 0.0;
        for (index, pair) in self.curve.windows(2).enumerate() {
            let [strain, stress] = [0, 1].map(|i| pair[1][i] - pair[0][i]);
            if strain <= 0.0 || stress <= 0.0 || pair[1][0] > 1.0 {
                let [strain, stress] = pair[0].map(short_number_text);
                let expected = format!("a strain above {strain}, at most 1, and a stress above {stress} GPa");
                return refused(index + 1, expected);
            }
            steepest = steepest.max(stress / strain);
        }
        if end < self.failure_strain && self.failure_strain < 1.0 {
            let expected = format!("at most the last strain of the curve, {}, or 1: never", short_number_text(end));
            let found = short_number_text(self.failure_strain);
            let error = CaseError::at(format!("{at}/failure_strain"), expected, found);
            return Err(error.help("the curve has to reach to where the yarn breaks"));
        }
        let is_straight =
            self.curve.iter().all(|[strain, stress]| (stress - strain * top / end).abs() <= STRAIGHT * top);
        let (modulus, how) = match is_straight {
            // Without the dust of decimal points.
            true => {
                (format!("{:.11e}", top / end).parse().unwrap_or(top / end), "slope of the curve, which is straight")
            }
            false => (steepest, "steepest slope of the curve; sets the time step"),
        };
        let assumed = record.is_assumed(&format!("{at}/curve"));
        self.modulus = record.derive(&format!("{at}/modulus_gpa"), 1e9 * modulus, how, assumed);
        let points: Vec<[f64; 2]> = self.curve.iter().map(|[strain, stress]| [*strain, 1e9 * stress]).collect();
        self.curve = if is_straight { Vec::new() } else { points.clone() };
        Ok(points)
    }

    /// Failure strain from the strength, where that is given, and from the points of a curve, where there are some.
    fn complete_failure_strain(
        &mut self,
        at: &str,
        points: &[[f64; 2]],
        fibre_density: f64,
        record: &Provenance,
    ) -> Result<(), CaseError> {
        let given = STRENGTHS.into_iter().find_map(|key| Some((key, record.si(&format!("{at}/{key}"))?)));
        let Some((key, strength)) = given else { return Ok(()) };
        let is_tenacity = key.starts_with("tenacity");
        let (factor, times) = if is_tenacity { (fibre_density, " × fibre density") } else { (1.0, "") };
        let strength = strength * factor;
        let on_curve = |ends: &[[f64; 2]]| {
            let [[strain, stress], [next, above]] = [ends[0], ends[1]];
            (strength <= above).then(|| strain + (strength - stress) * (next - strain) / (above - stress))
        };
        let (strain, over) = match points {
            [] => (strength / self.modulus, "/ modulus"),
            points => (points.windows(2).find_map(on_curve).unwrap_or(1.0), "on the curve"),
        };
        let place = format!("{at}/{key}");
        if strain >= 1.0 {
            let (of, most, beyond) = match points.last() {
                None => {
                    ("below the modulus", self.modulus, format!(", a failure strain of {}", short_number_text(strain)))
                }
                Some([_, stress]) => ("at most the last stress of the curve", *stress, String::new()),
            };
            let expected = format!("a strength {of}, {} GPa", short_number_text(1e-9 * most));
            let found = record.value(&place) + &beyond;
            return Err(CaseError::at(place, expected, found).help("look at the units of both"));
        }
        let assumed = record.is_assumed(&place) || record.is_assumed(&format!("{at}/modulus_gpa"));
        let how = format!("{key}{times} {over}");
        self.failure_strain = record.derive(&format!("{at}/failure_strain"), strain, &how, assumed);
        Ok(())
    }
}

impl Fabric {
    /// Completes the yarns of the fabric whose keys stand at the pointer `at`. Yarns without a crimp get that which follows from the areal
    /// density.
    pub(super) fn complete_yarns(&mut self, at: &str, record: &Provenance) -> Result<(), CaseError> {
        let (warp, weft) = (&mut self.warp, &mut self.weft);
        // Mass per area of straight yarns.
        let straight = [warp.linear_density * weft.count, weft.linear_density * warp.count];
        let mut unknown = Vec::new();
        let mut known = 0.0;
        for ((name, yarn), straight) in [("warp", warp), ("weft", weft)].into_iter().zip(straight) {
            let at = format!("{at}/{name}");
            if !yarn.present {
                continue;
            }
            yarn.complete(&at, self.fibre_density, record)?;
            known += straight * (1.0 + yarn.crimp);
            let crimp = format!("{at}/crimp");
            if !record.has(&crimp) {
                unknown.push((crimp, yarn, straight));
            }
        }
        let Some((first, ..)) = unknown.first() else { return Ok(()) };
        let areal = format!("{at}/areal_density_g_m2");
        if !record.has(&areal) {
            let error = CaseError::at(first, "a crimp, or areal_density_g_m2", "neither");
            return Err(
                error.help("from the areal density follows the crimp: how much more than straight yarns it weighs")
            );
        }
        let share: f64 = unknown.iter().map(|(.., straight)| straight).sum();
        let crimp = (self.areal_density - known) / share;
        if !(0.0..=MAX_CRIMP).contains(&crimp) {
            let [least, most] = [0.0, MAX_CRIMP].map(|crimp| short_number_text(1e3 * (known + crimp * share)));
            let expected = format!("{least} to {most} g/m²: straight yarns, and a crimp of {MAX_CRIMP}");
            let error = CaseError::at(&areal, expected, format!("{} g/m²", record.value(&areal)));
            return Err(error.help("look at units, linear density and count, or give \"crimp\""));
        }
        let assumed = unknown.len() == 2 || record.is_assumed(&areal);
        for (place, yarn, _) in unknown {
            yarn.crimp = record.derive(&place, crimp, "", assumed);
        }
        Ok(())
    }
}
