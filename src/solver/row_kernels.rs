//! The element and node kernels of a ply type, compiled for the vectors of this processor.

use std::marker::PhantomData;
use std::ops::Range;

use crate::model::ply_type::PlyType;
use crate::num::scalar::{Real, Scalar};
#[cfg(not(feature = "quick-build"))]
use crate::num::simd::Pair;
use crate::num::simd::Vectors;
use crate::physics::element_geometry::ElementConstants;
use crate::physics::yarn_law::LawKernel;
use crate::solver::broad_phase::BroadPhase;
use crate::solver::broad_phase::Compiled as CompiledBroadPhase;
use crate::solver::element_force::element_force;
use crate::solver::element_totals::{ElementRow, ElementTotals, Extent};
use crate::solver::node_update::{NodePass, NodeRow, NodeTotals, node_update};

/// The kernels, row by row.
pub trait RowKernels<S>: Send + Sync {
    /// Forces of a part of a row of elements; see [`element_force`].
    fn elements(
        &self,
        row: &mut ElementRow<'_, S>,
        range: Range<usize>,
        dt: f64,
        sample: bool,
        totals: &mut ElementTotals,
    );

    /// Motion of a part of a row of nodes; see [`node_update`].
    fn nodes(&self, pass: &NodePass<'_, S>, node: &mut NodeRow<'_, S>) -> NodeTotals;
}

/// The kernels of a ply type with law `L`, on numbers like `R`.
struct Compiled<R: Real, L> {
    constants: ElementConstants<R>,
    shear: bool,
    law: PhantomData<L>,
}

impl<R: Real + Send + Sync, L: LawKernel> RowKernels<R::Scalar> for Compiled<R, L> {
    fn elements(
        &self,
        row: &mut ElementRow<'_, R::Scalar>,
        range: Range<usize>,
        dt: f64,
        sample: bool,
        totals: &mut ElementTotals,
    ) {
        let extent = Extent { shear: self.shear, sample };
        self.constants.area.vectorize(
            #[inline(always)]
            || element_force::<R, L>(&self.constants, row, range, dt, extent, totals),
        );
    }

    fn nodes(&self, pass: &NodePass<'_, R::Scalar>, node: &mut NodeRow<'_, R::Scalar>) -> NodeTotals {
        nodes(self.constants.area, pass, node)
    }
}

/// Compiled once for all laws.
#[inline(never)]
fn nodes<R: Real>(n: R, pass: &NodePass<'_, R::Scalar>, node: &mut NodeRow<'_, R::Scalar>) -> NodeTotals {
    n.vectorize(
        #[inline(always)]
        || node_update(n, pass, node),
    )
}

/// A precision that has kernels. They are compiled here, once, not wherever something generic uses them.
pub trait KernelScalar: Scalar {
    /// The kernels of a ply type.
    fn kernels(ply_type: &PlyType<Self>, vectors: Vectors) -> Box<dyn RowKernels<Self>>;

    /// The broad phase: nodes that may touch the next ply.
    fn broad_phase(vectors: Vectors) -> Box<dyn BroadPhase<Self>>;
}

macro_rules! kernel_scalar {
    ($scalar:ty) => {
        impl KernelScalar for $scalar {
            #[inline(never)]
            fn kernels(ply_type: &PlyType<Self>, vectors: Vectors) -> Box<dyn RowKernels<Self>> {
                crate::with_law!(ply_type.law, L => of_law::<Self, L>(ply_type, vectors))
            }

            #[inline(never)]
            fn broad_phase(vectors: Vectors) -> Box<dyn BroadPhase<Self>> {
                broad_phase(vectors)
            }
        }
    };
}

kernel_scalar!(f64);
kernel_scalar!(f32);

fn of_law<S: Scalar, L: LawKernel>(ply_type: &PlyType<S>, vectors: Vectors) -> Box<dyn RowKernels<S>> {
    let constants = ply_type.constants::<S, L>();
    let shear = ply_type.has_shear;
    match vectors {
        Vectors::None => compiled::<S, L>(&constants, S::splat(0.0), shear),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Vectors::Avx512(simd) => compiled::<_, L>(&constants, S::many(simd), shear),
        #[cfg(all(any(target_arch = "x86", target_arch = "x86_64"), not(feature = "quick-build")))]
        Vectors::Avx2(simd) => compiled::<_, L>(&constants, Pair::of(S::lanes(simd)), shear),
        #[cfg(target_arch = "aarch64")]
        Vectors::Neon(simd) => compiled::<_, L>(&constants, Pair::of(S::lanes(simd)), shear),
    }
}

fn compiled<R, L>(constants: &ElementConstants<R::Scalar>, n: R, shear: bool) -> Box<dyn RowKernels<R::Scalar>>
where
    R: Real + Send + Sync + 'static,
    L: LawKernel,
{
    Box::new(Compiled::<R, L> { constants: constants.spread(n), shear, law: PhantomData })
}

fn broad_phase<S: Scalar>(vectors: Vectors) -> Box<dyn BroadPhase<S>> {
    match vectors {
        Vectors::None => Box::new(CompiledBroadPhase(S::splat(0.0), 0.0)),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Vectors::Avx512(simd) => Box::new(CompiledBroadPhase(S::lanes(simd), f64::lanes(simd))),
        #[cfg(all(any(target_arch = "x86", target_arch = "x86_64"), not(feature = "quick-build")))]
        Vectors::Avx2(simd) => Box::new(CompiledBroadPhase(S::lanes(simd), f64::lanes(simd))),
        #[cfg(target_arch = "aarch64")]
        Vectors::Neon(simd) => Box::new(CompiledBroadPhase(S::lanes(simd), f64::lanes(simd))),
    }
}
