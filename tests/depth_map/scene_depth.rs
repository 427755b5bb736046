//! The depth of the casters of a scene in a map by `mesh_depth`: against that of each mesh bit for bit, and against rays of
//! the light. Which casters are drawn.

use glam::{DAffine3, DVec2, DVec3, Mat3};
use rimline::gpu::depth_map::{MeshDepth, SceneDepth, SceneDepthCasters, SceneDepthCounts};
use rimline::gpu::{Caster, CasterHandle, FrameInputs, LightMask, PositionBuffer, Scene, SceneOptions};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{DepthDirection, Light, Matrix3x4, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Eye, Rays, vector};
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::textures::{pass, read, texture};
use rimline_testkit::{IDENTITY, is_long, must_fail, rays, same};
use wgpu::TextureFormat;

use crate::metric::bits;
use crate::parity::{device_depth, middle};
use crate::picture::look;

pub(crate) const TESTS: &[Test] = &[
    ("the_depth_of_a_scene_is_that_of_its_meshes_and_of_rays", equal),
    ("a_scene_that_changes_has_the_depth_of_the_moment", changed),
    ("casters_of_a_scene_are_chosen_for_its_depth", chosen),
    ("meshes_without_a_triangle_have_no_depth", without_triangles),
];

pub(crate) const SIDE: u32 = 48;

pub(crate) const FORMATS: [TextureFormat; 3] =
    [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];

/// The texels of a map after a pass.
pub(crate) fn map(
    gpu: &Gpu,
    format: TextureFormat,
    light: &ShadowCamera,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<(), String>,
) -> Result<Vec<f32>, String> {
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let target = texture(gpu, [SIDE; 2], format, &[far; (SIDE * SIDE) as usize])?;
    pass(gpu, &target, (Some(wgpu::LoadOp::Load), None), draw)?;
    read(gpu, &target)
}

/// Texels that are wrong, of those where nearby rays bound the depth.
fn wrong(tracer: &rays::Tracer<()>, light: &ShadowCamera, depths: &[f32], step: f32) -> [usize; 2] {
    let rays = Rays::new(light, SIDE);
    let far = if light.depth == DepthDirection::Reversed { 0.0 } else { 1.0 };
    let seen = |pixel: DVec2| {
        let (from, direction) = rays.at(pixel);
        let near = tracer.meetings((from, direction)).map(|(t, _)| t).filter(|t| *t > 0.0).min_by(f64::total_cmp);
        near.map_or(far, |t| device_depth(light, from + t * direction))
    };
    let mut counts = [0, 0];
    for (texel, &found) in (0..).zip(depths) {
        let middle = middle(texel, SIDE);
        let around = [[0.0, 0.0], [0.05, 0.05], [-0.05, 0.05], [0.05, -0.05], [-0.05, -0.05]];
        let around = around.map(|offset| seen(middle + DVec2::from_array(offset)));
        let low = around.iter().copied().fold(f32::INFINITY, f32::min);
        let high = around.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        counts[0] += usize::from(found < low - step || found > high + step);
        counts[1] += usize::from(found != far);
    }
    counts
}

/// A caster of a test. With `buffer`, its positions lie there, in world space.
pub(crate) struct Placed {
    shape: usize,
    rows: Matrix3x4,
    /// Its vertices in world space.
    world: Vec<DVec3>,
    buffer: Option<(wgpu::Buffer, u64, u64)>,
    pub(crate) handle: CasterHandle,
}

pub(crate) struct Casters {
    shapes: Vec<(Shape, Mesh)>,
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

    fn meshes(&mut self) -> Result<Vec<rimline::gpu::MeshHandle>, String> {
        let shapes = &self.shapes;
        shapes.iter().map(|(shape, mesh)| self.scene.add_mesh(mesh, &shape.positions).map_err(text)).collect()
    }

    /// Adds `count` rigid casters, and as many with positions in two buffers, of odd offsets and strides.
    pub(crate) fn fill(&mut self, gpu: &Gpu, random: &mut Random, (count, spread): (usize, f32)) -> Result<(), String> {
        let meshes = self.meshes()?;
        let in_world =
            |shape: &Shape, rows: &Matrix3x4| shape.positions.iter().map(|&at| to_world(rows, at)).collect::<Vec<_>>();
        for number in 0..count {
            let shape = random.below(3);
            let rows = if number % 4 == 1 { IDENTITY } else { rows(random, spread, number) };
            let handle = self.scene.insert(Caster::rigid(meshes[shape], rows)).map_err(text)?;
            let world = in_world(&self.shapes[shape].0, &rows);
            self.placed.push(Placed { shape, rows, world, buffer: None, handle });
        }
        for _ in 0..2 {
            let (mut words, mut of_buffer) = (vec![3.0_f32; 5], Vec::new());
            for number in 0..count / 2 {
                let (shape, rows, stride) = (random.below(3), rows(random, spread, number), 3 + random.below(3));
                let world = in_world(&self.shapes[shape].0, &rows).into_iter().map(DVec3::as_vec3);
                let (world, offset): (Vec<_>, _) = (world.collect(), 4 * words.len() as u64);
                for position in &world {
                    words.extend(position.to_array());
                    words.extend(vec![f32::NAN; stride - 3]);
                }
                let world: Vec<_> = world.into_iter().map(glam::Vec3::as_dvec3).collect();
                of_buffer.push((shape, world, offset, 4 * stride as u64));
            }
            let buffer = gpu.storage(&words);
            for (shape, world, offset, stride) in of_buffer {
                let positions = PositionBuffer { buffer: &buffer, offset, stride };
                let handle = self.scene.insert(Caster::in_buffer(meshes[shape], positions)).map_err(text)?;
                let buffer = Some((buffer.clone(), offset, stride));
                self.placed.push(Placed { shape, rows: IDENTITY, world, buffer, handle });
            }
        }
        Ok(())
    }

    /// States the boxes of casters in buffers.
    fn state_bounds(&mut self) -> Result<(), String> {
        for caster in self.placed.iter().filter(|caster| caster.buffer.is_some()) {
            let bound =
                |pick: fn(DVec3, DVec3) -> DVec3| caster.world.iter().copied().reduce(pick).unwrap_or(DVec3::ZERO);
            let bounds = [bound(DVec3::min), bound(DVec3::max)].map(|bound| bound.as_vec3().to_array());
            self.scene.set_bounds(caster.handle, Some(bounds)).map_err(text)?;
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
        let faces = |caster: &Placed| self.shapes[caster.shape].0.faces.clone();
        self.placed.iter().flat_map(move |caster| {
            faces(caster).into_iter().map(|face| face.map(|vertex| caster.world[vertex as usize]))
        })
    }
}

/// A light that sees casters around the origin, or a part of them.
fn light(random: &mut Random, number: usize) -> ShadowCamera {
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][number % 2];
    let (far, half_width) = [(None, None), (Some(12.0), None), (Some(12.0), Some(3.0))][number / 2 % 3];
    let forward = vector(random);
    Eye { is_relative: random.below(2) == 0, depth, far, half_width, ..look(-6.0 * forward, forward, 1.0) }.camera()
}

/// Casters near the middle, rigid ones and in buffers, and casters that spread so far that some are culled. Boxes of the
/// latter are stated.
fn equal() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1714)?;
    let (mut culled, mut all, mut texels) = (0, 0, 0);
    for number in 0..if is_long() { 96 } else { 24 } {
        let is_far = number % 2 == 1;
        let mut casters = Casters::new(&gpu)?;
        casters.fill(&gpu, &mut random, if is_far { (24, 8.0) } else { (12, 2.0) })?;
        if is_far {
            casters.state_bounds()?;
        }
        let (light, format) = (light(&mut random, number / 2), FORMATS[number / 2 % 3]);
        let (found, counts) = casters.drawn(&gpu, format, &light, SceneDepthCasters::All)?;
        let truth = casters.one_by_one(&gpu, format, &light, |_| true)?;
        let what = format!("scene {number}, {format:?} {:?}", light.depth);
        same(&what, &bits(&found), &bits(&truth))?;
        // One draw for the page, and one for each buffer.
        let is_drawn = counts.draws == 3 || is_far && counts.draws < 3;
        if !is_drawn || counts.drawn + counts.outside != casters.placed.len() {
            return Err(format!("{what}: {counts:?}"));
        }
        if is_far {
            culled += counts.outside;
            all += counts.outside + counts.drawn;
            continue;
        }
        // Bound on the rounding of `f32` depths, or the step of the map's format. The negative control is another column.
        let step = if format == TextureFormat::Depth16Unorm { 1.0 / 65_535.0 } else { 2e-6 };
        let tracer = rays::Tracer::build(casters.triangles().map(|corners| (corners, ())));
        let mut moved = found.clone();
        moved.rotate_right(3);
        let ([bad, seen], [noticed, _]) = (wrong(&tracer, &light, &found, step), wrong(&tracer, &light, &moved, step));
        texels += seen;
        if bad > 0 || noticed < 50 {
            return Err(format!("{what}: {bad} wrong of {seen}, {noticed} if moved"));
        }
        let mut missing = 0;
        for at in 0..if number == 0 { casters.placed.len() } else { 0 } {
            // Negative control: each caster is missing in turn.
            let other = casters.one_by_one(&gpu, format, &light, |number| number != at)?;
            missing += usize::from(bits(&other) != bits(&found));
        }
        if number == 0 && missing * 2 <= casters.placed.len() {
            return Err(format!("{missing} missing casters are noticed"));
        }
    }
    println!("{texels} texels compared; {culled} of {all} culled");
    // A caster without a box is drawn. A box out of the map culls a caster, even if its vertices are in the map.
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (8, 0.1))?;
    let light = light(&mut random, 0);
    let in_buffer = casters.placed.iter().rfind(|caster| caster.buffer.is_some()).map(|caster| caster.handle);
    let in_buffer = in_buffer.ok_or("a caster has a buffer")?;
    for (bounds, outside) in [(None, 0), (Some([[900.0; 3], [901.0; 3]]), 1)] {
        casters.scene.set_bounds(in_buffer, bounds).map_err(text)?;
        let (_, counts) = casters.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
        same("culled", &[counts.outside], &[outside])?;
    }
    let is_tried = texels > 4000 && culled * 4 > all && culled * 10 < all * 9;
    if is_tried { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// Draws see the scene as it is when they are recorded, encoded or not.
fn changed() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1715)?;
    let mut casters = Casters::new(&gpu)?;
    casters.fill(&gpu, &mut random, (12, 2.0))?;
    let light = light(&mut Random::new(1715), 0);
    let mut before = Vec::new();
    for round in 0..8 {
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
    let listed: Vec<_> = casters.placed.iter().skip(1).step_by(3).map(|caster| caster.handle).collect();
    for &caster in &listed {
        casters.scene.set_lights(caster, LightMask::ALL.without(of_scene)).map_err(text)?;
    }
    let twice = [&listed[..], &listed[..]].concat();
    // Only those, all others, all, and none.
    let kinds: [fn(usize) -> bool; 4] = [|at| at % 3 == 1, |at| at % 3 != 1, |_| true, |_| false];
    let truths = kinds.map(|kind| casters.one_by_one(&gpu, FORMATS[0], &light, kind));
    for (which, kind) in [
        (SceneDepthCasters::Only(&listed), 0),
        (SceneDepthCasters::Only(&twice), 0),
        (SceneDepthCasters::Except(&listed), 1),
        (SceneDepthCasters::NotCastingFor(of_scene), 0),
        (SceneDepthCasters::Except(&[]), 2),
        (SceneDepthCasters::Only(&[]), 3),
    ] {
        let what = format!("{which:?}");
        let found = bits(&casters.drawn(&gpu, FORMATS[0], &light, which)?.0);
        for (other, truth) in truths.iter().enumerate() {
            let outcome = same(&what, &found, &bits(truth.as_ref()?));
            let outcome = if other == kind { outcome } else { must_fail(&what, &outcome) };
            outcome?;
        }
    }
    // A scene without casters, and one whose casters have singular transforms. The negative control is the unit matrix.
    let mut empty = Casters::new(&gpu)?;
    let none = bits(truths[3].as_ref()?);
    let mesh = empty.meshes()?[0];
    let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
    let not_finite = [[f32::NAN, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    for rows in [None, Some(flat), Some(not_finite), Some(IDENTITY)] {
        if let Some(rows) = rows {
            let handle = empty.scene.insert(Caster::rigid(mesh, rows)).map_err(text)?;
            empty.placed.push(Placed { shape: 0, rows, world: Vec::new(), buffer: None, handle });
        }
        let (found, counts) = empty.drawn(&gpu, FORMATS[0], &light, SceneDepthCasters::All)?;
        let each = empty.one_by_one(&gpu, FORMATS[0], &light, |_| true)?;
        same("one by one", &bits(&found), &bits(&each))?;
        let is_nothing = bits(&found) == none && counts == SceneDepthCounts::default();
        same(&format!("nothing of {rows:?}"), &[is_nothing], &[rows != Some(IDENTITY)])?;
    }
    Ok(())
}

/// Meshes without a triangle, and polygons that are walked back, draw nothing.
fn without_triangles() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let light = crate::stages::camera(DepthDirection::Reversed);
    let corners = [[1.0, -3.0, 3.0], [4.0, -3.0, 3.0], [2.5, -3.0, 6.0]];
    let walked_back = PolygonLoops { polygon_loops: &[1], loop_sizes: &[4], loop_corners: &[0, 1, 1, 0] };
    let drawn = |mesh: &Mesh| {
        let buffer = gpu.storage(&corners);
        let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        let renderer = MeshDepth::new(&gpu.pipelines, mesh, FORMATS[0], light.depth).map_err(text)?;
        map(&gpu, FORMATS[0], &light, |pass| renderer.draw(pass, positions, &light).map_err(text))
    };
    let nothing = map(&gpu, FORMATS[0], &light, |_| Ok(()))?;
    for mesh in [
        Mesh::from_faces(1, vec![[0; 3]]),
        Mesh::from_polygons(&corners, walked_back, Weld::Keep),
        Mesh::from_polygons_by_loop(&corners, walked_back, Weld::Keep),
    ] {
        same("depths", &drawn(&mesh.map_err(text)?)?, &nothing)?;
    }
    let face = Mesh::from_faces(3, vec![[0, 1, 2]]).map_err(text)?;
    must_fail("a face", &same("depths", &drawn(&face)?, &nothing))
}
