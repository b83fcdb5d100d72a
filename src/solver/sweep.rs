//! Elements and nodes in one sweep over the rows of a ply.
//!
//! A row of nodes can move as soon as the rows of elements on both sides of it are computed, while these are still in the
//! cache. Bands and in them blocks of rows run in parallel; the row of nodes between two of them moves when both are done, since
//! until then both read it.
//!
//! The kernels that go row by row are compiled here for the vectors of this processor, once for each ply type.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::model::Model;
use crate::model::ply_type::PlyType;
use crate::num::scalar::{Real, Scalar};
#[cfg(not(feature = "quick-build"))]
use crate::num::simd::Pair;
use crate::num::simd::Vectors;
use crate::physics::kinematics::ElementConstants;
use crate::solver::Context;
use crate::solver::contact::broad_phase::broad_phase;
use crate::solver::contact::ply_move::{PlyMoveTotals, PushedRow, ply_move};
use crate::solver::contact::ply_search::SearchPart;
use crate::solver::element_force::element_force;
use crate::solver::element_totals::{ElementRow, ElementTotals, field as element};
use crate::solver::node_update::{Neighbours, NodePass, NodeRow, NodeTotals, field, node_update};
use crate::solver::state::{ActiveRegion, State, split, split_mut};

/// Rows of elements of a block.
const BLOCK: usize = 8;
/// Bands a ply is cut into at most. More threads share bands.
pub(super) const BANDS: usize = 4;
/// Plies whose rows at the ends of bands one thread moves: a few rows take no longer than sharing them out.
const TOGETHER: usize = 16;

/// Numbers and totals of a row of elements.
type ElementLine<'a, S> = (&'a mut [S], &'a mut ElementTotals);
/// Numbers and totals of a row of nodes.
type NodeLine<'a, S> = (&'a mut [S], &'a mut NodeTotals);

/// Rows of elements from `first` on, with the rows of nodes strictly between them.
struct RowBand<'a, 'b, S> {
    first: usize,
    nodes: &'b mut [NodeLine<'a, S>],
    elements: &'b mut [ElementLine<'a, S>],
}

/// A band with its number, its ply and the rows of nodes at its ends, which it only reads.
type Band<'a, 'b, S> = (usize, &'b PlyPass<'a, S>, RowBand<'a, 'b, S>, [&'b [S]; 2]);

/// Strips on either side of a row of nodes, and that row.
type Parted<'a, 'b, S> = (RowBand<'a, 'b, S>, &'b mut NodeLine<'a, S>, RowBand<'a, 'b, S>);

impl<'a, 'b, S> RowBand<'a, 'b, S> {
    /// Cuts it at the row of nodes `row`.
    fn cut(self, row: usize) -> Parted<'a, 'b, S> {
        let rows = row - self.first;
        let (low, high) = self.elements.split_at_mut(rows);
        let (below, nodes) = self.nodes.split_at_mut(rows - 1);
        let (middle, above) = nodes.split_at_mut(1);
        let low = RowBand { first: self.first, nodes: below, elements: low };
        (low, &mut middle[0], RowBand { first: row, nodes: above, elements: high })
    }

    /// Strip lent for a while.
    fn lend(&mut self) -> RowBand<'a, '_, S> {
        RowBand { first: self.first, nodes: self.nodes, elements: self.elements }
    }
}

/// Pass over the rows of a ply.
struct PlyPass<'a, S: Scalar> {
    model: &'a Model<S>,
    ply: usize,
    kernels: &'a dyn RowKernels<S>,
    /// Zeros for a row of nodes without elements on one side.
    nothing: &'a [S],
    /// Rows and columns of the elements that are computed.
    elements: [Range<usize>; 2],
    /// Nodes that move.
    nodes: ActiveRegion,
    /// Time since the last forces; of this kick; of this drift [s].
    times: [f64; 3],
    sample: bool,
}

/// A ply and its rows.
struct Storage<'a, 'b, S: Scalar> {
    ply: PlyPass<'a, S>,
    /// Rows of nodes at the ends of bands, the first and the last of the ply among them.
    cuts: Vec<usize>,
    nodes: &'b mut [NodeLine<'a, S>],
    elements: &'b mut [ElementLine<'a, S>],
}

/// Rows of numbers, each with its totals.
fn lines<'a, S, T>(numbers: &'a mut [S], totals: &'a mut [T]) -> Vec<(&'a mut [S], &'a mut T)> {
    let length = numbers.len() / totals.len();
    numbers.chunks_mut(length).zip(totals).collect()
}

/// Cuts the rows of elements of a ply into bands, among which those to compute are shared out evenly.
fn cuts(rows: usize, computed: &Range<usize>, bands: usize) -> Vec<usize> {
    let inner = (1..bands).map(|band| computed.start + computed.len() * band / bands);
    let mut cuts: Vec<usize> =
        [0].into_iter().chain(inner.filter(|cut| (1..rows).contains(cut))).chain([rows]).collect();
    cuts.dedup();
    cuts
}

impl<'a, S: Scalar> Storage<'a, '_, S> {
    fn bands(&mut self) -> Vec<Band<'a, '_, S>> {
        let (first, nodes) = self.nodes.split_at_mut(1);
        let (nodes, last) = nodes.split_at_mut(self.elements.len() - 1);
        let (mut low, last) = (&*first[0].0, &*last[0].0);
        let mut rest = RowBand { first: 0, nodes, elements: self.elements };
        let mut bands = Vec::with_capacity(self.cuts.len() - 1);
        for (band, &row) in self.cuts[1..self.cuts.len() - 1].iter().enumerate() {
            let (strip, middle, high) = rest.cut(row);
            let middle = &*middle.0;
            bands.push((band, &self.ply, strip, [low, middle]));
            (low, rest) = (middle, high);
        }
        bands.push((self.cuts.len() - 2, &self.ply, rest, [low, last]));
        bands
    }

    /// Moves the rows of nodes at the ends of bands, once all bands have read them.
    fn move_ends(&mut self) {
        let elements = |row: Option<usize>| {
            row.and_then(|row| self.elements.get(row)).map_or(self.ply.nothing, |(numbers, _)| numbers)
        };
        for &row in &self.cuts {
            self.ply.move_nodes(row, elements(row.checked_sub(1)), elements(Some(row)), &mut self.nodes[row]);
        }
    }
}

/// Advances every ply, with the kernels of each ply type; totals are by row of elements and by row of nodes. `nothing`: see [`PlyPass`].
pub(super) fn sweep<S: Scalar>(
    context: &mut Context<'_, S>,
    kernels: &[Box<dyn RowKernels<S>>],
    nothing: &[S],
    element_totals: &mut [ElementTotals],
    node_totals: &mut [NodeTotals],
) {
    let (model, sample, kick) = (context.model, context.sample, context.kick());
    let State { nodes, elements, active, step, .. } = &mut *context.state;
    // The first step computes everything, so that yarn heights at rest are those the unit cell finds.
    let all = *step == 0;
    let times = [if all { 0.0 } else { model.dt }, kick, model.dt];
    let rows = model.grid.rows;
    let bands = rayon::current_num_threads().min(BANDS);
    let mut nodes = lines(&mut nodes.data, node_totals);
    let mut elements = lines(&mut elements.data, element_totals);
    let plies = nodes.chunks_mut(rows + 1).zip(elements.chunks_mut(rows)).enumerate();
    let plies = plies.map(|(ply, (nodes, elements))| {
        let (mesh, reached): (_, &ActiveRegion) = (&model.ply_type(ply).mesh, &active[ply]);
        let ply = PlyPass {
            model,
            ply,
            kernels: &*kernels[model.plies[ply].ply_type],
            nothing,
            elements: if all { [0..mesh.rows, 0..mesh.columns] } else { reached.elements(mesh) },
            nodes: reached.grown(1, mesh),
            times,
            sample,
        };
        let cuts = cuts(mesh.rows, &ply.elements[0], bands);
        // A ply may have fewer rows than there is room for.
        Storage { ply, cuts, nodes: &mut nodes[..=mesh.rows], elements: &mut elements[..mesh.rows] }
    });
    let mut plies: Vec<_> = plies.collect();
    // Band by band, so that a thread has the same rows of neighbouring plies, which look at each other in contact.
    let mut bands: Vec<_> = plies.iter_mut().flat_map(Storage::bands).collect();
    bands.sort_by_key(|(number, ..)| *number);
    bands.into_par_iter().for_each(|(_, ply, strip, ends)| ply.strip(strip, ends));
    plies.par_iter_mut().with_min_len(TOGETHER).for_each(Storage::move_ends);
}

impl<S: Scalar> PlyPass<'_, S> {
    /// A strip between two rows of nodes, which nothing moves before it is done; block by block.
    fn strip(&self, strip: RowBand<'_, '_, S>, [below, above]: [&[S]; 2]) {
        let rows = strip.elements.len();
        if rows <= BLOCK {
            self.rows(strip, [below, above]);
            return;
        }
        let middle = strip.first + rows / 2;
        let (mut low, line, mut high) = strip.cut(middle);
        let nodes = &*line.0;
        rayon::join(|| self.strip(low.lend(), [below, nodes]), || self.strip(high.lend(), [nodes, above]));
        self.move_nodes(middle, low.elements[low.elements.len() - 1].0, high.elements[0].0, line);
    }

    /// A block, row by row.
    fn rows(&self, RowBand { first, nodes, elements }: RowBand<'_, '_, S>, [below, above]: [&[S]; 2]) {
        let rows = elements.len();
        for at in 0..rows {
            let under = if at == 0 { below } else { &*nodes[at - 1].0 };
            let over = if at + 1 == rows { above } else { &*nodes[at].0 };
            self.load_elements(first + at, [under, over], &mut elements[at]);
            if at > 0 {
                self.move_nodes(first + at, elements[at - 1].0, elements[at].0, &mut nodes[at - 1]);
            }
        }
    }

    /// One row of elements, from the rows of nodes below and above it.
    fn load_elements(&self, row: usize, [below, above]: [&[S]; 2], (element, totals): &mut ElementLine<'_, S>) {
        totals.clear();
        let [rows, columns] = &self.elements;
        if !rows.contains(&row) {
            return;
        }
        totals.computed = columns.len();
        let (grid, ply_type) = (&self.model.grid, self.model.ply_type(self.ply));
        let (stride, ahead) = (grid.element_stride, [element.len(), below.len()]);
        let (element, more) = element.split_at_mut(element::COUNT * stride);
        let (more, strain) = more.split_at_mut(more.len() - element::STRAIN * stride);
        let (viscous, rate) = more.split_at_mut(more.len().min(element::VISCOUS * stride));
        let mut row = ElementRow {
            below: split(below, grid.node_stride),
            above: split(above, grid.node_stride),
            element: split_mut(element, stride),
            viscous: ply_type.viscous.then(|| split_mut(viscous, stride)),
            rate: ply_type.element.rate.is_some().then(|| split_mut(rate, stride)),
            strain: split_mut(strain, stride),
            height: ply_type.mesh.widths(row, 0)[1],
            width: &ply_type.columns.width,
            per_width: &ply_type.columns.per_width,
            law_energy: ply_type.law_energy.as_deref(),
            ahead,
            range: columns.clone(),
            dt: self.times[0],
            sample: self.sample,
        };
        self.kernels.elements(&mut row, totals);
    }

    /// One row of nodes, from the rows of elements below and above it.
    fn move_nodes(&self, row: usize, below: &[S], above: &[S], (node, totals): &mut NodeLine<'_, S>) {
        **totals = NodeTotals::default();
        if !self.nodes.rows.contains(&row) {
            return;
        }
        let (grid, ply_type) = (&self.model.grid, self.model.ply_type(self.ply));
        let m = ply_type.row_mass(row);
        let pass = NodePass {
            around: Neighbours { below: split(below, grid.element_stride), above: split(above, grid.element_stride) },
            inverse: [&m.inverse[0], &m.inverse[1], &m.inverse[2]],
            mass: &m.mass,
            range: self.nodes.columns.clone(),
            columns: ply_type.mesh.columns + 1,
            edge_row: row == 0 || row == ply_type.mesh.rows || !ply_type.mesh.frame.is_plain(),
            times: self.times,
            sample: self.sample,
            clay: self.model.clay(self.ply),
        };
        let (node, crater) = node.split_at_mut(field::COUNT * grid.node_stride);
        let [x, y, z, u, v, w] = split_mut(node, grid.node_stride);
        **totals = self.kernels.nodes(&pass, &mut [x, y, z, u, v, w, crater]);
    }
}

/// The kernels, row by row.
pub trait RowKernels<S: Scalar>: Send + Sync {
    /// Forces of a part of a row of elements; see [`element_force`].
    fn elements(&self, row: &mut ElementRow<'_, S>, totals: &mut ElementTotals);

    /// Motion of a part of a row of nodes; see [`node_update`].
    fn nodes(&self, pass: &NodePass<'_, S>, node: &mut NodeRow<'_, S>) -> NodeTotals;

    /// Candidates of a part of a search; see `broad_phase`.
    fn broad_phase(&self, part: &mut SearchPart<'_, S>);

    /// Impulses of contacts between plies on a row of nodes; see `ply_move`.
    fn ply_move(
        &self,
        row: &PushedRow<'_, S>,
        node: &mut [&mut [S]; field::COUNT],
        totals: &mut PlyMoveTotals,
    ) -> Range<usize>;
}

/// The kernels of a ply type: on numbers like `R`, in contact between plies on numbers like `P` and, in double precision, `D`.
struct Compiled<R: Real, P, D> {
    constants: ElementConstants<R>,
    shear: bool,
    contact: (P, D),
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
        broad_phase(self.contact, part);
    }

    fn ply_move(
        &self,
        row: &PushedRow<'_, R::Scalar>,
        node: &mut [&mut [R::Scalar]; field::COUNT],
        totals: &mut PlyMoveTotals,
    ) -> Range<usize> {
        ply_move(self.contact, row, node, totals)
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
                    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
                    Vectors::Wasm(simd) => compiled(ply_type, Self::lanes(simd), (Self::lanes(simd), 0.0)),
                }
            }
        }
    };
}

kernel_scalar!(f64);
kernel_scalar!(f32);

fn compiled<R, P, D>(ply_type: &PlyType<R::Scalar>, n: R, contact: (P, D)) -> Box<dyn RowKernels<R::Scalar>>
where
    R: Real + Send + Sync + 'static,
    P: Real<Scalar = R::Scalar> + Send + Sync + 'static,
    D: Real<Scalar = f64> + Send + Sync + 'static,
{
    let (constants, spread) = (ply_type.constants::<R::Scalar>(), |x| n.broadcast(x));
    let constants = constants.map(constants.cell.map(spread), spread);
    Box::new(Compiled { constants, shear: ply_type.has_shear, contact })
}

/// Does the work on this thread, while others that are awake stay so: one for each further band of a ply.
pub(super) fn beside_others<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let others = (rayon::current_num_threads() - 1).min(BANDS - 1);
    if others == 0 {
        return work();
    }
    let done = AtomicBool::new(false);
    rayon::scope(|scope| {
        for _ in 0..others {
            scope.spawn(|_| {
                while !done.load(Ordering::Acquire) {
                    std::thread::yield_now();
                }
            });
        }
        let _end = Raised(&done);
        work()
    })
}

/// Raises a flag at its end, whatever happens before.
struct Raised<'a>(&'a AtomicBool);

impl Drop for Raised<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
