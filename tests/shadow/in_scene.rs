//! Many casters in one scene: in batches, with faces excluded, and with matrices and far away.

use glam::{DMat3, DQuat, DVec3};
use rimline::gpu::{
    Capacities, Caster, CasterHandle, CasterPositions, FrameInputs, LightHandle, LightMask, Measuring, Receivers,
    Scene, SceneFrame, SceneOptions, ShadowError, ShadowFormat, ShadowPipelines, StencilCounts, View,
};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::{ShadowLight, ShadowStatistics};
use rimline::internals::shadow::CAST_BACK_FACING;
use rimline::mesh::Weld;
use rimline::{Counting, Light, Matrix3x4, Mesh, Predicate, ShadowCamera};
use rimline_testkit::OneCasterOptions;

use crate::classes::CLASSES;
use crate::render::{Counted, Placing, Renderer};
use crate::scene::{Body, Eye, Frame, vector};
use crate::trials::{RIGHT, Test, Traced, rotated, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;
use rimline_testkit::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("casters_counted_in_batches_do_not_wrap", batches),
    ("excluded_faces_count_as_if_they_were_not_there", excluded),
    ("rigid_casters_far_away_and_at_any_scale", far_away),
];

/// The casters of a frame in one scene, encoded for the frame's camera.
pub(crate) struct InScene {
    frame: SceneFrame,
    pipelines: ShadowPipelines,
    lights: Vec<LightHandle>,
    casters: Vec<CasterHandle>,
    /// The view that is drawn.
    view: usize,
}

/// How far the world is moved. At this size numbers are eighths apart.
const FAR: [f32; 3] = [1_048_576.0, -1_500_000.0, 1_100_000.0];

/// To whole eighths.
fn rounded(value: f64) -> f64 {
    (8.0 * value).round() / 8.0
}

/// A matrix at random, about a point near the body, and the positions that it brings to where they are.
fn turned(random: &mut Random, body: &Body) -> (Vec<[f32; 3]>, Matrix3x4) {
    let positions = &body.shape.positions;
    let some = positions[random.below(positions.len())].map(f64::from);
    let centre = if some.iter().all(|c| c.is_finite()) { some } else { [0.0; 3] }.map(rounded);
    let scale = [1e-3, 0.1, 1.0, 20.0, 1e3][random.below(5)];
    let [x, y, z] = random.direction().map(f64::from);
    let turn =
        DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(x, y, z).normalize(), f64::from(random.between(0.0, 6.0))));
    let flip = if random.below(3) == 0 { -1.0 } else { 1.0 };
    // The matrix is rounded to `f32`, as in the scene.
    let matrix = (turn * DMat3::from_diagonal(DVec3::new(flip, 1.0, 1.0)) * scale).as_mat3();
    let inverse = matrix.as_dmat3().inverse();
    let to_mesh_space =
        |p: &[f32; 3]| (inverse * (DVec3::from(p.map(f64::from)) - DVec3::from(centre))).as_vec3().to_array();
    let row = |axis: usize| {
        let [x, y, z] = matrix.row(axis).to_array();
        [x, y, z, centre[axis] as f32 + FAR[axis]]
    };
    (positions.iter().map(to_mesh_space).collect(), [row(0), row(1), row(2)])
}

/// A frame whose lights and eye are still the same once they are moved by [`FAR`].
pub(crate) fn movable(mut frame: Frame) -> Frame {
    for light in frame.lights.iter_mut().filter(|light| light.w != 0.0) {
        *light = Light::point(light.xyz.map(|c| rounded(f64::from(c / light.w)) as f32));
    }
    frame.eye.position = DVec3::from(frame.eye.position.to_array().map(rounded));
    frame.eye.is_relative = true;
    frame
}

fn rows(scale: [f32; 3]) -> Matrix3x4 {
    let [x, y, z] = scale;
    [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]]
}

/// Another camera of the same kind.
fn other_view(frame: &Frame, random: &mut Random) -> Eye {
    let away = vector(random);
    let position = frame.eye.position + away;
    Eye { position, forward: -away, ..frame.eye }
}

/// Casters and lights that will be gone.
struct Past {
    casters: Vec<CasterHandle>,
    lights: Vec<LightHandle>,
}

impl Past {
    fn new(
        renderer: &Renderer<'_>,
        scene: &mut Scene,
        frame: &Frame,
        camera: &ShadowCamera,
        random: &mut Random,
    ) -> Result<Self, String> {
        let light = |random: &mut Random| Light::point(random.direction().map(|c| 4.0 * c));
        let mut lights: Vec<_> =
            (0..3).map(|_| scene.add_light(light(random)).map_err(text)).collect::<Result<_, _>>()?;
        let mut casters = Vec::new();
        for body in frame.bodies.iter().take(2) {
            let mesh = Mesh::from_faces(body.shape.positions.len(), body.shape.faces.clone()).map_err(text)?;
            let mesh = scene.add_mesh(&mesh, &body.shape.positions).map_err(text)?;
            let transforms = [[1.0; 3], [0.5, 0.5, 0.5]].map(rows);
            for transform in transforms {
                casters.push(scene.insert(Caster::rigid(mesh, transform)).map_err(text)?);
            }
        }
        renderer
            .gpu
            .submit(|encoder| scene.encode(encoder, FrameInputs::new(&[View::new(*camera); 2])).map_err(text))?;
        // Some go, some move.
        scene.remove(casters.swap_remove(random.below(casters.len()))).map_err(text)?;
        scene.remove_light(lights.swap_remove(random.below(lights.len()))).map_err(text)?;
        scene.set_transform(casters[0], rows([2.0, 1.0, 1.0])).map_err(text)?;
        scene.set_light(lights[0], light(random)).map_err(text)?;
        renderer.gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&[(*camera).into()])).map_err(text))?;
        Ok(Self { casters, lights })
    }

    fn go(self, scene: &mut Scene) -> Result<(), String> {
        self.casters.into_iter().try_for_each(|caster| scene.remove(caster).map_err(text))?;
        self.lights.into_iter().try_for_each(|light| scene.remove_light(light).map_err(text))
    }
}

/// The finite faces of a rigid body that has not too many: what is behind one need not throw shadows.
fn hiding(body: &Body, mesh: &Mesh, mesh_positions: &[[f32; 3]], positions: &CasterPositions) -> Vec<[[f32; 3]; 3]> {
    let is_rigid = matches!(positions, CasterPositions::Rigid(_)) && body.polygons.is_none();
    if !is_rigid || mesh.faces().len() > 100 || !body.left_out.is_empty() {
        return Vec::new();
    }
    let triangles = mesh.faces().iter().map(|face| face.map(|vertex| mesh_positions[vertex as usize]));
    triangles.filter(|triangle| triangle.iter().flatten().all(|c| c.is_finite())).collect()
}

/// Options of a scene that match those of separate volumes.
fn scene_options(renderer: &Renderer<'_>, max_lights: usize, counting: Counting) -> SceneOptions {
    let OneCasterOptions { end_at_range, cap_capacity, .. } = renderer.options;
    let mut options = SceneOptions {
        max_lights,
        capacities: Capacities { lists: renderer.list_capacity, caps: cap_capacity, ..Capacities::default() },
        counting,
        end_at_range,
        stencil: StencilCounts {
            count_bits: renderer.count_bits,
            count_batches: renderer.count_batches,
            bound_counts: renderer.options.bound_counts,
        },
        ..SceneOptions::default()
    };
    options.measuring.set(Measuring::EVERY_FACE, renderer.options.every_face);
    options.measuring.set(Measuring::CULLED_BY_VIEW, !renderer.options.cull_by_view);
    // Counts of all casters, unless a test asks for dark and lit alone.
    options.measuring.set(Measuring::CULLED_BY_OCCLUDERS, true);
    (renderer.levels)(&mut options);
    options
}

impl InScene {
    pub(crate) fn new(
        renderer: &Renderer<'_>,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        counting: Counting,
        format: &ShadowFormat,
        receivers: Option<Receivers<'_>>,
    ) -> Result<Self, String> {
        let gpu = renderer.gpu;
        let options = scene_options(renderer, frame.lights.len() + 3, counting);
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let mut camera = frame.eye.camera();
        let far = if matches!(renderer.placing, Placing::Moved(_)) { FAR } else { [0.0; 3] };
        camera.origin = std::array::from_fn(|axis| camera.origin[axis] + far[axis]);
        let mut random = Random::new(match renderer.placing {
            Placing::Moved(seed) | Placing::Busy(seed) => seed,
            _ => 0,
        });
        let is_busy = matches!(renderer.placing, Placing::Busy(_));
        let past = if is_busy { Some(Past::new(renderer, &mut scene, frame, &camera, &mut random)?) } else { None };
        let mut lights = Vec::new();
        for light in &frame.lights {
            let xyz = std::array::from_fn(|axis| light.xyz[axis] + light.w * far[axis]);
            lights.push(scene.add_light(Light { xyz, range: renderer.range, ..*light }).map_err(text)?);
        }
        let mut casters = Vec::new();
        for body in frame.bodies.iter().filter(|body| body.casts) {
            let mesh = |faces: &[[u32; 3]]| match &body.polygons {
                Some(polygons) => polygons.mesh(Weld::Position).map_err(text),
                None => Mesh::from_faces(body.shape.positions.len(), faces.to_vec()).map_err(text),
            };
            let mirrored = || body.shape.faces.iter().map(|&[a, b, c]| [a, c, b]).collect::<Vec<_>>();
            let (mesh, mesh_positions, positions) = match (renderer.placing, body.mirror) {
                (Placing::Moved(_), _) => {
                    let (mesh_positions, matrix) = turned(&mut random, body);
                    (mesh(&body.shape.faces)?, mesh_positions, CasterPositions::Rigid(matrix.into()))
                }
                (_, Some(mirror)) => {
                    // Mirroring twice is nothing.
                    let mesh_positions =
                        body.shape.positions.iter().map(|&p| (glam::Vec3::from(p) * mirror).to_array());
                    (
                        mesh(&mirrored())?,
                        mesh_positions.collect(),
                        CasterPositions::Rigid(rows(mirror.to_array()).into()),
                    )
                }
                (_, None) => {
                    let buffer = gpu.storage(&body.shape.positions);
                    let positions = CasterPositions::Buffer { buffer, offset: 0, stride: 12 };
                    let faces = body.instead.as_ref().unwrap_or(&body.shape.faces);
                    (mesh(faces)?, body.shape.positions.clone(), positions)
                }
            };
            let triangles = hiding(body, &mesh, &mesh_positions, &positions);
            let mesh = scene.add_mesh(&mesh, &mesh_positions).map_err(text)?;
            let mask = body.lacks.map_or(LightMask::ALL, |light| LightMask::ALL.without(lights[light]));
            let caster = Caster { mesh, positions, lights: mask, in_depth: body.in_depth };
            // Some are elsewhere at first.
            let caster = if is_busy && random.below(2) == 0 {
                let positions = CasterPositions::Rigid(rows([2.0, 1.0, 1.0]).into());
                let elsewhere = scene.insert(Caster { positions, ..caster.clone() }).map_err(text)?;
                scene.set_positions(elsewhere, caster.positions).map_err(text)?;
                elsewhere
            } else {
                scene.insert(caster).map_err(text)?
            };
            if !triangles.is_empty() {
                let polygons: Vec<&[[f32; 3]]> = triangles.iter().map(|triangle| &triangle[..]).collect();
                scene.set_occluders(caster, &polygons).map_err(text)?;
            }
            if !body.left_out.is_empty() {
                // The last call replaces the earlier one.
                scene.set_excluded(caster, lights[0], &[0]).map_err(text)?;
                scene.set_excluded(caster, lights[0], &body.left_out).map_err(text)?;
            }
            casters.push(caster);
        }
        let is_in_batches = renderer.count_batches > 1;
        let make = if is_in_batches { ShadowPipelines::in_batches } else { ShadowPipelines::new };
        let pipelines = make(&gpu.pipelines, format, counting).map_err(text)?;
        let mut cameras = vec![camera];
        let mut view = 0;
        if let Some(past) = past {
            // Recorded, but never submitted.
            let mut dropped = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            scene.encode(&mut dropped, FrameInputs::new(&views(&cameras))).map_err(text)?;
            past.go(&mut scene)?;
            view = random.below(3);
            while cameras.len() <= 2 {
                let index = if cameras.len() <= view { 0 } else { cameras.len() };
                cameras.insert(index, other_view(frame, &mut random).camera());
            }
            // A later encode into the same encoder overwrites this one.
            scene.encode(encoder, FrameInputs::new(&views(&cameras[..=random.below(3)]))).map_err(text)?;
        }
        let mut of_views = views(&cameras);
        of_views[view].depth = receivers;
        if !matches!(renderer.placing, Placing::Moved(_)) {
            // All bits and lists of silhouettes are then those of an encode before.
            for &caster in &casters {
                match scene.set_position_version(caster, Some(1)) {
                    Ok(()) | Err(ShadowError::NoBuffer) => {}
                    Err(error) => return Err(text(error)),
                }
            }
            scene.encode(encoder, FrameInputs::new(&of_views)).map_err(text)?;
        }
        let frame = scene.encode(encoder, FrameInputs::new(&of_views)).map_err(text)?;
        Ok(Self { frame, pipelines, lights, casters, view })
    }

    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), String> {
        self.frame.draw(pass, &self.pipelines, self.view, self.lights[light]).map_err(text)
    }

    /// Reads only which faces cast, and whether near caps may be needed.
    pub(crate) fn read(&self, gpu: &Gpu, counted: &mut Counted) -> Result<(), String> {
        let results = self.frame.results().map_err(text)?;
        let choices = results.choices.ok_or("no view")?;
        let words: Vec<u32> = gpu.read(choices, usize::MAX)?;
        let first = 8 * self.view * self.frame.batches() * self.casters.len();
        for &caster in &self.casters {
            let (index, _) = self.frame.locate(caster).ok_or("the caster is not in the frame")?;
            let chosen = |light: &LightHandle| {
                let batch = light.bit() as usize / 32;
                let at = first + 8 * (batch * self.casters.len() + index as usize);
                let is_set = |word: usize| words[at + word] >> (light.bit() % 32) & 1;
                let casting = is_set(0) + (is_set(0) & is_set(1));
                ShadowLight { casting, counting: is_set(2), ..bytemuck::Zeroable::zeroed() }
            };
            counted.chosen.push(self.lights.iter().map(chosen).collect());
        }
        let (receivers, words) = results.receivers.ok_or("no view")?;
        let all: Vec<u32> = gpu.read(receivers, usize::MAX)?;
        counted.receivers = all[1 + self.view * words as usize..][..words as usize].to_vec();
        let statistics = self.frame.shadow_statistics().ok_or("no view")?;
        counted.statistics.extend(gpu.read::<ShadowStatistics>(statistics, 1)?);
        counted.scene = gpu.read(self.frame.statistics(), 1)?.first().copied();
        Ok(())
    }
}

/// Cubes around each other between light and eye: 256 and 300 of them, counted at once and in batches. In frames of all
/// classes the same pixels are dark both ways.
fn batches() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let dark =
        |counted: &Counted, light: usize| counted.stencils[light].iter().map(|&count| count != 0).collect::<Vec<_>>();
    let options = OneCasterOptions { bound_counts: true, ..OneCasterOptions::default() };
    let renderer = |count_batches| Renderer { placing: Placing::Scene, count_batches, options, ..Renderer::new(gpu) };
    for count in [256, 300] {
        let mut frame = (CLASSES[0].frame)(&mut Random::new(7));
        frame.bodies =
            (0..count).map(|shell| Body::caster(shapes::cube()).scaled(1.0 + 0.001 * shell as f32)).collect();
        frame.bodies.push(Body::room([0.0; 3], 20.0));
        frame.lights = vec![Light::point([0.1, 9.0, 0.2])];
        // Below the cubes, looking at the floor, which is in their shadow.
        let position = DVec3::new(0.0, -17.0, 0.0);
        frame.eye = Eye { position, forward: DVec3::new(0.01, -1.0, 0.02), near: 0.1, ..frame.eye };
        frame.size = 32;
        for counting in [Counting::Auto, Counting::ZFail] {
            let at_once = renderer(1).count(&frame, counting)?;
            let all_dark = |counted: &Counted| dark(counted, 0).iter().all(|&dark| dark);
            if all_dark(&at_once) == (count == 256) {
                return Err(format!("{count} shells, {counting:?}, at once: {:?}", &at_once.stencils[0][..8]));
            }
            let in_batches = renderer(3).count(&frame, counting)?;
            let [whole, batch] = [&at_once, &in_batches].map(|counted| counted.statistics[0]);
            println!("{count} shells, {counting:?}: bounds {} and {}", whole.count_bound, batch.count_bound);
            if whole.count_bound < count || whole.may_wrap != 1 || batch.count_bound < count / 3 || batch.may_wrap != 0
            {
                return Err(format!("{count} shells, {counting:?}: {whole:?}, in batches {batch:?}"));
            }
            if !all_dark(&in_batches) {
                return Err(format!("{count} shells, {counting:?}, in batches: {:?}", &in_batches.stencils[0][..8]));
            }
        }
    }
    let (mut resolved, mut bounded) = (0, 0);
    for (index, class) in CLASSES.iter().enumerate() {
        let seed = seed(class, 240);
        let mut frame = (class.frame)(&mut Random::new(seed));
        frame.bodies.iter_mut().for_each(|body| body.mirror = None);
        frame.size = 48;
        // z-pass is wrong in shadows: wrong counts of two casters may cancel.
        for counting in rotated(&RIGHT, index) {
            let at_once = renderer(1).count(&frame, counting)?;
            let mut in_batches = renderer(2).count(&frame, counting)?;
            let what = format!("{}, seed {seed}, {counting:?}", class.name);
            same(&what, &dark(&in_batches, 0), &dark(&at_once, 0))?;
            let deepest = at_once.stencils.iter().flatten().max().copied().unwrap_or(0);
            let within = |bound: u32| {
                if u32::from(deepest) <= bound { Ok(()) } else { Err(format!("{what}: {deepest}, bound {bound}")) }
            };
            within(at_once.statistics[0].count_bound)?;
            if deepest > 0 {
                must_fail("a bound of less", &within(u32::from(deepest) - 1))?;
                bounded += 1;
            }
            resolved += in_batches.stencils[0].iter().filter(|&&count| count >= 0x80).count();
            in_batches.stencils[0][5] = u8::from(in_batches.stencils[0][5] == 0);
            must_fail("a light in the dark", &same(&what, &dark(&in_batches, 0), &dark(&at_once, 0)))?;
        }
    }
    println!("{resolved} pixels that the first of two batches darkens, {bounded} pictures with a bound");
    if resolved < 1000 || bounded < 20 { Err("too few".to_owned()) } else { Ok(()) }
}

/// Faces at random are excluded for one light of two: where every face casts, as a mesh without these faces; where
/// back-facing faces cast, as the back-facing faces without these, each of which casts.
fn excluded() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut changed, mut back_facing_casters) = (0, 0);
    for (index, class) in CLASSES.iter().enumerate() {
        let seed = seed(class, 230);
        let mut random = Random::new(seed);
        let mut frame = (class.frame)(&mut random);
        frame.size = 48;
        let [x, y, z] = frame.lights[0].xyz;
        frame.lights.push(Light::homogeneous([x + 1.0, y - 0.5, z + 0.25, frame.lights[0].w]));
        frame.bodies.iter_mut().for_each(|body| body.mirror = None);
        let whole = frame.clone();
        for body in frame.bodies.iter_mut().filter(|body| body.casts) {
            let all = 0..body.shape.faces.len() as u32;
            body.left_out = all.filter(|_| random.below(3) == 0).collect();
        }
        for counting in rotated(&RIGHT, index) {
            let count = |frame: &Frame, every_face: bool| {
                let options = OneCasterOptions { every_face, ..OneCasterOptions::default() };
                Renderer { placing: Placing::Scene, options, ..Renderer::new(gpu) }.count(frame, counting)
            };
            let what = format!("{}, seed {seed}, {counting:?}", class.name);
            for every_face in [true, false] {
                let found = count(&frame, every_face)?;
                let without = count(&whole, every_face)?;
                same(&format!("{what}, the other light"), &found.stencils[1], &without.stencils[1])?;
                let mut reduced = frame.clone();
                let casters = reduced.bodies.iter_mut().filter(|body| body.casts);
                for (body, chosen) in casters.zip(&found.chosen) {
                    let back_facing_only = chosen[0].casting == CAST_BACK_FACING;
                    back_facing_casters += usize::from(back_facing_only);
                    let facing = cpu::facing(
                        &body.shape.positions,
                        &body.shape.faces,
                        &frame.lights[..1],
                        Predicate::Exact,
                        Threads::ONE,
                    );
                    let left_out = std::mem::take(&mut body.left_out);
                    let is_left = |face: &(u32, u32)| left_out.binary_search(&face.0).is_err();
                    let casts = |face: &(u32, u32)| is_left(face) && !(back_facing_only && face.1 & 1 != 0);
                    let left = (0..).zip(facing).filter(casts).map(|(face, _)| body.shape.faces[face as usize]);
                    body.instead = Some(left.collect());
                }
                let expected = count(&reduced, true)?;
                let compare =
                    |found: &Counted| same(&format!("{what}, {every_face}"), &found.stencils[0], &expected.stencils[0]);
                compare(&found)?;
                if found.stencils[0] != without.stencils[0] {
                    changed += 1;
                    must_fail("no exclusion", &compare(&without))?;
                }
            }
        }
    }
    println!(
        "{changed} pictures that excluded faces change, {back_facing_casters} casters of which back-facing faces cast"
    );
    if changed.min(back_facing_casters) < 10 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Rigid casters with matrices of scales from a thousandth to a thousand, mirrored ones among them, a million away.
fn far_away() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut shadowed, mut failures, mut hairlines) = (0, Vec::new(), 0);
    for class in CLASSES {
        for number in 220..if is_long() { 260 } else { 222 } {
            let seed = seed(class, number);
            let frame = movable((class.frame)(&mut Random::new(seed)));
            let traced = Traced::of(frame, seed);
            shadowed += traced.shadowed();
            for counting in [Counting::Auto, Counting::ZpPlus] {
                let renderer = Renderer { placing: Placing::Moved(seed), ..Renderer::new(gpu) };
                match traced.check(&renderer, counting, false) {
                    Ok((wrong, _)) => hairlines += wrong.hairlines.len(),
                    Err(error) => failures.push(format!("{}: {error}", class.name)),
                }
            }
        }
    }
    println!("{shadowed} pixels in shadow, {hairlines} on hairlines");
    match failures.first() {
        Some(first) => Err(format!("{} frames, first {first}", failures.len())),
        None if shadowed < 10_000 => Err("too few pixels in shadow".to_owned()),
        None => Ok(()),
    }
}
