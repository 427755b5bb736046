//! Ten thousand casters, thirty-two lights and three views: what is chosen and how much is drawn, against the twins caster by
//! caster.

use glam::{DQuat, DVec3};
use rimline::gpu::{Caster, Scene, SceneOptions};
use rimline::reference::cpu::{self, CastingBox, CastingSide, Threads};
use rimline::reference::layout::{ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics, ShadowView, StencilPencil};
use rimline::reference::shadow::{self, CAST_NOTHING, COUNT_AUTO};
use rimline::{Light, Matrix3x4, Mesh, Predicate, ShadowCamera};

use crate::scene::Eye;
use crate::sides;
use crate::trials::Test;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{must_fail, same};

pub(crate) const TESTS: &[Test] = &[("ten_thousand_casters_are_chosen_and_drawn_as_by_the_twins", thousands)];

const CASTERS: usize = 10_000;
const LIGHTS: usize = 32;

fn rows(turn: DQuat, scale: f64, place: [f32; 3]) -> Matrix3x4 {
    let matrix = (glam::DMat3::from_quat(turn) * scale).as_mat3();
    [0, 1, 2].map(|axis| {
        let [x, y, z] = matrix.row(axis).to_array();
        [x, y, z, place[axis]]
    })
}

fn columns(rows: &Matrix3x4) -> [[f64; 3]; 4] {
    std::array::from_fn(|column| std::array::from_fn(|row| f64::from(rows[row][column])))
}

/// A camera as a caster with this matrix sees it.
fn view_of(view: &ShadowView, rows: &Matrix3x4) -> ShadowView {
    let placement = std::array::from_fn(|axis| {
        let [x, y, z, w] = rows[axis];
        [x, y, z, w + view.placement[axis][3]]
    });
    ShadowView { placement, ..*view }
}

/// A light as a caster sees it.
fn light_of(seen: &ShadowLight, light: Light, rows: &Matrix3x4) -> Option<ShadowLight> {
    let [x, y, z, _] = light.to_mesh_space(&columns(rows))?.to_array();
    let [.., w] = seen.light;
    Some(ShadowLight { light: [x * seen.scale, y * seen.scale, z * seen.scale, w], ..*seen })
}

/// Numbers of a light's instances over all casters: plain and clipped sides, near caps of both classes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Drawn([u32; 4]);

/// The meshes, and of each its box.
struct Model {
    shape: Shape,
    mesh: Mesh,
    bounds: [u32; 7],
    is_closed: bool,
}

impl Model {
    fn new(shape: Shape) -> Result<Self, String> {
        let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).map_err(text)?;
        let bounds = cpu::bounds(&shape.positions, mesh.faces());
        let counts = mesh.edges().counts();
        let is_closed = counts.boundary + counts.inconsistent == 0;
        Ok(Self { shape, mesh, bounds, is_closed })
    }

    /// Choices for a light, its draw, and the edges of its sides, in mesh space.
    fn draw(
        &self,
        view: &ShadowView,
        light: ShadowLight,
        in_mesh_space: Light,
    ) -> (ShadowLight, Drawn, Vec<[[f32; 3]; 2]>) {
        let shape = ShadowShape {
            averted: u32::from(self.is_closed),
            counting: COUNT_AUTO,
            skip_unseen: 1,
            skip_unreached: 1,
            ..bytemuck::Zeroable::zeroed()
        };
        let mut lights = [light];
        cpu::choose(&shape, view, self.bounds, true, &mut lights);
        if lights[0].casting == CAST_NOTHING {
            return (lights[0], Drawn::default(), Vec::new());
        }
        let (positions, faces) = (&self.shape.positions, self.mesh.faces());
        let facing = cpu::facing(positions, faces, &[in_mesh_space], Predicate::Exact, Threads::ONE);
        let excluded = cpu::excluded(positions, faces, &[in_mesh_space]);
        let caps = cpu::caps(view, positions, faces, &facing, &excluded, &lights, true);
        let capped = !caps[0][0].is_empty() || !caps[0][1].is_empty();
        let [plain, clipped] = &sides::lists(&self.mesh, (0, &lights[0]), [&facing, &excluded], capped);
        let drawn = Drawn([plain, clipped, &caps[0][0], &caps[0][1]].map(|list| list.len() as u32));
        let ends = |entry: &u32| {
            self.mesh.edges().vertices()[(entry & !cpu::WINDING) as usize].map(|vertex| positions[vertex as usize])
        };
        (lights[0], drawn, plain.iter().chain(clipped).map(ends).collect())
    }

    /// Box and sides that bound the counts of a caster.
    fn casting(&self, rows: &Matrix3x4, sides: &[[[f32; 3]; 2]]) -> (CastingBox, Vec<CastingSide>) {
        let sum = |[a, b, c]: [f32; 3]| a + b + c;
        let place = |[x, y, z]: [f32; 3]| rows.map(|[a, b, c, d]| sum([a * x, b * y, c * z]) + d);
        let corners = |pick: fn(f32, f32) -> f32| {
            self.shape.positions.iter().copied().reduce(|p, q| [0, 1, 2].map(|axis| pick(p[axis], q[axis])))
        };
        let [low, high] = [corners(f32::min), corners(f32::max)].map(Option::unwrap_or_default);
        let end = |pick: fn(f32, f32) -> f32| {
            rows.map(|[a, b, c, d]| {
                sum([pick(a * low[0], a * high[0]), pick(b * low[1], b * high[1]), pick(c * low[2], c * high[2])]) + d
            })
        };
        let own = CastingBox { low: end(f32::min), high: end(f32::max), faces: self.mesh.faces().len() as u32 };
        (own, sides.iter().map(|ends| (ends.map(place), 1)).collect())
    }
}

fn light(random: &mut Random, number: usize) -> Light {
    match number % 4 {
        0 => Light::directional(random.direction()),
        // Among the casters.
        3 => Light::point(random.direction().map(|c| 25.0 * c)),
        _ => Light::point(random.direction().map(|c| 75.0 * c)),
    }
}

fn camera(random: &mut Random) -> ShadowCamera {
    let place = DVec3::from(random.direction().map(|c| f64::from(30.0 * c)));
    let eye = Eye {
        place,
        forward: -place,
        near: 0.1,
        is_relative: true,
        depth: rimline::DepthDirection::Reversed,
        far: None,
        half_width: None,
    };
    eye.camera()
}

fn placement(random: &mut Random) -> Matrix3x4 {
    let [x, y, z] = random.direction().map(f64::from);
    let turn = DQuat::from_axis_angle(DVec3::new(x, y, z).normalize(), f64::from(random.between(0.0, 6.0)));
    let place = [(); 3].map(|()| random.between(-40.0, 40.0));
    rows(turn, f64::from(random.between(0.2, 1.5)), place)
}

fn thousands() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 301;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let models = [Model::new(shapes::cube())?, Model::new(shapes::plane_grid(2, 2))?];
    // Room for every side and cap.
    let options = SceneOptions { max_lights: LIGHTS, list_capacity: Some(1 << 20), ..SceneOptions::default() };
    let options = SceneOptions { cap_capacity: Some(1 << 18), bound_counts: true, ..options };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let mut meshes = Vec::new();
    for model in &models {
        meshes.push(scene.add_mesh(&model.mesh, &model.shape.positions).map_err(text)?);
    }
    let mut casters = Vec::new();
    for number in 0..CASTERS {
        let rows = placement(&mut random);
        let model = usize::from(number % 5 == 0);
        casters.push((model, rows, scene.insert(Caster::rigid(meshes[model], rows)).map_err(text)?));
    }
    let lights: Vec<Light> = (0..LIGHTS).map(|number| light(&mut random, number)).collect();
    for &light in &lights {
        scene.add_light(light).map_err(text)?;
    }
    let cameras = [(); 3].map(|()| camera(&mut random));
    let frame = gpu.submit(|encoder| scene.encode(encoder, &cameras, None).map_err(text))?;
    let results = frame.results().map_err(text)?;
    let draws: Vec<ShadowDraws> = gpu.read(&results.shadow_draws[0], 3 * LIGHTS)?;
    let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, usize::MAX)?;
    let statistics: Vec<ShadowStatistics> = gpu.read(frame.shadow_statistics().ok_or("no view")?, 1)?;
    let statistics = statistics[0];
    println!("{statistics:?}, {} bytes", results.bytes);
    if results.groups.len() != 1 || statistics.overflowed_sides + statistics.overflowed_caps > 0 {
        return Err("not as meant".to_owned());
    }
    let [pencils, crossings] = results.bound.ok_or("no bound")?;
    let pencils: Vec<StencilPencil> = gpu.read(pencils, usize::MAX)?;
    let crossings: Vec<u32> = gpu.read(crossings, usize::MAX)?;
    let row = crossings.len() / pencils.len();
    let bounds: Vec<u32> = crossings.chunks(row).map(cpu::stencil_bound).collect();
    let of_all = [*bounds.iter().max().unwrap_or(&0), bounds.iter().filter(|&&bound| bound > 255).count() as u32];
    same("bounds of all lights", &[statistics.count_bound, statistics.may_wrap], &of_all)?;
    println!("bounds {bounds:?}");
    let mut kinds = [0; 3];
    let mut near = 0;
    // Each view with lights of its own.
    for (number, camera) in cameras.iter().enumerate() {
        let view = shadow::view(camera).map_err(text)?;
        for bit in [4 * number, 4 * number + 1, 30 - 3 * number, 31 - number] {
            let seen = shadow::light(camera, &view, lights[bit]);
            let mut expected = Drawn::default();
            let mut casting = Vec::new();
            for (model, rows, _) in &casters {
                let light = light_of(&seen, lights[bit], rows).ok_or("no light in mesh space")?;
                let [x, y, z, w] = lights[bit].to_mesh_space(&columns(rows)).ok_or("no light")?.to_array();
                let own = Light::homogeneous([x, y, z, w]);
                let (light, drawn, sides) = models[*model].draw(&view_of(&view, rows), light, own);
                if light.casting != CAST_NOTHING {
                    casting.push(models[*model].casting(rows, &sides));
                }
                expected.0.iter_mut().zip(drawn.0).for_each(|(sum, count)| *sum += count);
                near += usize::from(drawn.0[2] + drawn.0[3] > 0);
            }
            let ShadowDraws { plain, clipped, near_front, near_back, .. } = draws[number * LIGHTS + bit];
            let mut found = Drawn([plain, clipped, near_front, near_back].map(|draw| draw.instance_count));
            let what = format!("view {number}, light {bit}");
            same(&what, &[found], &[expected])?;
            found.0[0] ^= 1;
            must_fail("another count", &same(&what, &[found], &[expected]))?;
            let at = number * LIGHTS + bit;
            let boxes: Vec<_> = casting.iter().map(|(own, _)| *own).collect();
            let pencil = cpu::stencil_pencil(seen.light, &boxes);
            kinds[pencil.kind as usize] += 1;
            same(&format!("{what}, pencil"), &pencils[at..=at], &[pencil])?;
            let crossed = cpu::stencil_crossings(&pencil, casting);
            same(&format!("{what}, crossings"), &crossings[row * at..row * (at + 1)], &crossed)?;
        }
    }
    // The words of choices, of sampled casters.
    for number in (0..CASTERS).step_by(97) {
        let (model, rows, handle) = &casters[number];
        let (index, _) = frame.place(*handle).ok_or("the caster is not in the frame")?;
        for (at, camera) in cameras.iter().enumerate() {
            let view = shadow::view(camera).map_err(text)?;
            let mut casts = [0_u32; 3];
            for (bit, &light) in lights.iter().enumerate() {
                let seen = shadow::light(camera, &view, light);
                let own = light_of(&seen, light, rows).ok_or("no light in mesh space")?;
                let (chosen, ..) = models[*model].draw(&view_of(&view, rows), own, light);
                casts[0] |= u32::from(chosen.casting != CAST_NOTHING) << bit;
                casts[1] |= u32::from(chosen.casting == 2) << bit;
                casts[2] |= u32::from(chosen.casting != CAST_NOTHING && chosen.counting == 1) << bit;
            }
            let first = 8 * (at * CASTERS + index as usize);
            same(&format!("caster {number}, view {at}"), &words[first..first + 3], &casts)?;
        }
    }
    println!("{near} pairs with near caps, {kinds:?} pencils of each kind");
    if kinds.contains(&0) {
        return Err("no pencil of a kind".to_owned());
    }
    if near == 0 { Err("no near cap".to_owned()) } else { Ok(()) }
}
