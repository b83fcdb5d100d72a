//! The film of a run: few, coarse pictures of what is computed, for the playback and the maps of the report.
//!
//! Lines of nodes lie dense around the point of impact and sparse far from it; of a thick pack some plies are shown; of a scene
//! that is its own mirror image there is the part that is computed. Pictures are taken when frames are (`Schedule`), so that
//! they lie evenly over a run of any length. A checkpoint carries the film so far.

use std::collections::HashSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::surface::SurfaceMesh;
use crate::case::Case;
use crate::kernels::element_force::field as element;
use crate::kernels::node_update::field as node;
use crate::kernels::rigid_body::RigidBody;
use crate::math::scalar::Scalar;
use crate::model::{MirrorPlanes, Model};
use crate::run::frame::{Schedule, even};
use crate::run::pieces;
use crate::run::{Observer, View};
use crate::solver::state::State;

/// Pictures shown at most, the first and the last among them.
const PICTURES: usize = 61;
/// Nodes of a picture at most, about.
const NODES: usize = 5000;
/// Plies shown at most.
const PLIES: usize = 8;
/// Squared force of a yarn that is broken.
const BROKEN: f64 = -1.0;
/// Lines of nodes on either side of the point of impact that are all kept.
const DENSE: usize = 8;

/// A ply as the film shows it: cells between the lines of nodes that were kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AnimatedPly {
    /// Counted from the struck side.
    pub ply: usize,
    /// Nodes kept along the warp and along the weft, counted in the whole ply.
    pub lines: [Vec<usize>; 2],
    /// Elements of the whole ply along warp and weft.
    pub elements: [usize; 2],
    /// Line of nodes along the weft, and along the warp, nearest to the point of impact: among those kept.
    pub hit: [usize; 2],
    /// Reference positions of the nodes kept, in the axes of the pack, row by row [m].
    pub reference: Vec<[f32; 3]>,
    /// The lines, counted in the part that is computed.
    own: [Vec<usize>; 2],
}

/// All strips at one time; nodes and cells follow each other strip by strip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Keyframe {
    /// Steps done.
    pub step: u64,
    /// [s]
    pub time: f64,
    /// Largest deflection of each strip's ply, of fabric that hangs on something [m].
    pub deflections: Vec<f64>,
    /// Of the nodes [m].
    pub displacement: Vec<[f32; 3]>,
    /// Largest force of a yarn in a cell, as its elements carry it, warp and weft [N]; `None` where no yarn of that direction
    /// goes through the cell from end to end.
    pub tension: Vec<[Option<f32>; 2]>,
    /// Position of the projectile's centre of mass [m], and its turn as a quaternion w, x, y, z.
    pub pose: Option<[f64; 7]>,
}

impl Keyframe {
    /// Largest deflection of any ply shown, of fabric that hangs on something [m].
    pub fn deflection(&self) -> f64 {
        self.deflections.iter().copied().fold(0.0, f64::max)
    }
}

/// Pictures of a run.
#[derive(Clone, Debug)]
pub struct Animation {
    /// Plies shown, the struck one first; none before the first picture.
    pub strips: Vec<AnimatedPly>,
    /// Plies there are.
    pub plies: usize,
    /// In order of time.
    pub stills: Vec<Keyframe>,
    /// Mirror planes: shown is the part at x ≥ 0, y ≥ 0.
    pub planes: MirrorPlanes,
    /// Surface of the projectile.
    pub(super) body: Option<SurfaceMesh>,
    /// Where the projectile strikes [m].
    hit: [f64; 2],
    /// When pictures are due.
    schedule: Schedule,
    /// The strips are those of the model; not known of a film from a checkpoint before its next picture.
    begun: bool,
}

impl Animation {
    /// An empty film of a case.
    pub fn new(case: &Case) -> Self {
        Self {
            strips: Vec::new(),
            plies: 0,
            stills: Vec::new(),
            planes: MirrorPlanes::NONE,
            body: None,
            hit: case.projectile.as_ref().map_or([0.0; 2], |p| p.offset),
            schedule: Schedule::new(PICTURES, case.solver.end_time),
            begun: false,
        }
    }

    /// What a checkpoint carries of it.
    pub fn to_bytes(&self) -> Vec<u8> {
        // Writing to memory cannot fail.
        postcard::to_stdvec(&(&self.strips, self.plies, &self.stills, self.planes, &self.body)).unwrap_or_default()
    }

    /// The film of a run that goes on before the step of this number, `dt` [s] long, from what a checkpoint carries; `None` where
    /// that is no film.
    pub fn resume(case: &Case, bytes: &[u8], step: u64, dt: f64) -> Option<Self> {
        let (strips, plies, mut stills, planes, body) = postcard::from_bytes(bytes).ok()?;
        let schedule = Schedule::resume(PICTURES, case.solver.end_time, step, dt);
        keep(&mut stills, &schedule);
        let film = Self { strips, plies, stills, planes, body, schedule, ..Self::new(case) };
        film.is_sound().then_some(film)
    }

    /// Whether all parts have the sizes that they need to have.
    fn is_sound(&self) -> bool {
        let nodes: usize = self.strips.iter().map(|strip| strip.reference.len()).sum();
        let cells: usize = self.strips.iter().map(AnimatedPly::cells).sum();
        let whole = |still: &Keyframe| {
            still.displacement.len() == nodes
                && still.tension.len() == cells
                && still.deflections.len() == self.strips.len()
        };
        self.body.as_ref().is_none_or(SurfaceMesh::is_sound)
            && self.strips.iter().all(AnimatedPly::is_sound)
            && self.stills.iter().all(whole)
            && self.stills.windows(2).all(|pair| pair[0].time < pair[1].time)
    }

    fn take_from(&mut self, view: &View<'_>) {
        match view {
            View::Double(model, state) => self.take(model, state),
            View::Single(model, state) => self.take(model, state),
        }
    }

    fn take<S: Scalar>(&mut self, model: &Model<S>, state: &State<S>) {
        if !self.begun {
            self.begin(model);
        }
        let time = state.step as f64 * model.dt;
        if self.stills.last().is_some_and(|last| last.time >= time) {
            return; // the end of the run was due anyway
        }
        let [nodes, cells] = [|strip: &AnimatedPly| strip.reference.len(), AnimatedPly::cells]
            .map(|count| self.strips.iter().map(count).sum());
        let deflections = self.strips.par_iter().map(|strip| pieces::hanging(model, state, strip.ply).deflection);
        let mut still = Keyframe {
            step: state.step,
            time,
            deflections: deflections.collect(),
            displacement: vec![[0.0; 3]; nodes],
            tension: vec![[None; 2]; cells],
            pose: state.body.as_ref().map(pose),
        };
        let (mut displacement, mut tension) = (&mut still.displacement[..], &mut still.tension[..]);
        let (mut node_rows, mut cell_rows) = (Vec::new(), Vec::new());
        for strip in &self.strips {
            let (own, rest) = displacement.split_at_mut(strip.reference.len());
            let nodes = own.chunks_mut(strip.own[0].len().max(1));
            node_rows.extend(strip.own[1].iter().zip(nodes).map(|(row, nodes)| (strip, *row, nodes)));
            displacement = rest;
            let (own, rest) = tension.split_at_mut(strip.cells());
            let cells = own.chunks_mut(strip.counts()[0].max(1));
            cell_rows.extend(strip.own[1].windows(2).zip(cells).map(|(rows, cells)| (strip, rows, cells)));
            tension = rest;
        }
        // This reads all elements, and the threads of the loop wait meanwhile.
        cell_rows.into_par_iter().for_each(|(strip, rows, cells)| strip.tensions(model, state, rows, cells));
        node_rows.into_par_iter().for_each(|(strip, row, nodes)| strip.displacements(model, state, row, nodes));
        self.stills.push(still);
    }

    fn begin<S: Scalar>(&mut self, model: &Model<S>) {
        self.begun = true;
        self.plies = model.plies.len();
        let shown = shown(self.plies);
        let nodes = NODES / shown.len().max(1);
        let strips: Vec<AnimatedPly> = shown.iter().map(|ply| AnimatedPly::new(model, *ply, self.hit, nodes)).collect();
        if strips != self.strips {
            self.stills.clear(); // of another model
        }
        self.strips = strips;
        self.planes = model.planes;
        let pack = self.strips.iter().flat_map(|strip| &strip.reference);
        self.body = model.projectile.as_ref().map(|projectile| SurfaceMesh::new(&projectile.body, pack));
    }

    /// The same with at most so many pictures, evenly from the first to the last.
    #[must_use]
    pub(super) fn with(&self, pictures: usize) -> Self {
        let times: Vec<f64> = self.stills.iter().map(|still| still.time).collect();
        let stills = even(&times, pictures).into_iter().map(|at| self.stills[at].clone()).collect();
        Self { stills, ..self.clone() }
    }

    /// The pictures that a page shows: evenly from the first to the last.
    #[must_use]
    pub fn shown(&self) -> Self {
        self.with(PICTURES)
    }

    /// Largest deflection in any picture, of fabric that hangs on something [m].
    pub fn deflection(&self) -> f64 {
        self.stills.iter().map(Keyframe::deflection).fold(0.0, f64::max)
    }

    /// The picture of the largest deflection among those in which the projectile has not left the fabric behind.
    pub fn opening(&self) -> usize {
        let is_near = |still: &Keyframe| still.pose.is_none_or(|pose| self.tail(&pose) <= still.deflection());
        let near = (0..self.stills.len()).filter(|at| is_near(&self.stills[*at]));
        let deflection = |at: usize| self.stills[at].deflection();
        near.max_by(|a, b| deflection(*a).total_cmp(&deflection(*b))).unwrap_or(0)
    }

    /// How far the last part of the projectile has come, along the normal of the pack [m].
    fn tail(&self, [_, _, height, w, x, y, z]: &[f64; 7]) -> f64 {
        let normal = [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)];
        let points = self.body.iter().flat_map(|body| &body.points);
        let heights = points.map(|point| (0..3).map(|axis| normal[axis] * point[axis]).sum::<f64>());
        height + heights.fold(0.0, f64::min)
    }

    /// Largest tension in any picture [N].
    pub fn peak_tension(&self) -> f32 {
        let all = self.stills.iter().flat_map(|still| &still.tension).flatten();
        all.flatten().copied().filter(|tension| tension.is_finite()).fold(0.0, f32::max)
    }
}

impl Observer for Animation {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.schedule.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.take_from(view);
        self.schedule.pass(view.step(), view.clock()[1]);
        keep(&mut self.stills, &self.schedule);
    }

    fn on_end(&mut self, view: &View<'_>) {
        // The last picture is that of the end, not of the step before.
        if !self.schedule.wants_end(view.step()) {
            self.stills.pop();
        }
        self.take_from(view);
    }
}

/// Gives up the pictures that the schedule has given up.
fn keep(stills: &mut Vec<Keyframe>, schedule: &Schedule) {
    let kept: HashSet<u64> = schedule.kept().collect();
    stills.retain(|still| kept.contains(&still.step));
}

fn pose(body: &RigidBody) -> [f64; 7] {
    let (at, q) = (body.position, body.orientation.quaternion());
    [at.x, at.y, at.z, q.w, q.i, q.j, q.k]
}

/// Plies to show, evenly from the first to the last.
pub(super) fn shown(plies: usize) -> Vec<usize> {
    if plies <= PLIES {
        return (0..plies).collect();
    }
    (0..PLIES).map(|n| (n * (plies - 1) + (PLIES - 1) / 2) / (PLIES - 1)).collect()
}

impl AnimatedPly {
    fn new<S: Scalar>(model: &Model<S>, ply: usize, hit: [f64; 2], most: usize) -> Self {
        let mesh = &model.ply_type(ply).mesh;
        let place = mesh.to_ply([hit[0], hit[1], 0.0]);
        let (counts, first) = ([mesh.columns, mesh.rows], mesh.first_in_whole());
        let side = (most as f64).sqrt() as usize;
        let axis = |own: usize| KeptLines { last: counts[own], hit: mesh.nearest_line(own, place[own]) };
        let own = [0, 1].map(|a| axis(a).lines(side));
        let whole = [0, 1].map(|a| own[a].iter().map(|line| line + first[a]).collect());
        let reference = own[1].iter().flat_map(|row| own[0].iter().map(move |column| (*row, *column)));
        Self {
            ply,
            elements: mesh.whole_counts(),
            hit: [0, 1].map(|a| own[a].partition_point(|line| *line < axis(a).hit)),
            reference: reference.map(|(row, column)| model.reference(ply, row, column).map(|x| x as f32)).collect(),
            lines: whole,
            own,
        }
    }

    /// A row of nodes at these places.
    #[cfg(test)]
    pub(super) fn for_tests(reference: Vec<[f32; 3]>) -> Self {
        let lines: [Vec<usize>; 2] = [(0..reference.len()).collect(), vec![0]];
        Self { ply: 0, elements: [reference.len(), 1], hit: [0; 2], reference, own: lines.clone(), lines }
    }

    /// Whether lists that belong together are of one length, and all places are within them.
    fn is_sound(&self) -> bool {
        let [columns, rows] = [0, 1].map(|a| self.lines[a].len());
        self.reference.len() == columns * rows
            && (0..2).all(|a| self.own[a].len() == self.lines[a].len() && self.hit[a] < self.lines[a].len())
            && (0..2).all(|a| self.lines[a].last().is_some_and(|last| *last <= self.elements[a]))
            && self.lines.iter().all(|lines| lines.is_sorted())
    }

    /// Cells along warp and weft.
    pub fn counts(&self) -> [usize; 2] {
        [0, 1].map(|own| self.own[own].len().saturating_sub(1))
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        let [columns, rows] = self.counts();
        columns * rows
    }

    /// Displacements of the nodes kept of a row.
    fn displacements<S: Scalar>(&self, model: &Model<S>, state: &State<S>, row: usize, out: &mut [[f32; 3]]) {
        let mesh = &model.ply_type(self.ply).mesh;
        let row = state.nodes.row(model.grid.first_node_row(self.ply) + row);
        let [x, y, z] = [0, 1, 2].map(|a| &row[(node::DISPLACEMENT + a) * state.nodes.stride..]);
        for (column, out) in self.own[0].iter().zip(out) {
            *out = mesh.to_pack([x, y, z].map(|u| u[*column].to_f64())).map(|u| u as f32);
        }
    }

    /// Tensions in a row of cells, between two rows of nodes.
    fn tensions<S: Scalar>(&self, model: &Model<S>, state: &State<S>, rows: &[usize], cells: &mut [[Option<f32>; 2]]) {
        // From the force of an element to that of one of its yarns.
        let per_yarn = model.ply_type(self.ply).element.membrane.map(|membrane| (1.0 / membrane) as f32);
        let first = model.grid.first_element_row(self.ply);
        let columns = self.own[0].last().map_or(0, |last| *last);
        let mut most = vec![[BROKEN; 2]; cells.len()];
        // A warp yarn goes through a cell along a row of elements, a weft yarn along a column.
        let mut wefts = vec![0.0; columns];
        for row in rows[0]..rows[1] {
            let [warps, here] = squares(state.elements.row(first + row), state.elements.stride, columns);
            for (cell, span) in most.iter_mut().zip(self.own[0].windows(2)) {
                cell[0] = warps[span[0]..span[1]].iter().copied().fold(0.0, end_to_end).max(cell[0]);
            }
            wefts.iter_mut().zip(here).for_each(|(all, one)| *all = end_to_end(*all, one));
        }
        for (cell, span) in most.iter_mut().zip(self.own[0].windows(2)) {
            cell[1] = wefts[span[0]..span[1]].iter().copied().fold(BROKEN, f64::max);
        }
        for (cell, squares) in cells.iter_mut().zip(most) {
            let tension = |yarn: usize| per_yarn[yarn] * squares[yarn].sqrt() as f32;
            *cell = [0, 1].map(|yarn| (squares[yarn] != BROKEN).then(|| tension(yarn)));
        }
    }
}

/// Squared force of the yarns in a row of elements, warp and weft [N²].
fn squares<S: Scalar>(row: &[S], stride: usize, columns: usize) -> [Vec<f64>; 2] {
    [element::WARP_FORCE, element::WEFT_FORCE].map(|force| {
        // Element c is at c + 1.
        let field = |field: usize| &row[field * stride + 1..field * stride + 1 + columns];
        let yarn = usize::from(force == element::WEFT_FORCE);
        let [x, y, z] = [force, force + 1, force + 2].map(field);
        let forces = field(element::ALIVE + yarn).iter().zip(x).zip(y.iter().zip(z));
        let square = |((alive, x), (y, z)): ((&S, &S), (&S, &S))| {
            let [x, y, z] = [x, y, z].map(|force| force.to_f64());
            if alive.to_f64() > 0.5 { x * x + y * y + z * z } else { BROKEN }
        };
        forces.map(square).collect()
    })
}

/// The larger of two squared forces along a yarn; a yarn that is broken in one place is broken. What is no number counts as none.
fn end_to_end(one: f64, other: f64) -> f64 {
    if one == BROKEN || other == BROKEN { BROKEN } else { one.max(other) }
}

/// Nodes of a ply along one of its own axes.
#[derive(Clone, Copy)]
struct KeptLines {
    last: usize,
    /// Nearest to the point of impact.
    hit: usize,
}

impl KeptLines {
    /// Lines to keep, at most so many: gaps grow with the distance from the point of impact as little as need be.
    fn lines(self, most: usize) -> Vec<usize> {
        let growths = (0..).map(|n| 0.02 * f64::from(n));
        let found = growths.map(|growth| self.graded(growth)).find(|lines| lines.len() <= most.max(2 * DENSE + 8));
        found.unwrap_or_default()
    }

    fn graded(self, growth: f64) -> Vec<usize> {
        let (first, last) = (0, self.last);
        let gap = |at: usize| 1 + (growth * at.abs_diff(self.hit).saturating_sub(DENSE) as f64) as usize;
        let next = |at: &usize, end: usize| {
            (*at != end).then(|| {
                let step = gap(*at).min(at.abs_diff(end));
                if end > *at { at + step } else { at - step }
            })
        };
        let down = std::iter::successors(Some(self.hit), |at| next(at, first)).skip(1);
        let up = std::iter::successors(Some(self.hit), |at| next(at, last));
        let mut lines: Vec<usize> = down.chain(up).collect();
        lines.sort_unstable();
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_dense_around_the_impact_and_end_at_the_edges() {
        let axis = KeptLines { last: 160, hit: 80 };
        assert_eq!(axis.lines(161).len(), 161);
        let few = axis.lines(60);
        assert!(few.len() <= 60 && few.len() > 50, "{}", few.len());
        assert_eq!((few[0], few[few.len() - 1]), (0, 160));
        let dense = few.iter().filter(|line| line.abs_diff(80) <= DENSE).count();
        assert_eq!(dense, 2 * DENSE + 1);
        assert!(few.windows(2).all(|pair| pair[0] < pair[1]));
        let half = KeptLines { last: 80, hit: 0 }.lines(30);
        assert_eq!((half[0], half[half.len() - 1]), (0, 80));
    }

    fn case() -> Case {
        let text = r#"{"title": "t", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 20, "height_mm": 20},
            "solver": {"end_time_us": 1}}"#;
        crate::case::from_str("shot", text, &[]).unwrap_or_else(|error| unreachable!("{error}"))
    }

    fn still(step: u64) -> Keyframe {
        Keyframe {
            step,
            time: step as f64,
            deflections: vec![0.0],
            displacement: vec![[1.0; 3]; 4],
            tension: Vec::new(),
            pose: None,
        }
    }

    #[test]
    fn a_film_opens_at_the_largest_deflection_that_the_projectile_is_near() {
        let mut film = Animation::new(&case());
        let of = |(step, [deflection, height]): (u64, [f64; 2])| {
            let pose = Some([0.0, 0.0, height, 1.0, 0.0, 0.0, 0.0]);
            Keyframe { deflections: vec![0.0, deflection], pose, ..still(step) }
        };
        film.stills = (0..).zip([[0.0, 0.0], [2.0, 1.0], [3.0, 3.5], [4.0, 9.0]]).map(of).collect();
        assert_eq!(film.opening(), 1);
        // A body that reaches 1 m back from its centre of mass.
        let body = SurfaceMesh { points: vec![[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], faces: Vec::new() };
        film.body = Some(body);
        assert_eq!(film.opening(), 2);
    }

    #[test]
    fn what_is_no_film_is_not_taken_for_one() {
        let case = case();
        let mut film = Animation::new(&case);
        film.strips = vec![AnimatedPly::for_tests(vec![[0.0; 3]; 4])];
        film.stills = vec![still(0), still(1)];
        let resume = |bytes: &[u8]| Animation::resume(&case, bytes, 2, 1e-7);
        let taken = |film: &Animation| resume(&film.to_bytes()).map(|film| film.stills);
        assert_eq!(taken(&film), Some(film.stills.clone()));
        for length in 0..film.to_bytes().len() {
            assert!(resume(&film.to_bytes()[..length]).is_none(), "{length} bytes");
        }
        let wrong: [fn(&mut Animation); 6] = [
            |film| film.stills[0].deflections.clear(),
            |film| film.stills[1].time = 0.0,
            |film| film.stills[1].displacement.truncate(3),
            |film| film.stills[0].tension.push([None; 2]),
            |film| film.strips[0].hit[1] = 1,
            |film| film.body = Some(SurfaceMesh::one_face_of_no_points()),
        ];
        for change in wrong {
            let mut film = film.clone();
            change(&mut film);
            assert_eq!(taken(&film), None);
        }
    }

    #[test]
    fn a_yarn_that_is_broken_in_one_place_is_broken_from_end_to_end() {
        let along = |squares: &[f64]| squares.iter().copied().fold(0.0, end_to_end);
        assert_eq!(along(&[4.0, 9.0, f64::NAN]), 9.0);
        assert_eq!(along(&[4.0, BROKEN, 9.0]), BROKEN);
    }

    #[test]
    fn first_and_last_of_many_plies_are_shown() {
        assert_eq!(shown(3), [0, 1, 2]);
        assert_eq!(shown(50), [0, 7, 14, 21, 28, 35, 42, 49]);
        for plies in 9..65 {
            let shown = shown(plies);
            assert!(shown.len() == PLIES && shown[0] == 0 && shown[PLIES - 1] == plies - 1, "{plies}");
            assert!(shown.windows(2).all(|pair| pair[0] < pair[1]), "{plies}");
        }
    }
}
