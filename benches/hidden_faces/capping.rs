//! The caps of Batagelo and Costa Júnior (1999) beside near caps: each face's volume is clipped at the near plane on the CPU, and the
//! cut points are sorted by angle.

use std::time::Instant;

use glam::{Mat4, Vec3, Vec4};
use rimline::reference::cpu::near_cap;
use rimline::reference::layout::ShadowDraws;
use rimline::reference::shadow;
use rimline::{Counting, Light};
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{self, Drawing};

use crate::casting;
use crate::frames::{DEPTH, Frames, NEAR, camera};
use crate::scenes::Setting;

const SHADER: &str = "
@vertex fn cap(@location(0) clip: vec4<f32>) -> @builtin(position) vec4<f32> { return clip; }
@fragment fn nothing() {}
";
/// Volumes end so far away, in units of the place's distance from the light.
const FAR: f32 = 1e4;

/// Directions of the eye.
const TURNS: u32 = 8;

type Face = [[f32; 3]; 3];

/// The convex polygon in which the near plane cuts a face's volume, in clip space.
fn polygon(matrix: &Mat4, light: Light, face: &Face) -> Vec<Vec4> {
    let near = face.map(Vec3::from);
    let away = |place: Vec3| light.w * place - Vec3::from(light.xyz);
    let far = near.map(|place| place + FAR * away(place));
    let height = |place: Vec3| (*matrix * place.extend(1.0)).w - NEAR;
    let mut points = Vec::new();
    let mut cut = |a: Vec3, b: Vec3| {
        let (from, to) = (height(a), height(b));
        if (from < 0.0) != (to < 0.0) {
            points.push(*matrix * (a + (from / (from - to)) * (b - a)).extend(1.0));
        }
    };
    for (first, second) in [(0, 1), (1, 2), (2, 0)] {
        cut(near[first], near[second]);
        cut(far[first], far[second]);
        cut(near[first], far[first]);
    }
    let middle = points.iter().sum::<Vec4>() / points.len().max(1) as f32;
    let angle = |point: &Vec4| (point.y - middle.y).atan2(point.x - middle.x);
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points
}

fn triangles(polygons: &[Vec<Vec4>]) -> Vec<Vec4> {
    // All are on the near plane, and drawn without a test of depth.
    let on_plane = |point: Vec4| Vec4::new(point.x, point.y, 0.5 * NEAR, NEAR);
    let fan = |polygon: &Vec<Vec4>| {
        let corner = |at: usize| on_plane(polygon[at]);
        (2..polygon.len()).flat_map(|at| [corner(0), corner(at - 1), corner(at)]).collect::<Vec<_>>()
    };
    polygons.iter().flat_map(fan).collect()
}

pub(crate) struct CapDrawer {
    pipeline: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    count: u32,
}

impl CapDrawer {
    fn new(frames: &Frames, vertices: &[Vec4]) -> Self {
        let face =
            wgpu::StencilFaceState { pass_op: wgpu::StencilOperation::IncrementWrap, ..wgpu::StencilFaceState::IGNORE };
        let stencil = wgpu::StencilState { front: face, back: face, read_mask: 255, write_mask: 255 };
        let drawing = Drawing {
            label: "caps",
            source: SHADER,
            entry_points: [Some("cap"), Some("nothing")],
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 16,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x4],
            })],
            depth_stencil: Some(wgpu::DepthStencilState {
                stencil,
                ..pipelines::depth(DEPTH, wgpu::CompareFunction::Always, false)
            }),
            ..Drawing::default()
        };
        let pipeline = drawing.pipeline(&frames.gpu.device);
        let floats: Vec<f32> = vertices.iter().flat_map(Vec4::to_array).collect();
        let vertices = frames.vertices(&floats);
        Self { pipeline, vertices, count: floats.len() as u32 / 4 }
    }

    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
    }
}

/// Pixels dark in one picture and not in the other.
fn different(a: &[u8], b: &[u8]) -> usize {
    a.iter().zip(b).filter(|(a, b)| (**a == 0) != (**b == 0)).count()
}

fn milliseconds<T>(run: impl Fn() -> T) -> f64 {
    let least = |least: f64, _| {
        let begin = Instant::now();
        std::hint::black_box(run());
        least.min(begin.elapsed().as_secs_f64() * 1e3)
    };
    (0..9).fold(f64::INFINITY, least)
}

pub(crate) fn compare(settings: &[Setting]) -> Result<(), String> {
    let [auto, z_pass, z_fail] = [Counting::Auto, Counting::ZPass, Counting::ZFail].map(Frames::new);
    let (auto, z_pass, z_fail) = (auto?, z_pass?, z_fail?);
    println!(
        "| scene | faces that cast | its caps | near caps | its caps, CPU ms | near caps by the same CPU, ms | pixels dark | wrong without caps | with its caps | with near caps |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for setting in settings {
        let mut sums = [0.0; 9];
        for turn in 0..TURNS {
            let setting = setting.turned(turn as f32 / TURNS as f32);
            let of = one([&auto, &z_pass, &z_fail], &setting)?;
            sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += of);
        }
        let cells: Vec<String> = (0..sums.len())
            .map(|cell| match cell {
                0..3 => format!("{:.0}", sums[cell] / TURNS as f64),
                3..5 => format!("{:.3}", sums[cell] / TURNS as f64),
                _ => format!("{:.0}", sums[cell]),
            })
            .collect();
        println!("| {} | {} |", setting.name, cells.join(" | "));
    }
    Ok(())
}

fn one([auto, z_pass, z_fail]: [&Frames; 3], setting: &Setting) -> Result<[f64; 9], String> {
    let light = setting.lights[0];
    let matrix = camera(setting);
    let faces = casting(setting, light);
    let cut = || -> Vec<_> {
        let polygons = faces.iter().map(|face| polygon(&matrix, light, face));
        polygons.filter(|polygon| polygon.len() > 2).collect()
    };
    let polygons = cut();
    let its_time = milliseconds(cut);
    let view = auto.view(setting);
    let seen = shadow::view(&view.camera).map_err(text)?;
    let own = shadow::light(&view.camera, &seen, light);
    let near = || -> Vec<_> {
        let caps = faces.iter().map(|face| near_cap(&seen, &own, [0, 1, 2].map(|at| (at as u32, face[at]))));
        caps.filter(|polygon| polygon.len() > 2).collect()
    };
    let near_time = milliseconds(near);
    let stencil = |frames: &Frames, caps: Option<&CapDrawer>| {
        let mut casting = frames.casting(&setting.bodies, light)?;
        frames.stencil(&frames.view(setting), &mut casting, caps)
    };
    let (truth, _) = stencil(z_fail, None)?;
    let (ours, draws) = stencil(auto, None)?;
    let (without, _) = stencil(z_pass, None)?;
    let drawer = CapDrawer::new(z_pass, &triangles(&polygons));
    let (its, _) = stencil(z_pass, Some(&drawer))?;
    let near_caps = |draws: &ShadowDraws| draws.near_front.instance_count + draws.near_back.instance_count;
    let near_caps: u32 = draws.iter().map(near_caps).sum();
    let dark = truth.iter().filter(|count| **count != 0).count();
    let counts = [dark, different(&without, &truth), different(&its, &truth), different(&ours, &truth)];
    let [dark, without, its, ours] = counts.map(|count| count as f64);
    let casts = faces.len() as f64;
    Ok([casts, polygons.len() as f64, f64::from(near_caps), its_time, near_time, dark, without, its, ours])
}
