//! `frames.vtkhdf`: all frames in one file, a VTKHDF collection of named parts.
//!
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/>. Cells are written once; every step says where its
//! points and arrays begin. Each of those is one chunk, written when its frame comes; what is known at the end only is
//! written there.
//!
//! The collection is a multi-block one with its own list of times: of all kinds of collections, VTK 9.7's reader gets the steps
//! of this one right however it is asked.

use std::io::{self, Write};
use std::path::Path;

use flate2::{Compression, write::ZlibEncoder};
use rust_hdf5::{DatatypeMessage, H5Dataset, H5File, H5Group, H5Type, Result};

use super::parts::{Array, PartArray, PartFrame, PartGrid};

/// Version of the format that has collections.
const VERSION: [i64; 2] = [2, 1];
/// Compression: more takes longer and gains nothing to speak of.
const LEVEL: u32 = 1;

/// A file in the making.
pub(super) struct HdfFile {
    /// `None` once it is closed.
    file: Option<H5File>,
    root: H5Group,
    parts: Vec<HdfPart>,
    /// [µs]
    times: Vec<f64>,
}

struct HdfPart {
    group: H5Group,
    points: StepCounts,
    of_points: Vec<StepCounts>,
    of_cells: Vec<StepCounts>,
    /// Arrays that do not change; of cells.
    fixed: Vec<&'static str>,
}

/// Numbers of points or cells, step after step.
struct StepCounts {
    name: &'static str,
    data: H5Dataset,
    /// Points or cells.
    count: usize,
    components: usize,
}

impl HdfFile {
    /// A file with everything that does not change. `first`: the parts of the first frame, for the names of their arrays.
    pub(super) fn create(path: &Path, grids: &[PartGrid], first: &[PartFrame]) -> Result<Self> {
        let file = H5File::create(path)?;
        match Self::begin(&file, grids, first) {
            Ok((root, parts)) => Ok(Self { file: Some(file), root, parts, times: Vec::new() }),
            Err(error) => {
                give_up(file);
                Err(error)
            }
        }
    }

    /// Everything that does not change.
    fn begin(file: &H5File, grids: &[PartGrid], first: &[PartFrame]) -> Result<(H5Group, Vec<HdfPart>)> {
        file.set_track_order(true)?;
        let root = file.create_group("VTKHDF")?;
        label(&root, "MultiBlockDataSet")?;
        let assembly = root.create_group("Assembly")?;
        let mut parts = Vec::with_capacity(grids.len());
        for (grid, part) in grids.iter().zip(first) {
            let group = root.create_group(grid.name)?;
            label(&group, "UnstructuredGrid")?;
            assembly.create_soft_link(grid.name, &format!("/VTKHDF/{}", grid.name))?;
            parts.push(HdfPart::create(group, grid, part)?);
        }
        Ok((root, parts))
    }

    /// Adds a frame.
    pub(super) fn add(&mut self, time_us: f64, parts: &[PackedPart]) -> Result<()> {
        let step = self.times.len();
        for (own, part) in self.parts.iter().zip(parts) {
            let series = [&own.points].into_iter().chain(&own.of_points).chain(&own.of_cells);
            series.zip(&part.0).try_for_each(|(series, chunk)| series.data.write_chunk_raw(step, chunk, 0))?;
        }
        self.times.push(time_us);
        Ok(())
    }

    /// Completes the file.
    pub(super) fn close(mut self) -> Result<()> {
        list_times(&self.root, &self.times)?;
        for part in &self.parts {
            part.finish(&self.times)?;
        }
        self.file.take().map_or(Ok(()), H5File::close)
    }
}

impl Drop for HdfFile {
    fn drop(&mut self) {
        self.file.take().into_iter().for_each(give_up);
    }
}

/// Closes a file that nobody will read. Left to itself the library would say on standard error that the disk refuses it, which the user
/// is told otherwise.
fn give_up(file: H5File) {
    file.close_no_sync().ok();
}

impl HdfPart {
    fn create(group: H5Group, grid: &PartGrid, part: &PartFrame) -> Result<Self> {
        // One piece, the same in all steps.
        put(&group, "NumberOfPoints", &[grid.points as i64])?;
        put(&group, "NumberOfCells", &[grid.cells() as i64])?;
        put(&group, "NumberOfConnectivityIds", &[grid.corners.len() as i64])?;
        let begins: Vec<i64> = std::iter::once(0).chain(grid.ends.iter().copied()).collect();
        put_packed(&group, "Connectivity", &grid.corners)?;
        put_packed(&group, "Offsets", &begins)?;
        put_packed(&group, "Types", &grid.kinds)?;
        let (point_data, cell_data) = (group.create_group("PointData")?, group.create_group("CellData")?);
        let mut fixed = Vec::new();
        for array in &grid.fixed {
            if let PartArray::Byte(numbers) = &array.numbers {
                put_packed(&cell_data, array.name, numbers)?;
            }
            fixed.push(array.name);
        }
        let series = |group: &H5Group, arrays: &[Array], count| {
            arrays.iter().map(|array| StepCounts::create(group, array, count)).collect::<Result<Vec<_>>>()
        };
        Ok(Self {
            points: StepCounts::create(&group, &part.points, grid.points)?,
            of_points: series(&point_data, &part.of_points, grid.points)?,
            of_cells: series(&cell_data, &part.of_cells, grid.cells())?,
            fixed,
            group,
        })
    }

    /// Where each step begins, and the right length of everything.
    fn finish(&self, times: &[f64]) -> Result<()> {
        let count = times.len();
        let steps = list_times(&self.group, times)?;
        let (zeros, ones) = (vec![0_i64; count], vec![1_i64; count]);
        put(&steps, "NumberOfParts", &ones)?;
        put(&steps, "PartOffsets", &zeros)?;
        put(&steps, "PointOffsets", &self.points.offsets(count))?;
        for name in ["CellOffsets", "ConnectivityIdOffsets"] {
            let column = steps.new_dataset::<i64>().shape([count, 1]).create(name)?;
            column.write_raw(&zeros)?;
        }
        let (point_data, cell_data) = (steps.create_group("PointDataOffsets")?, steps.create_group("CellDataOffsets")?);
        self.points.cut(count)?;
        for (group, all) in [(&point_data, &self.of_points), (&cell_data, &self.of_cells)] {
            for series in all {
                put(group, series.name, &series.offsets(count))?;
                series.cut(count)?;
            }
        }
        self.fixed.iter().try_for_each(|name| put(&cell_data, name, &zeros))
    }
}

/// The steps of a group.
fn list_times(group: &H5Group, times: &[f64]) -> Result<H5Group> {
    let steps = group.create_group("Steps")?;
    steps.set_attr_numeric("NSteps", &(times.len() as i64))?;
    put(&steps, "Values", times)?;
    Ok(steps)
}

impl StepCounts {
    fn create(group: &H5Group, array: &Array, count: usize) -> Result<Self> {
        let data = match &array.numbers {
            PartArray::Float(_) => series::<f32>(group, array, count),
            PartArray::Byte(_) => series::<u8>(group, array, count),
        };
        Ok(Self { name: array.name, data: data?, count, components: array.components })
    }

    /// First point or cell of each step.
    fn offsets(&self, steps: usize) -> Vec<i64> {
        (0..steps).map(|step| (step * self.count) as i64).collect()
    }

    /// Sets the length to so many steps.
    fn cut(&self, steps: usize) -> Result<()> {
        self.data.extend(&shape(steps * self.count, self.components))
    }
}

/// The chunks of a part: its points, arrays of points, arrays of cells.
pub(super) struct PackedPart(Vec<Vec<u8>>);

/// Compresses a part: what [`HdfFile::add`] puts into the file as it is.
pub(super) fn pack(part: &PartFrame) -> io::Result<PackedPart> {
    let arrays = [&part.points].into_iter().chain(&part.of_points).chain(&part.of_cells);
    arrays.map(|array| chunk(&array.numbers)).collect::<io::Result<_>>().map(PackedPart)
}

/// Numbers after the filters of [`series`]: bytes sorted by their place in a number, then deflated.
fn chunk(numbers: &PartArray) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    match numbers {
        PartArray::Float(numbers) => {
            let mut sorted = vec![0; size_of_val(numbers.as_slice())];
            for (byte, sorted) in sorted.chunks_exact_mut(numbers.len()).enumerate() {
                sorted.iter_mut().zip(numbers).for_each(|(sorted, number)| *sorted = number.to_ne_bytes()[byte]);
            }
            encoder.write_all(&sorted)?;
        }
        PartArray::Byte(numbers) => encoder.write_all(numbers)?,
    }
    encoder.finish()
}

/// Of rows of numbers; of single numbers without a second axis.
fn shape(rows: usize, components: usize) -> Vec<usize> {
    if components == 1 { vec![rows] } else { vec![rows, components] }
}

fn series<T: H5Type>(group: &H5Group, array: &Array, count: usize) -> Result<H5Dataset> {
    let mut limit: Vec<Option<usize>> = shape(0, array.components).into_iter().map(Some).collect();
    limit[0] = None;
    let builder = group.new_dataset::<T>().shape(shape(0, array.components)).max_shape(&limit);
    builder.chunk(&shape(count, array.components)).shuffle_deflate(LEVEL).create(array.name)
}

/// A few numbers.
fn put<T: H5Type>(group: &H5Group, name: &str, numbers: &[T]) -> Result<()> {
    group.new_dataset::<T>().shape([numbers.len()]).create(name)?.write_raw(numbers)
}

/// Many numbers, compressed.
fn put_packed<T: H5Type>(group: &H5Group, name: &str, numbers: &[T]) -> Result<()> {
    let builder = group.new_dataset::<T>().shape([numbers.len()]).chunk(&[numbers.len()]);
    builder.shuffle_deflate(LEVEL).create(name)?.write_raw(numbers)
}

/// Says what a group is, the way VTK looks for it.
fn label(group: &H5Group, kind: &str) -> Result<()> {
    group.set_attr_array_numeric("Version", &VERSION)?;
    group.set_attr_typed("Type", DatatypeMessage::fixed_string(kind.len() as u32), kind.as_bytes().to_vec())
}
