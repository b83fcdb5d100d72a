//! Fabrics, cells, patches of elements and seeded numbers for the tests.
//!
//! No physics of the solver is repeated here except in [`oracle`], which gets it by other means.

pub(crate) mod oracle;
pub(crate) mod patch;

use ripstop::case::{Compression, Crossover, Fabric, Law, MembraneForce, Yarn};
use ripstop::model::unit_cell::{CurveLaw, parameters};
use ripstop::num::scalar::Scalar;
use ripstop::physics::crossover;
use ripstop::physics::unit_cell_parameters::UnitCellParameters;

/// Calls `$body` with `$law` bound to the kernel type of a [`CurveLaw`].
macro_rules! with_curve_law {
    ($which:expr, $law:ident => $body:expr) => {{
        if $which == CurveLaw::Kawabata {
            type $law = ripstop::model::unit_cell::Kawabata;
            $body
        } else {
            type $law = ripstop::physics::yarn_law::Sinusoidal;
            $body
        }
    }};
}

/// Every law kernel there is.
pub(crate) const LAWS: [CurveLaw; 3] = [CurveLaw::Published, CurveLaw::Variational, CurveLaw::Kawabata];

/// Laws of the solver.
pub(crate) const SOLVER_LAWS: [Law; 2] = [Law::Published, Law::Variational];

/// Compression of the crossover: rigid, and the project's assumed constants (a in m, b in m·N^(1/3)).
pub(crate) const CROSSOVERS: [Option<Compression>; 2] = [None, Some(Compression { a: 1e-4, b: 1e-4 })];

/// Axial stiffness of S-720: E = 96 GPa, 1420 denier, 1440 kg/m³ [N].
pub(crate) const S720_STIFFNESS: f64 = 96e9 * (1420.0 / 9e6) / 1440.0;
/// Half-span of S-720, 20 yarns per inch [m].
pub(crate) const S720_HALF_SPAN: f64 = 0.0254 / 40.0;
/// Crimps of S-720, warp and weft [-].
pub(crate) const S720_CRIMP: [f64; 2] = [0.0218, 0.0139];
/// Failure strain of Kevlar 129 [-].
pub(crate) const FAILURE_STRAIN: f64 = 0.035;

/// SplitMix64: the same numbers on every machine.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Three numbers in [−size, size).
    pub(crate) fn vector(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.between(-size, size))
    }
}

/// The largest of many errors and where it was.
#[derive(Debug, Default)]
pub(crate) struct Worst {
    pub(crate) error: f64,
    place: String,
}

impl Worst {
    /// Takes note of an error; a NaN counts as infinite.
    pub(crate) fn see(&mut self, error: f64, place: impl FnOnce() -> String) {
        let error = if error.is_nan() { f64::INFINITY } else { error.abs() };
        if error > self.error {
            *self = Self { error, place: place() };
        }
    }

    #[track_caller]
    pub(crate) fn assert_at_most(&self, limit: f64) {
        assert!(self.error <= limit, "{:.3e} > {limit:.0e} at {}", self.error, self.place);
    }
}

/// A yarn of axial stiffness `stiffness` [N] and half-span `half_span` [m].
pub(crate) fn yarn(stiffness: f64, half_span: f64, crimp: f64) -> Yarn {
    // A section of exactly 1 m² (linear density = fibre density) makes the modulus the stiffness, unrounded.
    Yarn {
        present: true,
        linear_density: DENSITY,
        modulus: stiffness,
        curve: Vec::new(),
        failure_strain: FAILURE_STRAIN,
        strength_retention: 1.0,
        count: 0.5 / half_span,
        crimp,
    }
}

const DENSITY: f64 = 1440.0;

/// A fabric, and the law of its unit cell.
#[derive(Clone, Debug)]
pub(crate) struct Woven {
    pub(crate) fabric: Fabric,
    pub(crate) law: CurveLaw,
}

/// A fabric of two yarns.
pub(crate) fn fabric(yarns: [Yarn; 2], law: CurveLaw, gap: f64, compression: Option<Compression>) -> Woven {
    let [warp, weft] = yarns;
    let own = if law == CurveLaw::Variational { Law::Variational } else { Law::Published };
    let crossover = Crossover { law: own, membrane_force: MembraneForce::Tension, gap, compression };
    let fabric = Fabric {
        name: "test".to_owned(),
        fibre_density: DENSITY,
        areal_density: 0.2552,
        warp,
        weft,
        crossover,
        shear: None,
        thickness: 3e-4,
        rate: None,
    };
    Woven { fabric, law }
}

/// S-720 without a gap.
pub(crate) fn s720(law: CurveLaw, compression: Option<Compression>) -> Woven {
    let yarns = S720_CRIMP.map(|crimp| yarn(S720_STIFFNESS, S720_HALF_SPAN, crimp));
    fabric(yarns, law, 0.0, compression)
}

/// The unit cell of a fabric as one number type sees it.
pub(crate) struct Cell<R> {
    pub(crate) law: CurveLaw,
    /// In double precision.
    pub(crate) exact: UnitCellParameters<f64>,
    pub(crate) constants: UnitCellParameters<R>,
}

/// Equilibrium of one cell, in double precision whatever it was solved in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Solved {
    pub(crate) tension: [f64; 2],
    pub(crate) in_plane: [f64; 2],
    pub(crate) strain: [f64; 2],
    pub(crate) height: [f64; 2],
    pub(crate) force: f64,
    pub(crate) residual: f64,
    pub(crate) iterations: f64,
    pub(crate) converged: bool,
}

impl<R: Scalar> Cell<R> {
    pub(crate) fn new(woven: &Woven) -> Self {
        let law = woven.law;
        let exact = parameters(&woven.fabric, law);
        let constants = with_curve_law!(law, L => UnitCellParameters::cast::<L>(&exact));
        Self { law, exact, constants }
    }

    /// Solves for stretches Λ from heights [m]; `both`: both yarns are alive and present.
    pub(crate) fn solve(&self, stretch: [f64; 2], warm: [f64; 2], both: bool) -> Solved {
        let excess = stretch.map(|s| R::splat(s - 1.0));
        let warm = warm.map(R::splat);
        let e = with_curve_law!(self.law, L => crossover::solve::<R, L>(&self.constants, excess, warm, both));
        let pair = |x: [R; 2]| x.map(|x| x.to_f64());
        Solved {
            tension: pair(e.tension),
            in_plane: pair(e.in_plane),
            strain: pair(e.strain),
            height: pair(e.height),
            force: e.force.to_f64(),
            residual: e.residual.to_f64(),
            iterations: e.iterations.to_f64(),
            converged: e.converged,
        }
    }

    /// Solves with both yarns alive from the heights at rest.
    pub(crate) fn solve_from_rest(&self, stretch: [f64; 2]) -> Solved {
        self.solve(stretch, self.rest_heights(), true)
    }

    /// Solves with one yarn dead or absent.
    pub(crate) fn solve_free(&self, stretch: [f64; 2]) -> Solved {
        self.solve(stretch, self.rest_heights(), false)
    }

    /// Heights at rest [m].
    pub(crate) fn rest_heights(&self) -> [f64; 2] {
        self.exact.yarn.map(|y| y.height)
    }

    /// Breaking tension EA·0.035 of each yarn [N].
    pub(crate) fn breaking(&self) -> [f64; 2] {
        self.exact.yarn.map(|y| y.stiffness * FAILURE_STRAIN)
    }

    /// Breaking tension of the softer yarn [N].
    pub(crate) fn softer_breaking(&self) -> f64 {
        let [one, two] = self.breaking();
        one.min(two)
    }
}
