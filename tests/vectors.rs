//! Vector registers.
//!
//! Promised: whatever registers the kernels use, every number of a run is the same to the last bit.
//! Red when: a lane is computed from its neighbours, a sum depends on how many are added at once, padding leaks in, or a register's
//! own instruction differs from what one number does.

use ripstop::case::Case;
use ripstop::model::Model;
use ripstop::num::scalar::{Real, Scalar};
use ripstop::num::simd::{Pair, Vectors};
use ripstop::run::RunScalar;
use ripstop::solver::energy_balance::{Balance, EnergyBalance};
use ripstop::solver::state::State;
use ripstop::solver::{FailureEvent, Stepper};

use crate::support::builtin;

/// Everything that a run leaves behind.
#[derive(Debug, PartialEq)]
struct Trace<S> {
    nodes: Vec<S>,
    elements: Vec<S>,
    balances: Vec<Balance>,
    failures: Vec<FailureEvent>,
    /// Evaluations, solved cells, largest residual, elements computed.
    counts: Vec<[f64; 4]>,
}

fn trace<S: RunScalar>(case: &Case, vectors: Vectors, steps: u64) -> Trace<S> {
    let model = Model::<S>::new(case).unwrap();
    let mut state = State::new(case, &model);
    let mut ledger = EnergyBalance::default();
    let mut stepper = Stepper::with_vectors(&model, vectors);
    let (mut balances, mut failures, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    for step in 0..steps {
        let totals = stepper.step(&model, &mut state, &mut ledger, step.is_multiple_of(3));
        balances.push(ledger.balance());
        failures.extend(stepper.failures.iter().copied());
        counts.push([totals.iterations, totals.solved, totals.max_residual, totals.computed as f64]);
    }
    Trace { nodes: state.nodes.data.to_vec(), elements: elements_of(&model, &state), balances, failures, counts }
}

/// Fields of the elements that there are; what vectors write beyond the last column is not one of them.
fn elements_of<S: RunScalar>(model: &Model<S>, state: &State<S>) -> Vec<S> {
    let mesh = &model.ply_type(0).mesh;
    let fields = (0..mesh.rows).flat_map(|row| (0..state.elements.fields).map(move |field| (row, field)));
    fields.flat_map(|(row, field)| (1..=mesh.columns).map(move |at| state.elements.get(row, field, at))).collect()
}

fn same_on_all<S: RunScalar>(case: &Case, steps: u64) {
    let all = Vectors::all();
    let widest = trace::<S>(case, all[0], steps);
    assert!(!widest.failures.is_empty(), "yarns break");
    for vectors in &all[1..] {
        let other = trace::<S>(case, *vectors, steps);
        let names = format!("{} against {}", vectors.name(), all[0].name());
        assert!(other.failures == widest.failures, "failures: {names}");
        assert_eq!(other.counts, widest.counts, "{names}");
        assert!(other.balances == widest.balances, "energies: {names}");
        let differs = |one: &[S], two: &[S]| one.iter().zip(two).position(|(a, b)| a != b);
        assert_eq!(differs(&other.nodes, &widest.nodes), None, "nodes: {names}");
        assert_eq!(differs(&other.elements, &widest.elements), None, "elements: {names}");
    }
}

/// A shot through fabric of an odd size, off centre, so that what has been reached begins and ends anywhere.
fn shot(more: &[&str]) -> Case {
    let size = ["/pack/width_mm=43", "/pack/height_mm=31", "/projectile/velocity_m_s=400"];
    let rest = ["/projectile/offset_mm=[3.1,-2.2]", "/output/profile_times_us=[]", "/expect=[]"];
    builtin("cases/s720-1ply-155.json", &[&size[..], &rest[..], more].concat())
}

#[test]
fn every_kind_of_register_gives_the_same_bits() {
    assert_eq!(Vectors::all().last().unwrap().name(), "scalar");
    for (case, steps) in [(shot(&[]), 130), (shot(&["/fabric/crossover/law=variational"]), 60)] {
        same_on_all::<f64>(&case, steps);
        same_on_all::<f32>(&case, steps);
    }
}

/// Largest and smallest of pairs in registers like `n` are those of one number alone, to the sign of a zero and whatever is not a
/// number.
fn same_extremes<R: Real>(n: R, name: &str) {
    let values = [0.0, -0.0, 1.0, -1.5, f64::INFINITY, f64::NAN].map(R::Scalar::splat);
    let same = |found: R, one: R::Scalar| {
        let bits = (0..R::LANES).map(|lane| found.lane(lane).to_f64().to_bits());
        assert!(bits.into_iter().all(|bits| bits == one.to_f64().to_bits()), "{name}: not {one:?}");
    };
    for a in values {
        for b in values {
            let (x, y) = (n.broadcast(a), n.broadcast(b));
            same(x.max(y), Real::max(a, b));
            same(x.min(y), Real::min(a, b));
        }
    }
}

fn same_extremes_on_all<S: RunScalar>() {
    for vectors in Vectors::all() {
        match vectors {
            Vectors::None => {}
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Vectors::Avx512(simd) => same_extremes(Pair::of(S::lanes(simd)), vectors.name()),
            #[cfg(all(any(target_arch = "x86", target_arch = "x86_64"), not(feature = "quick-build")))]
            Vectors::Avx2(simd) => same_extremes(Pair::of(S::lanes(simd)), vectors.name()),
            #[cfg(target_arch = "aarch64")]
            Vectors::Neon(simd) => same_extremes(Pair::of(S::lanes(simd)), vectors.name()),
        }
    }
}

#[test]
fn the_largest_and_the_smallest_are_those_of_one_number_alone() {
    same_extremes_on_all::<f64>();
    same_extremes_on_all::<f32>();
}
