//! The kernels of a ply type that go row by row, compiled for the vectors of this processor.

use crate::model::ply_type::PlyType;
use crate::num::scalar::{Real, Scalar};
#[cfg(not(feature = "quick-build"))]
use crate::num::simd::Pair;
use crate::num::simd::Vectors;
use crate::physics::kinematics::ElementConstants;
use crate::solver::contact::broad_phase::broad_phase;
use crate::solver::contact::ply_search::SearchPart;
use crate::solver::element_force::element_force;
use crate::solver::element_totals::{ElementRow, ElementTotals};
use crate::solver::node_update::{NodePass, NodeRow, NodeTotals, node_update};

/// The kernels, row by row.
pub trait RowKernels<S: Scalar>: Send + Sync {
    /// Forces of a part of a row of elements; see [`element_force`].
    fn elements(&self, row: &mut ElementRow<'_, S>, totals: &mut ElementTotals);

    /// Motion of a part of a row of nodes; see [`node_update`].
    fn nodes(&self, pass: &NodePass<'_, S>, node: &mut NodeRow<'_, S>) -> NodeTotals;

    /// Candidates of a part of a search; see `broad_phase`.
    fn broad_phase(&self, part: &mut SearchPart<'_, S>);
}

/// The kernels of a ply type: on numbers like `R`, in the broad phase on numbers like `P` and, in double precision, `D`.
struct Compiled<R: Real, P, D> {
    constants: ElementConstants<R>,
    shear: bool,
    broad: (P, D),
}

impl<R, P, D> RowKernels<R::Scalar> for Compiled<R, P, D>
where
    R: Real + Send + Sync,
    P: Real<Scalar = R::Scalar> + Send + Sync,
    D: Real<Scalar = f64> + Send + Sync,
{
    fn elements(&self, row: &mut ElementRow<'_, R::Scalar>, totals: &mut ElementTotals) {
        self.constants.area.vectorize(
            #[inline(always)]
            || element_force(&self.constants, self.shear, row, totals),
        );
    }

    fn nodes(&self, pass: &NodePass<'_, R::Scalar>, node: &mut NodeRow<'_, R::Scalar>) -> NodeTotals {
        node_update(self.constants.area, pass, node)
    }

    fn broad_phase(&self, part: &mut SearchPart<'_, R::Scalar>) {
        broad_phase(self.broad, part);
    }
}

/// A precision that has kernels. They are compiled here, once, not wherever something generic uses them.
pub trait KernelScalar: Scalar {
    /// The kernels of a ply type.
    fn kernels(ply_type: &PlyType<Self>, vectors: Vectors) -> Box<dyn RowKernels<Self>>;
}

macro_rules! kernel_scalar {
    ($scalar:ty) => {
        impl KernelScalar for $scalar {
            #[inline(never)]
            fn kernels(ply_type: &PlyType<Self>, vectors: Vectors) -> Box<dyn RowKernels<Self>> {
                match vectors {
                    Vectors::None => compiled(ply_type, Self::splat(0.0), (Self::splat(0.0), 0.0)),
                    #[cfg(target_arch = "x86_64")]
                    Vectors::Avx512(simd) => {
                        compiled(ply_type, Self::many(simd), (Self::lanes(simd), f64::lanes(simd)))
                    }
                    #[cfg(all(target_arch = "x86_64", not(feature = "quick-build")))]
                    Vectors::Avx2(simd) => {
                        compiled(ply_type, Pair::of(Self::lanes(simd)), (Self::lanes(simd), f64::lanes(simd)))
                    }
                    #[cfg(target_arch = "aarch64")]
                    Vectors::Neon(simd) => {
                        compiled(ply_type, Pair::of(Self::lanes(simd)), (Self::lanes(simd), f64::lanes(simd)))
                    }
                }
            }
        }
    };
}

kernel_scalar!(f64);
kernel_scalar!(f32);

fn compiled<R, P, D>(ply_type: &PlyType<R::Scalar>, n: R, broad: (P, D)) -> Box<dyn RowKernels<R::Scalar>>
where
    R: Real + Send + Sync + 'static,
    P: Real<Scalar = R::Scalar> + Send + Sync + 'static,
    D: Real<Scalar = f64> + Send + Sync + 'static,
{
    let (constants, spread) = (ply_type.constants::<R::Scalar>(), |x| n.broadcast(x));
    let constants = constants.map(constants.cell.map(spread), spread);
    Box::new(Compiled { constants, shear: ply_type.has_shear, broad })
}
