//! Depth maps with their projections, as `rimline shadow` takes and writes them.

use std::io::{self, Read, Seek, Write};

use rimline::gpu::depth_map::DepthMetric;

use super::header::ElementType;
use super::read::{Archive, BITS, Entry, NpzError, ORIGIN, REAL, index, is_float, is_integer, is_real};
use super::write::NpzWriter;

pub const MAX_SIDE: u32 = 4096;
/// Bytes for a value: as read into a list that doubles, in its own type, and on its way to the device.
const VALUE: u64 = 4 * 3 + 12;

/// Meaning of the values of a map, by its number in `metric`.
const METRICS: [DepthMetric; 3] = [DepthMetric::Device, DepthMetric::AlongAxis, DepthMetric::AlongRay];

/// Depths as the file has them, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub enum Depths {
    /// Device depths, or distances.
    F32(Vec<f32>),
    /// Device depths in steps of 1 / 65,535.
    U16(Vec<u16>),
}

/// One map, or six of a cube, and what they were drawn with.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMapArrays {
    /// Width and height.
    pub size: [u32; 2],
    /// Map by map, row by row, the first row at the top.
    pub depths: Depths,
    /// For each map the rows of its matrix, from positions less the origin to clip space.
    pub view_projections: Vec<[[f64; 4]; 4]>,
    /// Not checked: it may be infinite or NaN.
    pub origin: [f64; 3],
    /// Whether near is 1 and far is 0.
    pub is_reversed: bool,
    /// Bits that the depths were rounded to before, if it is said.
    pub depth_bits: Option<u32>,
    /// Meaning of the depths. The reader takes any with uint16, too, which can only be device depths.
    pub metric: DepthMetric,
    /// A number for each texel of one map, if they were asked for.
    pub objects: Option<Vec<u32>>,
}

const DEPTH: Entry = Entry {
    array: "depth",
    shape: "(H, W) or (6, H, W), with H and W from 1 to 4096,",
    limit: 6 * MAX_SIDE as u64,
    row_bytes: VALUE,
    wanted: "float32 or uint16 is needed (NumPy: `depth.astype('f4')`)",
    accepts: |element| is_float(element) || matches!((element.kind, element.size), ('u', 2)),
};
const VIEW_PROJECTION: Entry = Entry {
    array: "view_projection",
    shape: "(4, 4), or (6, 4, 4) for six maps,",
    limit: 24,
    row_bytes: 64,
    wanted: "float32 or float64 is needed",
    accepts: is_real,
};
const REVERSED: Entry = Entry {
    array: "reversed",
    shape: "()",
    limit: 1,
    row_bytes: 64,
    wanted: "a bool is needed: whether near is 1 and far is 0 (NumPy: `reversed=True`)",
    accepts: |element| is_integer(element) || matches!((element.kind, element.size), ('b', 1)),
};
const DEPTH_BITS: Entry =
    Entry { array: "depth_bits", wanted: "16, 24 or 32 is needed", accepts: is_integer, ..REVERSED };
const METRIC: Entry = Entry {
    array: "metric",
    wanted: "0, 1 or 2 is needed: device depths, distances along the axis, or distances along rays",
    ..DEPTH_BITS
};
const OBJECTS: Entry = Entry {
    array: "objects",
    shape: "(H, W), as `depth` has it,",
    limit: MAX_SIDE as u64,
    row_bytes: VALUE,
    wanted: "an integer type of 8 to 64 bits is needed (NumPy: `objects.astype('u4')`)",
    accepts: is_integer,
};

/// Reads a depth map, or six, with what they were drawn with, in either byte order and either array order. Reads
/// `objects` if `with_objects`. Refuses arrays that take more than `memory_limit` bytes, before it reads them.
pub fn read_depth_map(
    reader: impl Read + Seek,
    memory_limit: u64,
    with_objects: bool,
) -> Result<DepthMapArrays, NpzError> {
    let mut archive = Archive::open(reader, memory_limit)?;
    let is_side = |side: &u64| (1..=u64::from(MAX_SIDE)).contains(side);
    let (head, elements) = archive.values(&DEPTH, BITS, |shape| match shape {
        [height, width] | [6, height, width] => [height, width].into_iter().all(is_side),
        _ => false,
    })?;
    let (maps, [height, width]) = match head.header.shape[..] {
        [maps, height, width] => (Some(maps), [height, width]),
        ref shape => (None, [shape[0], shape[1]]),
    };
    let depths = if head.element.kind == 'f' {
        Depths::F32(elements.into_iter().map(f32::from_bits).collect())
    } else {
        Depths::U16(elements.into_iter().map(|value| value as u16).collect())
    };
    let (_, matrices) = archive.values(&VIEW_PROJECTION, REAL, |shape| match *shape {
        [4, 4] => maps.is_none(),
        [count, 4, 4] => Some(count) == maps,
        _ => false,
    })?;
    let origin = archive.point(&Entry { wanted: VIEW_PROJECTION.wanted, ..ORIGIN })?;
    let number = |archive: &mut Archive<_>, entry: &Entry, of: &[u32]| {
        let (_, elements) = archive.values(entry, index, |shape| matches!(*shape, [] | [1]))?;
        let number = elements.first().copied().unwrap_or_default();
        let wrong = || NpzError::Value { array: entry.array, found: number.to_string(), wanted: entry.wanted };
        of.contains(&number).then_some(number).ok_or_else(wrong)
    };
    let is_reversed = number(&mut archive, &REVERSED, &[0, 1])? == 1;
    let depth_bits =
        archive.has(DEPTH_BITS.array).then(|| number(&mut archive, &DEPTH_BITS, &[16, 24, 32])).transpose()?;
    let metric = archive.has(METRIC.array).then(|| number(&mut archive, &METRIC, &[0, 1, 2])).transpose()?.unwrap_or(0);
    let mut objects = None;
    if with_objects && archive.has(OBJECTS.array) {
        objects = Some(archive.values(&OBJECTS, index, |of| *of == [height, width])?.1);
    }
    Ok(DepthMapArrays {
        size: [width as u32, height as u32],
        depths,
        view_projections: matrices.as_chunks::<4>().0.as_chunks::<4>().0.to_vec(),
        origin,
        is_reversed,
        depth_bits,
        metric: METRICS[metric as usize],
        objects,
    })
}

/// Writes float32 where it holds all values exactly, else float64.
fn write_real(npz: &mut NpzWriter<impl Write + Seek>, name: &str, shape: &[usize], values: &[f64]) -> io::Result<()> {
    let single: Vec<f32> = values.iter().map(|&value| value as f32).collect();
    if single.iter().zip(values).all(|(&single, value)| f64::from(single).to_bits() == value.to_bits()) {
        return npz.slice(name, ElementType::F32, shape, &single);
    }
    npz.slice(name, ElementType::F64, shape, values)
}

impl DepthMapArrays {
    /// Writes them as they are read.
    pub fn write(&self, file: impl Write + Seek) -> io::Result<()> {
        let mut npz = NpzWriter::new(file);
        let maps = self.view_projections.len();
        let of_maps = |shape: &[usize]| if maps == 1 { shape.to_vec() } else { [&[maps], shape].concat() };
        let size = self.size.map(|side| side as usize);
        let shape = [size[1], size[0]];
        match &self.depths {
            Depths::F32(depths) => npz.slice("depth", ElementType::F32, &of_maps(&shape), depths)?,
            Depths::U16(depths) => npz.slice("depth", ElementType::U16, &of_maps(&shape), depths)?,
        }
        let matrices = self.view_projections.as_flattened().as_flattened();
        write_real(&mut npz, "view_projection", &of_maps(&[4, 4]), matrices)?;
        write_real(&mut npz, "origin", &[3], &self.origin)?;
        npz.slice("reversed", ElementType::BOOL, &[], &[u8::from(self.is_reversed)])?;
        if let Some(bits) = self.depth_bits {
            npz.slice("depth_bits", ElementType::U32, &[], &[bits])?;
        }
        if let Some(metric @ 1..) = METRICS.iter().position(|&metric| metric == self.metric) {
            npz.slice("metric", ElementType::U32, &[], &[metric as u32])?;
        }
        if let Some(objects) = &self.objects {
            npz.slice("objects", ElementType::U32, &shape, objects)?;
        }
        npz.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(maps: usize, depths: Depths) -> DepthMapArrays {
        let matrix =
            |map: usize| [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| (16 * map + 4 * row + column) as f64));
        DepthMapArrays {
            size: [3, 2],
            depths,
            view_projections: (0..maps).map(matrix).collect(),
            // The origin of six maps needs float64.
            origin: if maps == 6 { [392_143.517, -2.0, 0.5] } else { [1.0, -2.0, 0.5] },
            is_reversed: maps == 6,
            depth_bits: (maps == 6).then_some(24),
            metric: DepthMetric::Device,
            objects: (maps == 1).then(|| vec![7, 7, 8, 9, u32::MAX, 0]),
        }
    }

    fn read(map: &DepthMapArrays, memory_limit: u64) -> Result<DepthMapArrays, NpzError> {
        let mut bytes = io::Cursor::new(Vec::new());
        map.write(&mut bytes).expect("it goes to memory");
        read_depth_map(bytes, memory_limit, true)
    }

    #[test]
    fn what_is_written_is_read() {
        let one = map(1, Depths::U16(vec![0, 1, 2, 3, 4, 65535]));
        let six = map(6, Depths::F32((0..36).map(|number| number as f32 / 35.0).collect()));
        let along = DepthMapArrays { metric: DepthMetric::AlongAxis, depth_bits: None, ..six.clone() };
        let by_ray = DepthMapArrays { metric: DepthMetric::AlongRay, ..along.clone() };
        assert_ne!(read(&along, 1 << 20).ok(), Some(by_ray.clone()));
        for map in [&one, &six, &along, &by_ray] {
            assert_eq!(read(map, 1 << 20).as_ref().ok(), Some(map));
        }
        assert_ne!(read(&one, 1 << 20).ok(), Some(six.clone()));
        assert!(matches!(read(&six, 800), Err(NpzError::TooLarge { array: "depth", rows: 12, .. })));
    }

    #[test]
    fn matrices_of_another_number_of_maps_are_refused() {
        let mut wrong = map(1, Depths::U16(vec![0; 6]));
        wrong.view_projections = map(6, Depths::U16(Vec::new())).view_projections;
        wrong.depths = Depths::U16(vec![0; 36]);
        wrong.objects = None;
        assert!(read(&wrong, 1 << 20).is_ok());
        wrong.view_projections.pop();
        wrong.depths = Depths::U16(vec![0; 30]);
        assert!(matches!(read(&wrong, 1 << 20), Err(NpzError::Shape { array: "depth", .. })));
    }
}
