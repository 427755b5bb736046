//! The check of a device: the viewer's scenes and every stress scene are extracted there, and all bits compared with
//! the CPU's. `rimline verify --built-in` runs it, and so does the viewer's page.

use std::fmt::{self, Display, Formatter};

use rimline::cpu::{Threads, deform, extract};
use rimline::gltf::{Asset, LoadOptions};
use rimline::gpu::{Extractor, ExtractorOptions, Pipelines, PositionBuffer, read_back_vec_async};
use rimline::{Light, Mesh, Model, Pose, Predicate, wgpu};
use rimline_bench::random::Random;
use rimline_bench::stress;

use crate::figure::{Figure, glb};
use crate::scenes;

/// About how many faces a stress scene has.
const FACES: usize = 2000;

/// Two batches of lights, the second not full.
pub const LIGHTS: usize = 40;

/// Reasons in words: the caller can do nothing but tell them.
type Reason = String;

/// A mesh and lights that are hard to decide.
#[derive(Clone, Debug)]
pub struct Case {
    pub name: String,
    pub positions: Vec<[f32; 3]>,
    pub mesh: Mesh,
    pub lights: Vec<Light>,
}

/// All cases, each made when it is its turn.
pub fn cases() -> impl Iterator<Item = Case> {
    let walking = || {
        let asset = Asset::from_slice(&glb::encode(&Figure::new()), None, LoadOptions::default()).expect("a figure");
        Case::of_model("Walking figure", asset.model(), &asset.pose([0], 0.37).expect("it walks"))
    };
    let still = scenes::still_life().expect("shapes").into_iter().chain([scenes::moebius().expect("a shape")]);
    let still = still.map(|(name, model, pose)| Case::of_model(name, &model, &pose));
    let stress = stress::scenes(FACES).map(|scene| {
        let (mesh, lights) = (scene.mesh().expect("a mesh"), scene.lights(LIGHTS));
        Case { name: scene.name.to_owned(), positions: scene.positions, mesh, lights }
    });
    std::iter::once_with(walking).chain(still).chain(stress)
}

#[expect(clippy::needless_pass_by_value, reason = "it is for `map_err`")]
fn say(error: impl ToString) -> Reason {
    error.to_string()
}

impl Case {
    fn of_model(name: &str, model: &Model, pose: &Pose) -> Self {
        let positions = deform(model, pose, 0.0, None, Threads::ONE).expect("the pose is of the model");
        let mesh = model.mesh(pose).expect("a mesh");
        let lights = hard_lights(&positions, mesh.faces());
        Self { name: name.to_owned(), positions, mesh, lights }
    }

    /// Pairs of a face and a light.
    pub fn pairs(&self) -> u64 {
        self.mesh.faces().len() as u64 * self.lights.len() as u64
    }

    /// The bits that the CPU finds.
    pub fn on_cpu(&self) -> Bits {
        let found = extract(&self.positions, &self.mesh, &self.lights, Predicate::Exact, Threads::all());
        let found = found.expect("cases have as many positions as they need");
        Bits([found.facing, bytemuck::cast_slice(&found.masks).to_vec()])
    }

    /// The bits that a device finds. All is submitted when this returns. The future waits for the device, which
    /// somebody must poll; a browser does.
    pub fn on_gpu(
        &self,
        queue: &wgpu::Queue,
        pipelines: &Pipelines,
    ) -> Result<impl Future<Output = Result<Bits, Reason>> + use<>, Reason> {
        let device = pipelines.device();
        let options = ExtractorOptions { max_lights: LIGHTS, masks: true, lists: None, ..ExtractorOptions::default() };
        let mut extractor = Extractor::new(pipelines, &self.mesh, options).map_err(say)?;
        let contents: &[u8] = bytemuck::cast_slice(&self.positions);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("check"),
            size: contents.len().max(16) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, contents);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("check") });
        let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        extractor.encode(&mut encoder, positions, &self.lights).map_err(say)?;
        queue.submit([encoder.finish()]);
        let results = extractor.results();
        let read = |buffers: &[wgpu::Buffer]| -> Vec<_> {
            buffers.iter().map(|buffer| read_back_vec_async::<u32>(device, queue, buffer)).collect()
        };
        // A buffer may be longer than what it holds. Masks of an edge are two words.
        let planes =
            [(read(results.facing), self.mesh.faces().len()), (read(results.masks), 2 * self.mesh.edges().len())];
        Ok(async move {
            let mut bits = Bits::default();
            for (all, (planes, words)) in bits.0.iter_mut().zip(planes) {
                for plane in planes {
                    let plane = plane.await.map_err(say)?;
                    all.extend(plane.get(..words).ok_or("the device gives fewer bits than there are")?);
                }
            }
            Ok(bits)
        })
    }
}

/// Facing bits of all faces, and silhouette and winding bits of all edges.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bits([Vec<u32>; 2]);

impl Bits {
    /// The number of bits that differ. A bit that one of them lacks differs, too.
    pub fn different(&self, other: &Self) -> u64 {
        let pairs = self.0.iter().zip(&other.0);
        let count = |(a, b): (&Vec<u32>, &Vec<u32>)| -> u64 {
            let differing = a.iter().zip(b).map(|(a, b)| u64::from((a ^ b).count_ones())).sum::<u64>();
            differing + 32 * a.len().abs_diff(b.len()) as u64
        };
        pairs.map(count).sum()
    }

    /// Turns the first bit over, so that a check has something to find.
    pub fn plant(&mut self) {
        if let Some(word) = self.0.iter_mut().flatten().next() {
            *word ^= 1;
        }
    }
}

/// Results of a check so far, shown as a table.
#[derive(Clone, Debug, Default)]
pub struct Report {
    pub device: String,
    pub rows: Vec<Row>,
}

/// One case on one device.
#[derive(Clone, Debug)]
pub struct Row {
    pub scene: String,
    pub pairs: u64,
    /// The number of wrong bits, or why there is none.
    pub wrong_bits: Result<u64, Reason>,
}

impl Report {
    /// All wrong bits.
    pub fn wrong_bits(&self) -> u64 {
        self.rows.iter().filter_map(|row| row.wrong_bits.as_ref().ok()).sum()
    }

    /// The number of scenes that could not be checked.
    pub fn failed(&self) -> usize {
        self.rows.iter().filter(|row| row.wrong_bits.is_err()).count()
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.scene.chars().count()).max().unwrap_or(0).max(5);
        writeln!(f, "{}\n\n{:<width$}  {:>8}  {:>10}", self.device, "scene", "pairs", "wrong bits")?;
        for Row { scene, pairs, wrong_bits } in &self.rows {
            match wrong_bits {
                Ok(bits) => writeln!(f, "{scene:<width$}  {pairs:>8}  {bits:>10}")?,
                Err(reason) => writeln!(f, "{scene:<width$}  {pairs:>8}  failed: {reason}")?,
            }
        }
        let (scenes, pairs) = (self.rows.len(), self.rows.iter().map(|row| row.pairs).sum::<u64>());
        writeln!(f, "\n{scenes} scenes, {pairs} pairs: {} wrong bits, {} failed", self.wrong_bits(), self.failed())
    }
}

/// Points and directions about the mesh, some of them on its vertices and edges, in its faces' planes, with other w, also
/// below 0, which shadows and queries refuse.
pub fn hard_lights(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Light> {
    let mut chance = Random::new(0x5eed);
    let (centre, size) = extent(positions);
    (0..LIGHTS)
        .map(|index| {
            let away = [0; 3].map(|_| chance.between(-1.0, 1.0));
            let near: [f32; 3] = std::array::from_fn(|i| centre[i] + away[i] * 2.0 * size);
            let light = on_mesh(index, positions, faces, &mut chance).unwrap_or_else(|| match index % 4 {
                0 => Light::directional(away),
                1 => scaled(near, 2.5),
                2 => scaled(near, -0.7),
                _ => Light::point(near),
            });
            let is_light = light.to_array().iter().all(|c| c.is_finite()) && light.to_array() != [0.0; 4];
            if is_light { light } else { Light::directional([away[0], away[1], 1.0]) }
        })
        .collect()
}

/// The point, as a light of this weight.
fn scaled(point: [f32; 3], w: f32) -> Light {
    let [x, y, z] = point.map(|c| c * w);
    Light::homogeneous([x, y, z, w])
}

/// Every other light: on a vertex, on an edge, in a face's plane, at infinity in its plane, on its plane with a tiny w.
fn on_mesh(index: usize, positions: &[[f32; 3]], faces: &[[u32; 3]], chance: &mut Random) -> Option<Light> {
    if index.is_multiple_of(2) {
        return None;
    }
    let [a, b, c] = (*faces.get(chance.below(faces.len()))?).map(|v| positions.get(v as usize).copied());
    let (a, b, c) = (a?, b?, c?);
    let (s, t) = (chance.between(-2.0, 2.0), chance.between(-2.0, 2.0));
    let plane: [f32; 3] = std::array::from_fn(|i| s * (b[i] - a[i]) + t * (c[i] - a[i]));
    Some(match index / 2 % 5 {
        0 => Light::point(a),
        1 => Light::point(std::array::from_fn(|i| 0.5 * (a[i] + b[i]))),
        2 => Light::point(std::array::from_fn(|i| a[i] + plane[i])),
        3 => Light::directional(plane),
        _ => scaled(std::array::from_fn(|i| a[i] + plane[i]), 1e-12),
    })
}

/// The middle of the finite positions' bounds, and the longest half side.
fn extent(positions: &[[f32; 3]]) -> ([f32; 3], f32) {
    let finite = positions.iter().filter(|position| position.iter().all(|c| c.is_finite()));
    let bounds = finite.fold(None, |bounds: Option<[[f32; 3]; 2]>, &position| {
        let [low, high] = bounds.unwrap_or([position; 2]);
        Some([
            [0, 1, 2].map(|axis| low[axis].min(position[axis])),
            [0, 1, 2].map(|axis| high[axis].max(position[axis])),
        ])
    });
    let [min, max] = bounds.unwrap_or([[f32::NAN; 3]; 2]);
    let half = [0, 1, 2].map(|axis| 0.5 * max[axis] - 0.5 * min[axis]);
    let size = if bounds.is_some() { half.into_iter().fold(0.0, f32::max) } else { f32::NAN };
    ([0, 1, 2].map(|axis| min[axis] + half[axis]), size)
}

#[cfg(test)]
mod tests {
    use rimline::{MAX_LIGHTS, check_lights};

    use super::*;

    #[test]
    fn they_are_lights_whatever_the_mesh() {
        let strange = [[0.0; 3], [f32::NAN, 1.0, f32::INFINITY], [f32::MAX, -f32::MAX, 1e-45]];
        for positions in [&strange[..], &strange[..1], &[]] {
            for faces in [&[[0, 1, 2]][..], &[]] {
                let lights = hard_lights(positions, faces);
                assert_eq!((lights.len(), check_lights(&lights, MAX_LIGHTS)), (LIGHTS, Ok(())));
                assert_eq!(lights, hard_lights(positions, faces));
            }
        }
    }

    #[test]
    fn a_planted_bit_and_a_missing_word_are_counted() {
        let bits = Bits([vec![0b101, 7], vec![1; 4]]);
        let mut planted = bits.clone();
        planted.plant();
        assert_eq!((bits.different(&bits), bits.different(&planted), planted.different(&bits)), (0, 1, 1));
        let short = Bits([vec![0b101], vec![1; 4]]);
        assert_eq!(bits.different(&short), 32);
    }
}
