//! The depth of the casters of a scene in a map: against that of each mesh bit for bit, and against rays of the light.

use glam::{DAffine3, DVec3, Mat3};
use rimline::gpu::{
    Caster, CasterHandle, LightMask, MeshDepth, PositionBuffer, Scene, SceneDepth, SceneDepthCasters, SceneDepthCounts,
    SceneDepthError, SceneError, SceneOptions,
};
use rimline::mesh::Weld;
use rimline::reference::cpu::{mesh_depth, scene_depth};
use rimline::reference::layout::{MeshDepthCaster, MeshDepthView};
use rimline::{CameraError, DepthDirection, Light, Matrix3x4, Mesh, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::random::Random;
use rimline_measure::shapes::{self, Shape};
use rimline_measure::{must_fail, same};
use wgpu::TextureFormat;

use crate::mesh_depth::{SIDE, wrong};
use crate::scene::Eye;
use crate::textures::{read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("the_depth_of_a_scene_is_that_of_its_meshes", equal),
    ("the_depth_of_a_scene_is_that_of_rays", traced),
    ("casters_of_a_scene_are_chosen_for_its_depth", chosen),
    ("casters_that_the_light_does_not_see_are_left_out", outside),
    ("a_scene_that_changes_has_the_depth_of_the_moment", changed),
    ("vertices_of_chunks_are_those_of_their_mesh", vertices),
    ("depths_of_scenes_that_are_refused", refused),
];

const FORMATS: [TextureFormat; 3] =
    [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
const UNMOVED: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A caster of a test: its shape, where it is, and its handle. With `buffer`, its positions lie there, in world space.
struct Placed {
    shape: usize,
    rows: Matrix3x4,
    buffer: Option<(wgpu::Buffer, u64, u64)>,
    handle: CasterHandle,
}

struct Casters {
    shapes: Vec<(Shape, Mesh)>,
    scene: Scene,
    placed: Vec<Placed>,
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
    fn new(gpu: &Gpu) -> Result<Self, String> {
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

    fn meshes(&mut self) -> Result<Vec<rimline::gpu::MeshHandle>, String> {
        let shapes = &self.shapes;
        shapes.iter().map(|(shape, mesh)| self.scene.add_mesh(mesh, &shape.positions).map_err(text)).collect()
    }

    /// Adds `count` rigid casters, and as many with positions in two buffers, of odd offsets and strides.
    fn fill(&mut self, gpu: &Gpu, random: &mut Random, (count, spread): (usize, f32)) -> Result<(), String> {
        let meshes = self.meshes()?;
        for number in 0..count {
            let shape = random.below(3);
            let rows = if number % 4 == 1 { UNMOVED } else { rows(random, spread, number) };
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
                    rows: UNMOVED,
                    buffer: Some((buffer.clone(), offset, stride)),
                    handle,
                });
            }
        }
        Ok(())
    }

    /// The map that the helper for scenes draws.
    fn drawn(
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
    fn one_by_one(
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
                    if caster.rows == UNMOVED {
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

/// The texels of a map after a pass.
fn map(
    gpu: &Gpu,
    format: TextureFormat,
    light: &ShadowCamera,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<(), String>,
) -> Result<Vec<f32>, String> {
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let target = texture(gpu, [SIDE; 2], format, &[far; (SIDE * SIDE) as usize])?;
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        draw(&mut pass)
    })?;
    read(gpu, &target)
}

/// A light that sees casters around the origin, or a part of them.
fn light(random: &mut Random, number: usize) -> ShadowCamera {
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][number % 2];
    let (far, half_width) = [(None, None), (Some(12.0), None), (Some(12.0), Some(3.0))][number / 2 % 3];
    let forward = DVec3::from_array(random.direction().map(f64::from));
    Eye { place: -6.0 * forward, forward, near: 1.0, is_relative: random.below(2) == 0, depth, far, half_width }
        .camera()
}

fn bits(depths: &[f32]) -> Vec<u32> {
    depths.iter().map(|depth| depth.to_bits()).collect()
}

fn equal() -> Result<(), String> {
    const SEED: u64 = 1711;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (24, 3.0))?;
    let mut covered = 0;
    for number in 0..12 {
        let light = light(&mut random, number);
        let format = FORMATS[number % 3];
        let (found, counts) = casters.drawn(&gpu, format, &light, SceneDepthCasters::All)?;
        let truth = casters.one_by_one(&gpu, format, &light, |_| true)?;
        let what = format!("{format:?} {:?}", light.depth);
        same(&what, &bits(&found), &bits(&truth))?;
        let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
        covered += truth.iter().filter(|&&depth| depth != far).count();
        // One draw for the page, and one for each buffer.
        if counts.draws != 3 || counts.drawn + counts.outside != casters.placed.len() {
            return Err(format!("{what}: {counts:?}"));
        }
    }
    // Negative controls: casters that are seen are left out, one after the other; a texel differs.
    let light = light(&mut random, 0);
    let (found, _) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    let mut noticed = 0;
    for left_out in 0..casters.placed.len() {
        let other = casters.one_by_one(&gpu, FORMATS[0], &light, |number| number != left_out)?;
        noticed += usize::from(bits(&other) != bits(&found));
    }
    let mut off = bits(&found);
    off[SIDE as usize] ^= 1;
    must_fail("one bit", &same("depths", &bits(&found), &off))?;
    println!("{covered} texels covered; {noticed} of {} casters are seen", casters.placed.len());
    if covered > 4000 && noticed * 2 > casters.placed.len() { Ok(()) } else { Err(format!("{covered}, {noticed}")) }
}

/// Rigid casters, turned, scaled and mirrored, by both helpers.
fn traced() -> Result<(), String> {
    const SEED: u64 = 1712;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
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
        // What floats of this size round, and the map's own step.
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

fn chosen() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(1713);
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
    let own = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, is_listed)?);
    let others = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |number| !is_listed(number))?);
    let all = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| true)?);
    same("only", &bits(&draw(SceneDepthCasters::Only(&listed))?), &own)?;
    same("only, twice", &bits(&draw(SceneDepthCasters::Only(&twice))?), &own)?;
    same("except", &bits(&draw(SceneDepthCasters::Except(&listed))?), &others)?;
    same("without volumes", &bits(&draw(SceneDepthCasters::NotCastingFor(of_scene))?), &own)?;
    same("except none", &bits(&draw(SceneDepthCasters::Except(&[]))?), &all)?;
    let none = bits(&casters.one_by_one(&gpu, FORMATS[0], &light, |_| false)?);
    same("none", &bits(&draw(SceneDepthCasters::Only(&[]))?), &none)?;
    must_fail("all", &same("only", &all, &own))?;
    must_fail("others", &same("only", &others, &own))?;
    must_fail("nothing", &same("only", &none, &own))?;
    // A scene without casters, and one whose casters have no place.
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
    // Negative control: with a place, it is drawn.
    empty.scene.set_transform(empty.placed[0].handle, UNMOVED).map_err(text)?;
    let (found, _) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
    must_fail("a place", &same("singular", &bits(&found), &none))
}

/// Leaving casters out changes no bit. Boxes of buffers are stated.
fn outside() -> Result<(), String> {
    const SEED: u64 = 1714;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut left_out, mut all) = (0, 0);
    for number in 0..24 {
        let mut casters = Casters::new(&gpu)?;
        casters.fill(&gpu, &mut random, (24, 8.0))?;
        for at in 0..casters.placed.len() {
            let caster = &casters.placed[at];
            let Some((buffer, offset, stride)) = &caster.buffer else { continue };
            let words: Vec<f32> = gpu.read(buffer, (buffer.size() / 4) as usize)?;
            let vertices = casters.shapes[caster.shape].0.positions.len();
            let word = |vertex: usize, axis: usize| words[(offset + stride * vertex as u64) as usize / 4 + axis];
            let bound = |pick: fn(f32, f32) -> f32| {
                std::array::from_fn(|axis| (0..vertices).map(|vertex| word(vertex, axis)).reduce(pick).unwrap_or(0.0))
            };
            let bounds = [bound(f32::min), bound(f32::max)];
            casters.scene.set_bounds(caster.handle, Some(bounds)).map_err(text)?;
        }
        let (light, format) = (light(&mut random, number), FORMATS[number % 3]);
        let (found, counts) = casters.drawn(&gpu, format, &light, SceneDepthCasters::All)?;
        let truth = casters.one_by_one(&gpu, format, &light, |_| true)?;
        same(&format!("view {number}"), &bits(&found), &bits(&truth))?;
        // Each that was left out has no texel of its own.
        let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
        for at in 0..casters.placed.len() {
            let only = [casters.placed[at].handle];
            let (_, one) = casters.drawn(&gpu, format, &light, SceneDepthCasters::Only(&only))?;
            let alone = casters.one_by_one(&gpu, format, &light, |number| number == at)?;
            let is_seen = alone.iter().any(|&depth| depth != far);
            if is_seen && one.drawn != 1 {
                return Err(format!("view {number}: caster {at} is seen and left out"));
            }
        }
        left_out += counts.outside;
        all += counts.outside + counts.drawn;
    }
    println!("{left_out} of {all} left out");
    // A box that is not finite in one corner, or not stated, tells nothing; a box elsewhere does, whatever is in the buffer.
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
    if left_out * 4 > all && left_out * 10 < all * 9 { Ok(()) } else { Err(format!("{left_out} of {all} left out")) }
}

/// Draws see the scene as it is when they are recorded, encoded or not.
fn changed() -> Result<(), String> {
    const SEED: u64 = 1715;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (12, 2.0))?;
    let mut before = Vec::new();
    for round in 0..8 {
        let light = light(&mut Random::new(SEED), 0);
        let at = random.below(casters.placed.len());
        if round % 4 == 1 {
            let gone = casters.placed.swap_remove(at);
            casters.scene.remove(gone.handle).map_err(text)?;
        } else if round % 4 == 2 {
            casters.fill(&gpu, &mut random, (2, 1.0))?;
        } else if round > 0
            && let Some(caster) = casters.placed.iter_mut().find(|caster| caster.buffer.is_none())
        {
            caster.rows = rows(&mut random, 1.0, round);
            casters.scene.set_transform(caster.handle, caster.rows).map_err(text)?;
        }
        if round % 2 == 0 {
            gpu.submit(|encoder| casters.scene.encode(encoder, &[], None).map(drop).map_err(text))?;
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

/// The twins: a chunk's corner is the vertex that a draw of the mesh has there.
fn vertices() -> Result<(), String> {
    let mut random = Random::new(1716);
    let mut number = || random.between(-2.0, 2.0);
    let view = MeshDepthView { columns: std::array::from_fn(|_| std::array::from_fn(|_| number())) };
    let [row_0, row_1, row_2] = std::array::from_fn(|_| std::array::from_fn(|_| number()));
    let words: Vec<f32> = (0..200).map(|_| number()).collect();
    let faces: Vec<[u32; 3]> = (0..90).map(|face| [face % 30, (face + 1) % 30, (7 * face + 2) % 30]).collect();
    // The caster has 70 faces from the 15th on, and positions from the 6th word on, five words apart.
    let caster = MeshDepthCaster { row_0, row_1, row_2, place: [6, 5, 15, 70] };
    let position = |word: u32| std::array::from_fn(|axis| words[word as usize + axis]);
    let mut counts = [0; 2];
    for (chunk, corner) in [0, 64].into_iter().flat_map(|face| (0..192).map(move |corner| ([1, face], corner))) {
        let casters = [bytemuck::Zeroable::zeroed(), caster];
        let found = scene_depth(&view, (&casters, &faces), position, (chunk, corner));
        let face = chunk[1] + corner / 3;
        let truth = (face < 70).then(|| {
            let vertex = faces[15 + face as usize][corner as usize % 3];
            let own: [f32; 3] = position(6 + 5 * vertex);
            let own = DVec3::from_array(own.map(f64::from)).extend(1.0);
            let place = caster_rows(&caster).map(|row| glam::DVec4::from_array(row.map(f64::from)).dot(own));
            (view.columns.map(|c| glam::Vec4::from_array(c).as_dvec4()), place, vertex)
        });
        match (found, truth) {
            (None, None) => counts[0] += 1,
            (Some(found), Some((columns, [x, y, z], vertex))) => {
                let clip = columns[0] * x + columns[1] * y + columns[2] * z + columns[3];
                let off = (found.as_dvec4() - clip).length();
                let of_mesh = mesh_depth(&view, &caster, position(6 + 5 * vertex));
                if off > 1e-4 || found != of_mesh {
                    return Err(format!("{chunk:?}, corner {corner}: {found} for {clip} and {of_mesh}"));
                }
                counts[1] += 1;
            }
            other => return Err(format!("{chunk:?}, corner {corner}: {other:?}")),
        }
    }
    same("corners without and with a face", &counts, &[2 * 192 - 210, 210])
}

fn caster_rows(caster: &MeshDepthCaster) -> [[f32; 4]; 3] {
    [caster.row_0, caster.row_1, caster.row_2]
}

fn refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(1717);
    let [mut casters, mut other] = [Casters::new(&gpu)?, Casters::new(&gpu)?];
    casters.fill(&gpu, &mut random, (4, 1.0))?;
    other.fill(&gpu, &mut random, (4, 1.0))?;
    let of_other = [other.placed[0].handle];
    let gone = casters.placed.swap_remove(1);
    casters.scene.remove(gone.handle).map_err(text)?;
    let dangling = [casters.placed[0].handle, gone.handle];
    let lights = [&mut casters.scene, &mut other.scene].map(|scene| scene.add_light(Light::point([1.0; 3])));
    let [old, foreign] = lights;
    let (old, foreign) = (old.map_err(text)?, foreign.map_err(text)?);
    casters.scene.remove_light(old).map_err(text)?;
    let light = crate::stages::camera(DepthDirection::Reversed);
    let standard = crate::stages::camera(DepthDirection::Standard);
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..light };
    let draws = SceneDepth::new(&gpu.pipelines, FORMATS[0], light.depth).map_err(text)?;
    let mut found = Vec::new();
    let depths = map(&gpu, FORMATS[0], &light, |pass| {
        let mut draw = |which, light| draws.draw(pass, &casters.scene, which, light).err();
        found = vec![
            draw(SceneDepthCasters::Only(&dangling), &light),
            draw(SceneDepthCasters::Except(&dangling), &light),
            draw(SceneDepthCasters::Only(&of_other), &light),
            draw(SceneDepthCasters::NotCastingFor(old), &light),
            draw(SceneDepthCasters::NotCastingFor(foreign), &light),
            draw(SceneDepthCasters::All, &standard),
            draw(SceneDepthCasters::All, &singular),
        ];
        Ok(())
    })?;
    let of_scene = |error| Some(SceneDepthError::Scene(error));
    let truth = [
        of_scene(SceneError::Stale { what: "caster" }),
        of_scene(SceneError::Stale { what: "caster" }),
        of_scene(SceneError::OtherScene { what: "caster" }),
        of_scene(SceneError::Stale { what: "light" }),
        of_scene(SceneError::OtherScene { what: "light" }),
        Some(SceneDepthError::Depth { light: DepthDirection::Standard, made: DepthDirection::Reversed }),
        Some(SceneDepthError::Light(CameraError::Singular)),
    ];
    same("refused", &found, &truth)?;
    same("nothing is drawn", &depths, &[0.0; (SIDE * SIDE) as usize])?;
    let color = SceneDepth::new(&gpu.pipelines, TextureFormat::R32Float, light.depth).err();
    same("format", &[color], &[Some(SceneDepthError::Format(TextureFormat::R32Float))])?;
    // A scene of another device.
    let another = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let mut of_another = Casters::new(&another)?;
    of_another.fill(&another, &mut random, (4, 0.1))?;
    let straight = Eye {
        place: DVec3::new(0.0, 0.0, 5.0),
        forward: DVec3::NEG_Z,
        near: 0.1,
        is_relative: true,
        depth: DepthDirection::Reversed,
        far: None,
        half_width: None,
    };
    let mut outcome = None;
    map(&gpu, FORMATS[0], &light, |pass| {
        outcome = draws.draw(pass, &of_another.scene, SceneDepthCasters::All, &straight.camera()).err();
        Ok(())
    })?;
    match outcome {
        Some(SceneDepthError::Refused { .. }) => Ok(()),
        other => Err(format!("another device: {other:?}")),
    }
}
