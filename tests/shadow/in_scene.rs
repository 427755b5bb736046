//! Many casters in one scene: with faces excluded, and with matrices and far away.

use glam::{DMat3, DQuat, DVec3};
use rimline::gpu::{
    Caster, CasterHandle, CasterPositions, FrameInputs, LightHandle, LightMask, Measuring, Receivers, Scene,
    SceneFrame, SceneOptions, ShadowError, ShadowFormat, ShadowPipelines, View,
};
use rimline::internals::layout::{ShadowLight, ShadowStatistics};
use rimline::internals::shadow::CAST_BACK_FACING;
use rimline::mesh::Weld;
use rimline::{Counting, Light, Matrix3x4, Mesh, ShadowCamera};

use crate::compare::Compared;
use crate::render::{Counted, Placing, Renderer};
use crate::trials::{RIGHT, Tally, Test, Traced, every, rotated, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::{Body, Eye, Frame, vector};
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::shapes::Shape;

pub(crate) const TESTS: &[Test] = &[
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
    let clusters_from = SceneOptions::default().clusters_from;
    let mut options = SceneOptions { max_lights, counting, clusters_from, ..renderer.options };
    options.stencil.count_batches = renderer.count_batches;
    options.measuring.set(Measuring::CACHED_LISTS, false);
    // Counts of all casters, unless a test asks for dark and lit alone.
    options.measuring.set(Measuring::CULLED_BY_OCCLUDERS, true);
    if let Some((levels, has_clusters)) = renderer.levels {
        options.measuring.set(Measuring::CULL_NOTHING, true);
        for &level in levels {
            options.measuring.set(level, false);
        }
        options.clusters_from = has_clusters.then_some(1);
    }
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
            let Shape { mut faces, mut positions } = body.shape.clone();
            let placed = match (renderer.placing, body.mirror) {
                (Placing::Moved(_), _) => {
                    let (mesh_positions, matrix) = turned(&mut random, body);
                    positions = mesh_positions;
                    CasterPositions::Rigid(matrix.into())
                }
                (_, Some(mirror)) => {
                    // Mirroring twice is nothing.
                    for p in &mut positions {
                        *p = (glam::Vec3::from(*p) * mirror).to_array();
                    }
                    for face in &mut faces {
                        face.swap(1, 2);
                    }
                    CasterPositions::Rigid(rows(mirror.to_array()).into())
                }
                (_, None) => CasterPositions::Buffer { buffer: gpu.storage(&positions), offset: 0, stride: 12 },
            };
            let mesh = match &body.polygons {
                Some(polygons) => polygons.mesh(Weld::Position).map_err(text)?,
                None => Mesh::from_faces(positions.len(), faces).map_err(text)?,
            };
            let triangles = hiding(body, &mesh, &positions, &placed);
            let mesh = scene.add_mesh(&mesh, &positions).map_err(text)?;
            let mask = body.lacks.map_or(LightMask::ALL, |light| LightMask::ALL.without(lights[light]));
            let caster = Caster { mesh, positions: placed, lights: mask, in_depth: body.in_depth };
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
                // Another camera of the same kind.
                let away = vector(&mut random);
                let other = Eye { position: frame.eye.position + away, forward: -away, ..frame.eye };
                let index = if cameras.len() <= view { 0 } else { cameras.len() };
                cameras.insert(index, other.camera());
            }
            // A later encode into the same encoder overwrites this one.
            scene.encode(encoder, FrameInputs::new(&views(&cameras[..=random.below(3)]))).map_err(text)?;
        }
        let mut of_views = views(&cameras);
        of_views[view].depth = receivers;
        if !matches!(renderer.placing, Placing::Moved(_)) {
            // All bits and lists of silhouettes are then those of an encode before.
            for &caster in &casters {
                let set = scene.set_position_version(caster, Some(1));
                set.or_else(|error| if error == ShadowError::NoBuffer { Ok(()) } else { Err(text(error)) })?;
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
        let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, usize::MAX)?;
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
        let statistics = self.frame.shadow_statistics().ok_or("no view")?;
        counted.statistics.extend(gpu.read::<ShadowStatistics>(statistics, 1)?);
        counted.scene = gpu.read(self.frame.statistics(), 1)?.first().copied();
        Ok(())
    }
}

/// Faces at random are excluded for one light of two: they count as if they were not there, where every face casts and where
/// back-facing ones do.
fn excluded() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut changed, mut back_facing) = (0, 0);
    for (index, class) in CLASSES.iter().enumerate().filter(|(_, class)| !class.touches) {
        let seed = seed(class, 230);
        let mut random = Random::new(seed);
        let mut frame = (class.frame)(&mut random);
        frame.size = 64;
        let [x, y, z] = frame.lights[0].xyz;
        frame.lights.push(Light::homogeneous([x + 1.0, y - 0.5, z + 0.25, frame.lights[0].w]));
        frame.bodies.iter_mut().for_each(|body| body.mirror = None);
        let whole = Traced::of(frame.clone(), seed);
        for body in frame.bodies.iter_mut().filter(|body| body.casts) {
            let all = 0..body.shape.faces.len() as u32;
            body.left_out = all.filter(|_| random.below(3) == 0).collect();
        }
        let traced = Traced::of(frame, seed);
        for (counting, every_face) in rotated(&RIGHT, index).into_iter().flat_map(|way| [(way, true), (way, false)]) {
            let mut renderer = Renderer { placing: Placing::Scene, ..Renderer::new(gpu) };
            renderer.options.measuring.set(Measuring::EVERY_FACE, every_face);
            let counted = renderer.count(&traced.frame, counting)?;
            let wrong = |traced: &Traced, light: usize| {
                let compared = Compared { light, ..traced.compared() };
                compared.counts(&counted.stencils[light], &every(&counted, light)).pixels
            };
            for light in [0, 1] {
                if let Some(at) = wrong(&traced, light).first() {
                    return Err(format!("{}, {seed}, {counting:?}, {every_face}, light {light}: {at:?}", class.name));
                }
            }
            changed += usize::from(!wrong(&whole, 0).is_empty());
            back_facing += counted.chosen.iter().filter(|lights| lights[0].casting == CAST_BACK_FACING).count();
        }
    }
    println!("{changed} pictures that excluded faces change, {back_facing} casters of which back-facing faces cast");
    if changed.min(back_facing) < 10 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Rigid casters with matrices of scales from a thousandth to a thousand, mirrored ones among them, a million away.
fn far_away() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut tally = Tally::default();
    for class in CLASSES {
        for number in 220..if is_long() { 260 } else { 222 } {
            let seed = seed(class, number);
            let traced = Traced::of(movable((class.frame)(&mut Random::new(seed))), seed);
            let renderer = Renderer { placing: Placing::Moved(seed), ..Renderer::new(gpu) };
            tally.add(&traced, &renderer, &[Counting::Auto, Counting::ZpPlus], false);
        }
    }
    tally.result("rigid casters far away")
}
