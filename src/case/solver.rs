//! Numerical choices and output.

use schemars::JsonSchema;
use serde::Deserialize;

use super::provenance::Provenance;
use super::text::number_text;
use super::units::{Mm, Us, Word, choices};
use super::{Along, CaseError, Motion, Pack, Projectile};

/// Coefficient of the shock viscosity.
const VISCOSITY: f64 = 0.3;
/// Coefficient of the shock viscosity where a bar strikes. The pulse that its kink sends out at the start runs on along the strip, where that
/// of a round body spreads over a ply: with 0.3 it stands 30 % above the exact tension. The step is a third shorter.
const VISCOSITY_ALONG_A_BAR: f64 = 0.8;
/// A shot whose case names no end and whose outcome is not known ends here [s].
const LONGEST: f64 = 1e-3;
/// End of such a shot where no ply spans between two clamped sides [s]. What nothing holds stops the projectile when all of it moves: 150 mm at
/// 50 m/s take 5.2 ms. What one side holds swings first: 100 mm at 120 m/s take 2.5 ms.
const LONGEST_LOOSE: f64 = 8e-3;
/// Length along a yarn over which its failure is judged [m]; assumed.
const FAILURE_LENGTH: f64 = 0.9e-3;

/// Time integration.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solver {
    /// The scheme behind the defaults of the others.
    pub numerics: Numerics,
    /// Refinement of the mesh around the hit.
    pub accuracy: Accuracy,
    /// [s]
    pub end_time: f64,
    /// Time step over the critical one, in (0, 1].
    pub courant: f64,
    /// Hourglass stiffness over the full-integration stiffness [-].
    pub hourglass: f64,
    /// Coefficient of the shock viscosity along the yarns [-].
    pub shock_viscosity: f64,
    /// Length along a yarn over which its failure is judged [m]; 0: that of an element.
    pub failure_length: f64,
    /// Whether mirror symmetry may be used.
    pub symmetry: Symmetry,
    /// Where contact with the projectile is sampled.
    pub contact_sampling: ContactSampling,
    /// Where an element's stretches are taken.
    pub stretch_sampling: StretchSampling,
    /// When the run ends.
    pub run_until: RunUntil,
}

/// What is written and how often.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Output {
    /// Interval of `history.csv` [s].
    pub history_interval: f64,
    /// Frames for ParaView, evenly from the start to the end time.
    pub frames: u32,
    /// Times at which a deflection profile is sampled [s], ascending.
    pub profile_times: Vec<f64>,
    /// Direction of the profile through the point of impact (pack centre without projectile).
    pub profile_along: Along,
}

choices! {
    /// The scheme that keys left out of a case take their values from.
    #[non_exhaustive]
    pub enum Numerics {
        /// Shock viscosity, contact at the edges, a mesh that is fine around the hit.
        Default = "default",
        /// The paper's own: one even element per crossover, contact at nodes, stretches at the centre, no viscosity.
        Paper = "paper",
    }
    /// Refinement of the mesh around the hit.
    #[non_exhaustive]
    pub enum Accuracy {
        /// The cheapest mesh whose ballistic limit is near the converged one.
        Default = "default",
        /// The mesh from which on the limit stays.
        Converged = "converged",
    }
    /// Whether mirror symmetry may be used.
    #[non_exhaustive]
    pub enum Symmetry {
        /// Where the scene has it.
        Auto = "auto",
        /// Never.
        None = "none",
    }
    /// Where contact with the projectile is sampled.
    #[non_exhaustive]
    pub enum ContactSampling {
        /// At nodes.
        Nodes = "nodes",
        /// At nodes, and where the rim of a flat face crosses the edges of elements.
        Edges = "edges",
    }
    /// Where an element's stretches are taken.
    #[non_exhaustive]
    pub enum StretchSampling {
        /// At its centre.
        Centre = "centre",
        /// Over the element: the root of the mean of their squares.
        Mean = "mean",
    }
    /// When the run ends.
    #[non_exhaustive]
    pub enum RunUntil {
        /// As soon as the outcome is known (or at `end_time`).
        Outcome = "outcome",
        /// As soon as the projectile is through, or flies back free of the fabric (or at `end_time`).
        Separation = "separation",
        /// At `end_time`, whatever happened before.
        EndTime = "end_time",
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct SolverKeys {
    /// End of the run. Needed where nothing flies freely into the pack, or run_until is "end_time".
    #[schemars(
        range(min = 1e-6, max = 1e9),
        extend("derived" = "when the outcome is known, after 1000 µs at the latest, 8000 µs where no two opposite sides are clamped")
    )]
    end_time_us: Option<Us>,
    /// The scheme that keys left out take their values from: ripstop's own, or the paper's (one even element per crossover, contact
    /// at nodes, stretches at the centre, no viscosity).
    #[schemars(extend("default" = "default", "source" = "measured: tension shocks neither ring nor make energy"))]
    numerics: Numerics,
    /// How far the mesh around the hit is refined, where elements_per_crossover is left out.
    #[schemars(extend("default" = "default", "source" = "measured: a ballistic limit within 5 % of the converged one"))]
    accuracy: Accuracy,
    /// Time step over the critical one.
    #[schemars(range(max = 1.0), extend(
        "exclusiveMinimum" = 0.0, "default" = 0.9, "source" = "model: margin for contact, shear and hourglass stiffness",
        "help" = "above 1 the time step exceeds the critical step and leapfrog integration is unstable"
    ))]
    courant: f64,
    /// Hourglass stiffness over the full-integration stiffness.
    #[schemars(
        range(min = 0.0, max = 1.0),
        extend("default" = 0.001, "source" = "model: keeps hourglass energy small without stiffening")
    )]
    hourglass: f64,
    /// Viscosity along the yarns over the stiffness, times length of an element over wave speed, for smooth waves one crossover at most;
    /// 0: none, as in the paper.
    #[schemars(range(min = 0.0, max = 1.0), extend("derived" = "0.3, where a bar strikes 0.8, measured: tension behind a shock peaks at \
        most a third above its plateau; 0 with \"numerics\": \"paper\""))]
    shock_viscosity: Option<f64>,
    /// Length along a yarn over which the strain that breaks it is averaged, and which breaks; over its width the root mean square
    /// counts. 0: that of an element, as in the paper.
    #[schemars(
        range(min = 0.0, max = 100.0),
        extend("derived" = "0.9, assumed: the order of a yarn's width; 0 with \"numerics\": \"paper\"")
    )]
    failure_length_mm: Option<Mm>,
    /// Whether mirror symmetry may be used.
    #[schemars(extend("default" = "auto", "source" = "same result, less work"))]
    symmetry: Symmetry,
    /// Where contact with the projectile is sampled: at nodes, or also where the rim of a flat face crosses the edges of elements.
    #[schemars(extend("derived" = "rim, measured: before failure nearer to a finer mesh than nodes; nodes with \"numerics\": \"paper\""))]
    contact_sampling: Option<ContactSampling>,
    /// Where an element's stretches are taken: at its centre, or as the root of the mean of their squares over the element.
    #[schemars(extend("derived" = "mean, measured: the ballistic limit is within 1 % of the converged one, not 4 %; centre with \
        \"numerics\": \"paper\""))]
    stretch_sampling: Option<StretchSampling>,
    /// When the run ends: with the outcome, when a projectile that stopped is free of the fabric too, or at end_time_us.
    #[schemars(extend("default" = "outcome", "source" = "nothing asked for happens after it"))]
    run_until: RunUntil,
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct OutputKeys {
    /// Interval of history.csv, at most end_time_us.
    #[schemars(range(min = 1e-6, max = 1e9), extend("default" = 0.5, "source" = "a few hundred rows for a shot"))]
    history_interval_us: Us,
    /// Frames for ParaView, evenly from impact to the end of the run.
    #[schemars(range(min = 0, max = 10_000), extend("default" = 0, "source" = "none asked for"))]
    frames: u32,
    /// Times of deflection profiles, ascending.
    #[schemars(length(min = 0, max = 1000), inner(range(min = 0.0, max = 1e9)), extend("default" = [], "source" = "none asked for"))]
    profile_times_us: Vec<Us>,
    /// Direction of the profiles, through the point of impact.
    #[schemars(extend("default" = "warp", "source" = "the first axis"))]
    profile_along: Along,
}

impl SolverKeys {
    /// The solver without the end of the run, and the end that the case names [s].
    pub(super) fn solver(self, projectile: Option<&Projectile>, record: &Provenance) -> (Solver, Option<f64>) {
        let paper = self.numerics == Numerics::Paper;
        let viscosity = match projectile {
            _ if paper => 0.0,
            Some(projectile) if projectile.shape.is_bar() => VISCOSITY_ALONG_A_BAR,
            _ => VISCOSITY,
        };
        let failure_length = if paper { 0.0 } else { FAILURE_LENGTH };
        let derive = |name: &str, si: f64, assumed: bool| record.derive(&format!("/solver/{name}"), si, "", assumed);
        let solver = Solver {
            numerics: self.numerics,
            accuracy: self.accuracy,
            end_time: LONGEST,
            courant: self.courant,
            hourglass: self.hourglass,
            shock_viscosity: self.shock_viscosity.unwrap_or_else(|| derive("shock_viscosity", viscosity, false)),
            failure_length: (self.failure_length_mm.map(Mm::si))
                .unwrap_or_else(|| derive("failure_length_mm", failure_length, !paper)),
            symmetry: self.symmetry,
            contact_sampling: self.contact_sampling.unwrap_or_else(|| {
                let sampling = if paper { ContactSampling::Nodes } else { ContactSampling::Edges };
                record.derive_text("/solver/contact_sampling", sampling.word(), "", false);
                sampling
            }),
            stretch_sampling: self.stretch_sampling.unwrap_or_else(|| {
                let sampling = if paper { StretchSampling::Centre } else { StretchSampling::Mean };
                record.derive_text("/solver/stretch_sampling", sampling.word(), "", false);
                sampling
            }),
            run_until: self.run_until,
        };
        (solver, self.end_time_us.map(Us::si))
    }
}

impl Solver {
    /// The latest end of a run whose case names none [s].
    pub(super) fn latest_end(
        &self,
        projectile: Option<&Projectile>,
        pack: &Pack,
        record: &Provenance,
    ) -> Result<f64, CaseError> {
        let at = "/solver/end_time_us";
        if self.run_until == RunUntil::EndTime || projectile.is_none_or(|p| p.motion != Motion::Free) {
            let error = CaseError::at(at, "the end of the run", "nothing");
            return Err(error.help("no outcome ends this run: it has no free projectile, or run_until is \"end_time\""));
        }
        let spans =
            if pack.layup.is_empty() { pack.edges.span() } else { pack.layup.iter().any(|layer| layer.edges.span()) };
        Ok(record.derive(at, if spans { LONGEST } else { LONGEST_LOOSE }, "", false))
    }
}

impl OutputKeys {
    pub(super) fn output(self) -> Result<Output, CaseError> {
        let profile_times: Vec<f64> = self.profile_times_us.iter().map(|time| time.si()).collect();
        if let Some(index) = profile_times.windows(2).position(|pair| pair[0] >= pair[1]) {
            let location = format!("/output/profile_times_us/{}", index + 1);
            let expected = format!("more than item {index} of \"profile_times_us\": ascending times");
            return Err(CaseError::at(&location, expected, number_text(self.profile_times_us[index + 1].0)));
        }
        Ok(Output {
            history_interval: self.history_interval_us.si(),
            frames: self.frames,
            profile_times,
            profile_along: self.profile_along,
        })
    }
}
