//! The depth of the casters of a scene in a map: against that of each mesh bit for bit, and against rays of the light.
//! Which casters are drawn.

use glam::{DAffine3, DVec3, Mat3};
use rimline::gpu::depth_map::{MeshDepth, SceneDepth, SceneDepthCasters, SceneDepthCounts};
use rimline::gpu::{Caster, CasterHandle, FrameInputs, LightMask, PositionBuffer, Scene, SceneOptions};
use rimline::mesh::Weld;
use rimline::{DepthDirection, Light, Matrix3x4, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::mesh_depth::{map, wrong};
use crate::metric::bits;
use crate::picture::look;
use crate::scene::{Eye, vector};

pub(crate) const TESTS: &[Test] = &[
    ("the_depth_of_a_scene_is_that_of_its_meshes", equal),
    ("the_depth_of_a_scene_is_that_of_rays", traced),
    ("a_scene_that_changes_has_the_depth_of_the_moment", changed),
    ("casters_of_a_scene_are_chosen_for_its_depth", chosen),
];

pub(crate) const FORMATS: [TextureFormat; 3] =
    [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];

/// A caster of a test: its shape, where it is, and its handle. With `buffer`, its positions lie there, in world space.
pub(crate) struct Placed {
    pub(crate) shape: usize,
    pub(crate) rows: Matrix3x4,
    pub(crate) buffer: Option<(wgpu::Buffer, u64, u64)>,
    pub(crate) handle: CasterHandle,
}

pub(crate) struct Casters {
    pub(crate) shapes: Vec<(Shape, Mesh)>,
    pub(crate) scene: Scene,
    pub(crate) placed: Vec<Placed>,
}

/// A turn, a scale and a shift. Every third is mirrored.
fn rows(random: &mut Random, spread: f32, number: usize) -> Matrix3x4 {
    let axis = glam::Vec3::from_array(random.direction());
    let sign = if number.is_multiple_of(3) { -1.0 } else { 1.0 };
    let scale = glam::Vec3::new(sign * random.between(0.2, 0.6), random.between(0.2, 0.6), random.between(0.2, 0.6));
    let linear = Mat3::from_axis_angle(axis, random.between(0.0, 6.0)) * Mat3::from_diagonal(scale);
    let shift: [f32; 3] = std::array::from_fn(|_| random.between(-spread, spread));
    std::array::from_fn(|axis| [linear.row(axis).x, linear.row(axis).y, linear.row(axis).z, shift[axis]])
}

fn to_world(rows: &Matrix3x4, position: [f32; 3]) -> DVec3 {
    let columns: [[f64; 3]; 4] = std::array::from_fn(|column| rows.map(|row| f64::from(row[column])));
    DAffine3::from_cols_array_2d(&columns).transform_point3(DVec3::from_array(position.map(f64::from)))
}

impl Casters {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, String> {
        // One is larger than a chunk, one smaller, and one in clusters.
        let shapes = [shapes::cube(), shapes::torus(12, 10, 1.0, 0.4), shapes::blob(3, 0.3, 5)];
        let options = SceneOptions { clusters_from: Some(500), ..Default::default() };
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        scene.add_light(Light::point(DVec3::Y.as_vec3().to_array())).map_err(text)?;
        let mesh = |shape: Shape| {
            Mesh::new(&shape.positions, &shape.faces, Weld::Keep).map(|mesh| (shape, mesh)).map_err(text)
        };
        let shapes = shapes.into_iter().map(mesh).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { shapes, scene, placed: Vec::new() })
    }

    pub(crate) fn meshes(&mut self) -> Result<Vec<rimline::gpu::MeshHandle>, String> {
        let shapes = &self.shapes;
        shapes.iter().map(|(shape, mesh)| self.scene.add_mesh(mesh, &shape.positions).map_err(text)).collect()
    }

    /// Adds `count` rigid casters, and as many with positions in two buffers, of odd offsets and strides.
    pub(crate) fn fill(&mut self, gpu: &Gpu, random: &mut Random, (count, spread): (usize, f32)) -> Result<(), String> {
        let meshes = self.meshes()?;
        for number in 0..count {
            let shape = random.below(3);
            let rows = if number % 4 == 1 { IDENTITY } else { rows(random, spread, number) };
            let handle = self.scene.insert(Caster::rigid(meshes[shape], rows)).map_err(text)?;
            self.placed.push(Placed { shape, rows, buffer: None, handle });
        }
        for _ in 0..2 {
            let (mut words, mut of_buffer) = (vec![3.0_f32; 5], Vec::new());
            for number in 0..count / 2 {
                let (shape, rows, stride) = (random.below(3), rows(random, spread, number), 3 + random.below(3));
                of_buffer.push((shape, 4 * words.len() as u64, 4 * stride as u64));
                for &position in &self.shapes[shape].0.positions {
                    words.extend(to_world(&rows, position).as_vec3().to_array());
                    words.extend(vec![f32::NAN; stride - 3]);
                }
            }
            let buffer = gpu.storage(&words);
            for (shape, offset, stride) in of_buffer {
                let positions = PositionBuffer { buffer: &buffer, offset, stride };
                let handle = self.scene.insert(Caster::in_buffer(meshes[shape], positions)).map_err(text)?;
                self.placed.push(Placed {
                    shape,
                    rows: IDENTITY,
                    buffer: Some((buffer.clone(), offset, stride)),
                    handle,
                });
            }
        }
        Ok(())
    }

    /// States the boxes of casters in buffers.
    fn state_bounds(&mut self, gpu: &Gpu) -> Result<(), String> {
        for caster in &self.placed {
            let Some((buffer, offset, stride)) = &caster.buffer else { continue };
            let words: Vec<f32> = gpu.read(buffer, (buffer.size() / 4) as usize)?;
            let vertices = self.shapes[caster.shape].0.positions.len();
            let word = |vertex: usize, axis: usize| words[(offset + stride * vertex as u64) as usize / 4 + axis];
            let bound = |pick: fn(f32, f32) -> f32| {
                std::array::from_fn(|axis| (0..vertices).map(|vertex| word(vertex, axis)).reduce(pick).unwrap_or(0.0))
            };
            let bounds = [bound(f32::min), bound(f32::max)];
            self.scene.set_bounds(caster.handle, Some(bounds)).map_err(text)?;
        }
        Ok(())
    }

    /// The map that the helper for scenes draws.
    pub(crate) fn drawn(
        &self,
        gpu: &Gpu,
        format: TextureFormat,
        light: &ShadowCamera,
        which: SceneDepthCasters<'_>,
    ) -> Result<(Vec<f32>, SceneDepthCounts), String> {
        let draws = SceneDepth::new(&gpu.pipelines, format, light.depth).map_err(text)?;
        let mut counts = SceneDepthCounts::default();
        let depths = map(gpu, format, light, |pass| {
            counts = draws.draw(pass, &self.scene, which, light).map_err(text)?;
            Ok(())
        })?;
        Ok((depths, counts))
    }

    /// The map that one draw for each mesh makes.
    pub(crate) fn one_by_one(
        &self,
        gpu: &Gpu,
        format: TextureFormat,
        light: &ShadowCamera,
        which: impl Fn(usize) -> bool,
    ) -> Result<Vec<f32>, String> {
        let new = |(_, mesh): &(Shape, Mesh)| MeshDepth::new(&gpu.pipelines, mesh, format, light.depth).map_err(text);
        let draws = self.shapes.iter().map(new).collect::<Result<Vec<_>, _>>()?;
        let buffers: Vec<_> = self.shapes.iter().map(|(shape, _)| gpu.storage(&shape.positions)).collect();
        map(gpu, format, light, |pass| {
            for (_, caster) in self.placed.iter().enumerate().filter(|(number, _)| which(*number)) {
                let draw = &draws[caster.shape];
                let drawn = if let Some((buffer, offset, stride)) = &caster.buffer {
                    draw.draw(pass, PositionBuffer { buffer, offset: *offset, stride: *stride }, light)
                } else {
                    let positions = PositionBuffer { buffer: &buffers[caster.shape], offset: 0, stride: 12 };
                    if caster.rows == IDENTITY {
                        draw.draw(pass, positions, light)
                    } else {
                        draw.draw_rigid(pass, positions, caster.rows, light)
                    }
                };
                drawn.map_err(text)?;
            }
            Ok(())
        })
    }

    /// All triangles in world space.
    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.placed.iter().flat_map(|caster| {
            let (shape, rows) = (&self.shapes[caster.shape].0, &caster.rows);
            shape.faces.iter().map(move |face| face.map(|vertex| to_world(rows, shape.positions[vertex as usize])))
        })
    }
}

/// A light that sees casters around the origin, or a part of them.
pub(crate) fn light(random: &mut Random, number: usize) -> ShadowCamera {
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][number % 2];
    let (far, half_width) = [(None, None), (Some(12.0), None), (Some(12.0), Some(3.0))][number / 2 % 3];
    let forward = vector(random);
    Eye { is_relative: random.below(2) == 0, depth, far, half_width, ..look(-6.0 * forward, forward, 1.0) }.camera()
}

/// Casters near the middle, and casters that spread so far that some are culled. Boxes of the latter are stated.
fn equal() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1714)?;
    let (mut culled, mut all, mut covered, mut noticed) = (0, 0, 0, 0);
    for number in 0..if is_long() { 96 } else { 24 } {
        let is_far = number % 2 == 1;
        let mut casters = Casters::new(&gpu)?;
        casters.fill(&gpu, &mut random, (24, if is_far { 8.0 } else { 3.0 }))?;
        if is_far {
            casters.state_bounds(&gpu)?;
        }
        let (light, format) = (light(&mut random, number / 2), FORMATS[number / 2 % 3]);
        let (found, counts) = casters.drawn(&gpu, format, &light, SceneDepthCasters::All)?;
        let truth = casters.one_by_one(&gpu, format, &light, |_| true)?;
        let what = format!("scene {number}, {format:?} {:?}", light.depth);
        same(&what, &bits(&found), &bits(&truth))?;
        let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
        covered += truth.iter().filter(|&&depth| depth != far).count();
        // One draw for the page, and one for each buffer.
        let is_drawn = counts.draws == 3 || is_far && counts.draws < 3;
        if !is_drawn || counts.drawn + counts.outside != casters.placed.len() {
            return Err(format!("{what}: {counts:?}"));
        }
        for at in 0..if is_far || number == 0 { casters.placed.len() } else { 0 } {
            if !is_far {
                // Negative control: each caster is missing in turn.
                let other = casters.one_by_one(&gpu, format, &light, |number| number != at)?;
                noticed += usize::from(bits(&other) != bits(&found));
                continue;
            }
            // A culled caster has no texel.
            let only = [casters.placed[at].handle];
            let (_, one) = casters.drawn(&gpu, format, &light, SceneDepthCasters::Only(&only))?;
            let alone = casters.one_by_one(&gpu, format, &light, |number| number == at)?;
            if alone.iter().any(|&depth| depth != far) && one.drawn != 1 {
                return Err(format!("{what}: caster {at} is seen and culled"));
            }
        }
        if is_far {
            culled += counts.outside;
            all += counts.outside + counts.drawn;
        }
    }
    println!("{covered} texels covered; {culled} of {all} culled; {noticed} of 48 missing casters are noticed");
    // A caster without a box, or with a box that is not finite, is drawn. A box out of the map culls a caster, even if its
    // vertices are in the map.
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (8, 0.1))?;
    let light = light(&mut random, 0);
    let (_, counts) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("in the middle", &[counts.outside], &[0])?;
    let in_buffer = casters.placed.iter().rfind(|caster| caster.buffer.is_some()).map(|caster| caster.handle);
    let in_buffer = in_buffer.ok_or("a caster has a buffer")?;
    casters.scene.set_bounds(in_buffer, Some([[900.0; 3], [901.0; 3]])).map_err(text)?;
    let (_, counts) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("stated elsewhere", &[counts.outside], &[1])?;
    let is_tried = covered > 4000 && noticed > 24 && culled * 4 > all && culled * 10 < all * 9;
    if is_tried { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// Rigid casters, turned, scaled and mirrored, by both helpers.
fn traced() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1712)?;
    for number in 0..9 {
        let mut casters = Casters::new(&gpu)?;
        let meshes = casters.meshes()?;
        for caster in 0..12 {
            let (shape, rows) = (random.below(3), rows(&mut random, 2.0, caster));
            let handle = casters.scene.insert(Caster::rigid(meshes[shape], rows)).map_err(text)?;
            casters.placed.push(Placed { shape, rows, buffer: None, handle });
        }
        let (light, format) = (light(&mut random, number), FORMATS[number % 3]);
        let (depths, _) = casters.drawn(&gpu, format, &light, SceneDepthCasters::All)?;
        // Bound on the rounding of `f32` depths, or the step of the map's format.
        let step = if format == TextureFormat::Depth16Unorm { 1.0 / 65_535.0 } else { 2e-6 };
        let [bad, covered] = wrong(casters.triangles(), &light, (&depths, step));
        let each = casters.one_by_one(&gpu, format, &light, |_| true)?;
        same("one by one", &bits(&depths), &bits(&each))?;
        let mut moved = depths;
        moved.rotate_right(3);
        let [noticed, _] = wrong(casters.triangles(), &light, (&moved, step));
        // Another negative control: a caster is not mirrored.
        casters.placed[0].rows[0][0] *= -1.0;
        casters.placed[0].rows[1][0] *= -1.0;
        casters.placed[0].rows[2][0] *= -1.0;
        casters.placed[0].rows[1][3] += 0.5;
        let [of_moved, _] = wrong(casters.triangles(), &light, (&each, step));
        println!("{format:?} {:?}: {bad} wrong of {covered}; moved {noticed}, {of_moved}", light.depth);
        if bad > 0 || covered < 100 || noticed < 50 || of_moved == 0 {
            return Err(format!("{format:?} {light:?}: {bad} wrong of {covered}; moved {noticed}, {of_moved}"));
        }
    }
    Ok(())
}

/// Draws see the scene as it is when they are recorded, encoded or not.
fn changed() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1715)?;
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (12, 2.0))?;
    let mut before = Vec::new();
    for round in 0..8 {
        let light = light(&mut Random::new(1715), 0);
        let at = random.below(casters.placed.len());
        if round % 4 == 1 {
            let removed = casters.placed.swap_remove(at);
            casters.scene.remove(removed.handle).map_err(text)?;
        } else if round % 4 == 2 {
            casters.fill(&gpu, &mut random, (2, 1.0))?;
        } else if round > 0
            && let Some(caster) = casters.placed.iter_mut().find(|caster| caster.buffer.is_none())
        {
            caster.rows = rows(&mut random, 1.0, round);
            casters.scene.set_transform(caster.handle, caster.rows).map_err(text)?;
        }
        if round % 2 == 0 {
            gpu.submit(|encoder| casters.scene.encode(encoder, FrameInputs::default()).map(drop).map_err(text))?;
        }
        let (found, _) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
        same("depths", &bits(&found), &bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| true)?))?;
        if round == 3 || round == 7 {
            must_fail("before", &same("depths", &bits(&found), &before))?;
        }
        before = bits(&found);
    }
    Ok(())
}

fn chosen() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1713)?;
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (16, 2.0))?;
    let light = light(&mut random, 1);
    let of_scene = casters.scene.add_light(Light::point([0.0, 9.0, 0.0])).map_err(text)?;
    let is_listed = |number: usize| number % 3 == 1;
    let listed: Vec<_> =
        (0..).zip(&casters.placed).filter(|(number, _)| is_listed(*number)).map(|(_, caster)| caster.handle).collect();
    for &caster in &listed {
        casters.scene.set_lights(caster, LightMask::ALL.without(of_scene)).map_err(text)?;
    }
    let twice = [&listed[..], &listed[..]].concat();
    let draw = |which| Ok::<_, String>(casters.drawn(&gpu, FORMATS[0], &light, which)?.0);
    let only = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, is_listed)?);
    let others = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |number| !is_listed(number))?);
    let all = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| true)?);
    same("only", &bits(&draw(SceneDepthCasters::Only(&listed))?), &only)?;
    same("only, twice", &bits(&draw(SceneDepthCasters::Only(&twice))?), &only)?;
    same("except", &bits(&draw(SceneDepthCasters::Except(&listed))?), &others)?;
    same("without volumes", &bits(&draw(SceneDepthCasters::NotCastingFor(of_scene))?), &only)?;
    same("except none", &bits(&draw(SceneDepthCasters::Except(&[]))?), &all)?;
    let none = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| false)?);
    same("none", &bits(&draw(SceneDepthCasters::Only(&[]))?), &none)?;
    must_fail("all", &same("only", &all, &only))?;
    must_fail("others", &same("only", &others, &only))?;
    must_fail("nothing", &same("only", &none, &only))?;
    // A scene without casters, and one whose casters have singular transforms.
    let mut empty = Casters::new(&gpu)?;
    let (found, counts) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("no casters", &bits(&found), &none)?;
    same("no draws", &[counts], &[SceneDepthCounts::default()])?;
    let mesh = empty.meshes()?[0];
    let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
    let not_finite = [[f32::NAN, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    for rows in [flat, not_finite] {
        let handle = empty.scene.insert(Caster::rigid(mesh, rows)).map_err(text)?;
        empty.placed.push(Placed { shape: 0, rows, buffer: None, handle });
    }
    let (found, counts) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    same("singular", &bits(&found), &none)?;
    same("singular: no draws", &[counts], &[SceneDepthCounts::default()])?;
    let each = empty.one_by_one(&gpu, FORMATS[0], &light, |_| true)?;
    same("singular, one by one", &bits(&each), &none)?;
    // Negative control: with the unit matrix it is drawn.
    empty.scene.set_transform(empty.placed[0].handle, IDENTITY).map_err(text)?;
    let (found, _) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    must_fail("the unit matrix", &same("singular", &bits(&found), &none))
}
