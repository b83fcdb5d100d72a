//! Frames for ParaView: `frames.pvd` and a `.vtu` file for every part and frame, XML with the numbers appended, compressed by zlib.
//!
//! The thread of the solver only copies what has moved. Frames wait in memory until the run is over; what has no room there waits on
//! the disk as the files that it will be, and of a run with checkpoints all of them do, for the run that goes on.
//!
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>. Lengths in mm, so that the axes of a view read like
//! a drawing; every array ends in its unit.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use flate2::{Compression, write::ZlibEncoder};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rayon::prelude::*;

use super::folder::{ANOTHER, FRAMES, Folder, PVD, SPOOL, StagedFrames, write_whole};
use super::surface::SurfaceMesh;
use crate::case::{Case, CaseError, FRAMES_BYTES};
use crate::physics::projectile_body::Body;
use crate::physics::rigid_body::RigidBody;
use crate::run::checkpoint::Header;
use crate::run::frame::{Frame, FrameCollector, Scene};
use crate::run::{Observer, Snapshot, View};

/// Recorder of the frames of a run that it follows, which it writes when the run is over.
pub struct Recorder<'a> {
    folder: &'a Folder,
    case: &'a Case,
    frames: FrameCollector,
    /// The run leaves checkpoints, the last of which may need what is dropped.
    checkpoints: bool,
    /// The folder of waiting files is this run's.
    begun: bool,
    /// Reason why frames are lost.
    error: Option<CaseError>,
}

impl<'a> Recorder<'a> {
    /// Recorder of the frames that a case asks for. `checkpoints`: the run leaves some.
    pub fn new(folder: &'a Folder, case: &'a Case, checkpoints: bool) -> Self {
        let frames = FrameCollector::new(case, case.output.frames as usize);
        Self { folder, case, frames, checkpoints, begun: false, error: None }
    }

    /// Recorder of a run that goes on from the checkpoint with this header, with the frames beside it.
    ///
    /// # Errors
    /// When one of them is missing.
    pub fn resume(folder: &'a Folder, case: &'a Case, header: &Header) -> Result<Self, CaseError> {
        let mut new = Self { begun: true, ..Self::new(folder, case, true) };
        new.frames = FrameCollector::resume(case, case.output.frames as usize, header.step, header.time_step);
        let files = new.frames.taken.keys().flat_map(|step| parts(case).iter().map(|part| new.waiting(part, *step)));
        match files.into_iter().find(|path| !path.is_file()) {
            Some(path) => Err(CaseError::of_path(&path, "a frame of the checkpoint", "none", "run the case again")),
            None => Ok(new),
        }
    }

    /// File that waits, of a part of the frame before a step.
    fn waiting(&self, part: &str, step: u64) -> PathBuf {
        self.folder.path().join(SPOOL).join(format!("{part}_{step:08}.vtu"))
    }

    /// Moves the frames in memory to the disk, where a run that goes on finds them. What is refused ends the recording.
    pub fn settle(&mut self) {
        if let Err(error) = self.put() {
            let path = self.folder.path().join(PVD);
            self.error = Some(CaseError::of_path(&path, "a disk that takes the frames", error, ANOTHER));
            // Memory would not hold them, and the disk has more to take.
            self.frames.taken.clear();
            fs::remove_dir_all(self.folder.path().join(SPOOL)).ok();
        }
    }

    fn put(&mut self) -> io::Result<()> {
        let mut new: Vec<(u64, Snapshot)> =
            self.frames.taken.iter_mut().filter_map(|(step, (_, snapshot))| Some((*step, snapshot.take()?))).collect();
        if new.is_empty() {
            return Ok(());
        }
        self.folder.check_identity().map_err(|error| io::Error::other(error.found))?;
        let spool = self.folder.path().join(SPOOL);
        if !std::mem::replace(&mut self.begun, true) && spool.is_dir() {
            fs::remove_dir_all(&spool)?; // of an earlier run
        }
        fs::create_dir_all(&spool)?;
        let write = |(step, snapshot): (u64, Snapshot)| {
            let (scene, frame) = (snapshot.scene(), snapshot.frame());
            parts(self.case).iter().try_for_each(|part| {
                let text = if *part == FABRIC { fabric(scene, &frame)? } else { projectile(self.case, scene, &frame)? };
                write_whole(&self.waiting(part, step), |file| file.write_all(&text))
            })
        };
        // A frame takes many times the memory of a snapshot.
        while !new.is_empty() {
            let some = new.drain(..new.len().min(self.case.frames_at_once()));
            some.collect::<Vec<_>>().into_par_iter().try_for_each(write)?;
        }
        Ok(())
    }

    /// Removes the files of dropped frames. Of a run with checkpoints the last one may need them until there is another.
    pub fn discard(&self) {
        let is_kept = |name: &str| self.frames.taken.keys().any(|step| name.ends_with(&format!("_{step:08}.vtu")));
        for file in fs::read_dir(self.folder.path().join(SPOOL)).into_iter().flatten().flatten() {
            if !is_kept(&file.file_name().to_string_lossy()) {
                fs::remove_file(file.path()).ok(); // what stays there goes with the folder
            }
        }
    }

    /// The frames asked for, as complete files.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn finish(mut self) -> Result<StagedFrames, CaseError> {
        let chosen = self.frames.chosen();
        self.frames.taken.retain(|step, _| chosen.binary_search(step).is_ok());
        self.settle();
        if let Some(error) = self.error {
            return Err(error);
        }
        let mut staged = StagedFrames::default();
        let mut entries = String::new();
        for (frame, (step, (time, _))) in self.frames.taken.iter().enumerate() {
            for (number, part) in parts(self.case).iter().enumerate() {
                let (name, time) = (format!("{part}_{frame:04}.vtu"), time * 1e6);
                entries += &format!(
                    "<DataSet timestep=\"{time}\" part=\"{number}\" name=\"{part}\" file=\"{FRAMES}/{name}\"/>\n"
                );
                staged.files.push((self.waiting(part, *step), name));
            }
        }
        staged.list = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"{BYTE_ORDER}\">\n\
             <!-- time in µs -->\n<Collection>\n{entries}</Collection>\n</VTKFile>\n"
        );
        Ok(staged)
    }
}

impl Observer for Recorder<'_> {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.error.is_none() && self.frames.snapshot_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.frames.on_snapshot(view);
        if self.begun && !self.checkpoints {
            self.discard();
        }
        let in_memory = self.frames.taken.values().filter_map(|(_, snapshot)| snapshot.as_ref());
        if in_memory.map(|snapshot| snapshot.bytes).sum::<usize>() > FRAMES_BYTES {
            self.settle();
        }
    }

    fn on_end(&mut self, view: &View<'_>) {
        if self.error.is_none() {
            self.frames.on_end(view);
        }
    }
}

const BYTE_ORDER: &str = if cfg!(target_endian = "big") { "BigEndian" } else { "LittleEndian" };
/// `VTK_QUAD` and `VTK_TRIANGLE`.
const QUAD: u8 = 9;
const TRIANGLE: u8 = 5;
/// `vtkDataSetAttributes::HIDDENCELL`: not drawn, and left out by filters.
const HIDDEN: u8 = 32;
/// mm per m.
const MM: f64 = 1e3;

/// Part of the plies.
const FABRIC: &str = "fabric";

/// Names of the parts of a case.
fn parts(case: &Case) -> &'static [&'static str] {
    if case.projectile.is_some() { &[FABRIC, "projectile"] } else { &[FABRIC] }
}

/// Named numbers, compressed.
struct Array {
    name: &'static str,
    kind: &'static str,
    /// Numbers per point or cell.
    components: usize,
    /// Points or cells.
    count: usize,
    block: Vec<u8>,
}

impl Array {
    fn new<T: bytemuck::NoUninit>(
        name: &'static str,
        kind: &'static str,
        components: usize,
        numbers: &[T],
    ) -> io::Result<Self> {
        let block = compressed(bytemuck::cast_slice(numbers))?;
        Ok(Self { name, kind, components, count: numbers.len() / components, block })
    }

    fn bytes(name: &'static str, numbers: &[u8]) -> io::Result<Self> {
        Self::new(name, "UInt8", 1, numbers)
    }

    fn floats(name: &'static str, numbers: &[f32], unit: f64) -> io::Result<Self> {
        let numbers: Vec<f32> = numbers.iter().map(|number| (f64::from(*number) * unit) as f32).collect();
        Self::new(name, "Float32", 1, &numbers)
    }

    fn vectors(name: &'static str, vectors: impl Iterator<Item = [f64; 3]>) -> io::Result<Self> {
        let numbers: Vec<f32> = vectors.flat_map(|vector| vector.map(|number| number as f32)).collect();
        Self::new(name, "Float32", 3, &numbers)
    }
}

/// Header and compressed bytes of an array, which is one block.
fn compressed(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(vec![0; 32], Compression::fast());
    encoder.write_all(bytes)?;
    let mut out = encoder.finish()?;
    // Blocks, bytes of a block, of the last one if that is shorter, and compressed.
    let header = [u64::from(!bytes.is_empty()), bytes.len() as u64, 0, (out.len() - 32) as u64];
    out[..32].copy_from_slice(bytemuck::cast_slice(&header));
    out.truncate(if bytes.is_empty() { 24 } else { out.len() });
    Ok(out)
}

/// The file of a part at a time [s]: points, corners of the cells, arrays of points and of cells.
fn file(
    time: f64,
    points: Array,
    cells: impl Iterator<Item = impl AsRef<[usize]>>,
    of_points: Vec<Array>,
    of_cells: Vec<Array>,
) -> io::Result<Vec<u8>> {
    let (mut corners, mut ends, mut kinds) = (Vec::new(), Vec::new(), Vec::new());
    for cell in cells {
        corners.extend(cell.as_ref().iter().map(|corner| *corner as i64));
        ends.push(corners.len() as i64);
        kinds.push(if cell.as_ref().len() == 3 { TRIANGLE } else { QUAD });
    }
    let topology = vec![
        Array::new("connectivity", "Int64", 1, &corners)?,
        Array::new("offsets", "Int64", 1, &ends)?,
        Array::bytes("types", &kinds)?,
    ];
    let (point_count, cell_count, time_us) = (points.count, kinds.len(), time * 1e6);
    let sections = [("Points", vec![points]), ("Cells", topology), ("PointData", of_points), ("CellData", of_cells)];
    let (mut xml, mut blocks) = (String::new(), Vec::new());
    for (section, arrays) in sections {
        xml += &format!("<{section}>\n");
        for Array { name, kind, components, block, .. } in arrays {
            xml += &format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{}\"/>\n",
                blocks.len()
            );
            blocks.extend(block);
        }
        xml += &format!("</{section}>\n");
    }
    let head = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{BYTE_ORDER}\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time_us}</DataArray>\n\
         </FieldData>\n<Piece NumberOfPoints=\"{point_count}\" NumberOfCells=\"{cell_count}\">\n{xml}</Piece>\n</UnstructuredGrid>\n\
         <AppendedData encoding=\"raw\">\n_"
    );
    Ok([head.as_bytes(), &blocks, b"\n</AppendedData>\n</VTKFile>\n"].concat())
}

fn fabric(scene: &Scene, frame: &Frame) -> io::Result<Vec<u8>> {
    let cells = scene.plies.iter().flat_map(|ply| {
        (0..ply.rows).flat_map(move |row| (0..ply.columns).map(move |column| ply.corners(row, column)))
    });
    let plies = scene.plies.iter().enumerate().flat_map(|(n, ply)| std::iter::repeat_n(n as u8, ply.elements()));
    let moved = scene.reference.iter().zip(&frame.displacement);
    let moved = moved.map(|(x, u)| [0, 1, 2].map(|a| (f64::from(x[a]) + f64::from(u[a])) * MM));
    let [warp, weft] = &frame.alive;
    let hidden = warp.iter().zip(weft).map(|(warp, weft)| if warp | weft == 0 { HIDDEN } else { 0 });
    let of_points = vec![
        Array::vectors("displacement_mm", frame.displacement.iter().map(|u| u.map(|u| f64::from(u) * MM)))?,
        Array::vectors("velocity_m_s", frame.velocity.iter().map(|v| v.map(f64::from)))?,
    ];
    let of_cells = vec![
        Array::bytes("ply", &plies.collect::<Vec<_>>())?,
        Array::floats("warp_tension_n", &frame.tension[0], 1.0)?,
        Array::floats("weft_tension_n", &frame.tension[1], 1.0)?,
        Array::floats("warp_strain", &frame.strain[0], 1.0)?,
        Array::floats("weft_strain", &frame.strain[1], 1.0)?,
        Array::floats("warp_crimp_height_mm", &frame.height[0], MM)?,
        Array::floats("weft_crimp_height_mm", &frame.height[1], MM)?,
        Array::floats("shear_angle_rad", &frame.shear_angle, 1.0)?,
        Array::bytes("warp_alive", warp)?,
        Array::bytes("weft_alive", weft)?,
        Array::bytes("vtkGhostType", &hidden.collect::<Vec<_>>())?,
    ];
    file(frame.time, Array::vectors("Points", moved)?, cells, of_points, of_cells)
}

fn projectile(case: &Case, scene: &Scene, frame: &Frame) -> io::Result<Vec<u8>> {
    let start = case.projectile.as_ref().and_then(|of| Some(RigidBody::new(of, Body::new(of)?, 0.0)));
    let (Some(start), Some(pose)) = (start, &frame.projectile) else { return Err(io::ErrorKind::NotFound.into()) };
    let surface = SurfaceMesh::new(&start.body, scene.reference.iter());
    let [w, x, y, z] = pose.rotation;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    let [centre, velocity, spin] = [pose.position, pose.velocity, pose.angular_velocity].map(Vector3::from);
    let arms = || surface.points.iter().map(|point| Vector3::from(*point));
    let at = |arm: Vector3<f64>| centre + rotation * arm;
    let moved = |arm: Vector3<f64>| at(arm) - (start.position + start.orientation * arm);
    let of_points = vec![
        Array::vectors("displacement_mm", arms().map(|arm| (moved(arm) * MM).into()))?,
        Array::vectors("velocity_m_s", arms().map(|arm| (velocity + spin.cross(&(rotation * arm))).into()))?,
    ];
    let points = Array::vectors("Points", arms().map(|arm| (at(arm) * MM).into()))?;
    file(frame.time, points, surface.faces.iter(), of_points, Vec::new())
}
