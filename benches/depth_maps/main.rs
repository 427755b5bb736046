//! `cargo bench --bench depth_maps -- casters`: frames of shadows by volumes of depth maps, by volumes of meshes, and by a
//! lookup. `--json FILE` for a chart by `rimline bench --depth-maps FILE`, `--quick` for few rounds.

use std::cell::RefCell;

use glam::{DMat4, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::{
    DepthMap, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, MeshDepth,
};
use rimline::gpu::{PositionBuffer, ShadowFormat, ShadowPipelines};
use rimline::{Counting, DepthDirection, Light, ShadowCamera};
use rimline_bench::arguments::value_of;
use rimline_bench::engine::{Contender, Rounds, times};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::pipelines::{Drawing, depth, group};
use rimline_bench::record::{Casters, SceneRecorder, Setting, Target, Until, made_anew};
use rimline_bench::row::{Entry, Row, Variant, compare};
use rimline_bench::shapes::{self, Shape};
use rimline_bench::{Error, depth_maps};
use wgpu::{CommandEncoder, LoadOp, TextureFormat};

/// 24 bits, as in the paper of 2000.
const MAP: TextureFormat = TextureFormat::Depth24Plus;
const EYE: TextureFormat = TextureFormat::Depth24PlusStencil8;
/// Texels of the map and pixels of the picture a side.
const SIDE: u32 = 1024;
/// Subdivisions n of the spheres: 8 n² faces.
const SUBDIVISIONS: [u32; 4] = [11, 35, 112, 354];
/// Ways to volumes of the map.
const WAYS: [(&str, DepthMapMethod); 3] = [
    ("of the map, every cell", DepthMapMethod::EveryCell),
    ("of the map, automatic", DepthMapMethod::Automatic { dangling: None }),
    ("of the map, contours 0.005", DepthMapMethod::Contours { threshold: 0.005, sideways: 0.1, depth: 0.02 }),
];
/// A near plane as in games, where units are metres.
const NEAR: f64 = 0.1;

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    let is_quick = arguments.iter().any(|argument| argument == "--quick");
    let json = value_of("--json", &arguments)?;
    let rows = measure(if is_quick { 3 } else { 15 })?;
    if let Some(file) = json {
        std::fs::write(file, format!("{:#}\n", depth_maps::to_json(&rows)))?;
    }
    Ok(())
}

/// A camera that looks from `distance` along `forward` to the origin, and sees a ball of `radius` there. Lights have
/// standard depth from before the ball to behind it, eyes reversed depth from [`NEAR`] on.
fn camera(forward: DVec3, up: DVec3, distance: f64, radius: f64, is_light: bool) -> ShadowCamera {
    let right = forward.cross(up).normalize();
    let eye = -distance * forward;
    let scale = (distance * distance - radius * radius).sqrt() / radius;
    let row = |axis: DVec3| axis.extend(-axis.dot(eye));
    let (w, near, far) = (row(forward), distance - radius, distance + radius);
    let (z, depth) = if is_light {
        ((w - DVec4::W * near) * (far / (far - near)), DepthDirection::Standard)
    } else {
        (DVec4::W * NEAR, DepthDirection::Reversed)
    };
    let rows = DMat4::from_cols(row(right) * scale, row(right.cross(forward)) * scale, z, w);
    ShadowCamera { view_projection: rows.transpose().as_mat4().to_cols_array_2d(), origin: [0.0; 3], depth }
}

/// A depth texture: to draw to, and its depths to read.
struct Depths {
    all: wgpu::TextureView,
    read: wgpu::TextureView,
}

impl Depths {
    fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let all = gpu.texture([SIDE; 2], format);
        let aspect = wgpu::TextureAspect::DepthOnly;
        let read = all.texture().create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        Self { all, read }
    }

    /// A pass that draws depths, from what is far on.
    fn drawn(&self, far: f32, stencil: Option<LoadOp<u32>>) -> Target<'_> {
        Target { depth_stencil: Some(&self.all), depth: Some(LoadOp::Clear(far)), stencil, color: None }
    }

    /// A pass that counts, against depths that are read only.
    fn counted(&self) -> Target<'_> {
        Target { depth_stencil: Some(&self.all), stencil: Some(LoadOp::Clear(0)), ..Target::default() }
    }
}

/// A mesh whose depth is drawn into maps and for the eye.
struct Drawn {
    positions: wgpu::Buffer,
    into_map: MeshDepth,
    for_eye: MeshDepth,
}

impl Drawn {
    fn new(gpu: &Gpu, shape: &Shape) -> Result<Self, Error> {
        let mesh = shape.mesh()?;
        let depth = |format, depth| MeshDepth::new(&gpu.pipelines, &mesh, format, depth);
        Ok(Self {
            into_map: depth(MAP, DepthDirection::Standard)?,
            for_eye: depth(EYE, DepthDirection::Reversed)?,
            positions: gpu.buffer(wgpu::BufferUsages::STORAGE, &shape.positions),
        })
    }

    fn positions(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 }
    }

    fn draw_map(&self, encoder: &mut CommandEncoder, map: &Depths, light: &ShadowCamera) -> Result<(), Error> {
        Ok(self.into_map.draw(&mut map.drawn(1.0, None).begin(encoder), self.positions(), light)?)
    }
}

/// Frames of one caster of more and more faces: volumes of its mesh, volumes of a depth map, and a lookup in the map,
/// in turn.
fn measure(rounds: usize) -> Result<Vec<Row>, Error> {
    let (gpu, name) = &Gpu::first(wgpu::Features::empty())?;
    let distance = 6.0;
    let down = DVec3::new(0.4, -1.0, 0.3).normalize();
    let light = &camera(down, DVec3::Z, distance, 2.0, true);
    let lamp = Light::point((-distance * down).as_vec3().to_array());
    let eye = &camera(DVec3::new(-0.3, -0.5, -1.0).normalize(), DVec3::Y, 8.0, 3.0, false);
    let ground = Drawn::new(gpu, &shapes::cube().placed(|[x, y, z]| [4.0 * x, 0.01 * y - 1.3, 4.0 * z]))?;
    let format = ShadowFormat::default();
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, Counting::Auto)?;
    let of_maps = &DepthMapPipelines::new(&gpu.pipelines, &format, 0)?;
    let (map, seen) = (&Depths::new(gpu, MAP), &Depths::new(gpu, EYE));
    let shade = &Shade::new(gpu, SIDE, [seen, map], [eye, light]);
    let clock = |record: &mut dyn FnMut(&mut CommandEncoder) -> Result<(), Error>| -> Result<f64, Error> {
        Ok(Stopwatch::new(gpu).by_clock(record)?[1])
    };
    println!("{name}");
    println!(
        "\nA sphere over a ground, picture and map of {SIDE}²: milliseconds of a frame's shadows (of its stencil pass)"
    );
    let mut rows = Vec::new();
    for subdivisions in SUBDIVISIONS {
        let shape = shapes::sphere(subdivisions);
        let (sphere, faces) = (&Drawn::new(gpu, &shape)?, shape.faces.len());
        let setting = Setting::new(Casters::InBuffers(vec![shape]), vec![lamp], *eye);
        let scene = SceneRecorder::new(gpu, &setting, Some(&pipelines), made_anew(1, Counting::Auto))?;
        let scene = RefCell::new(scene);
        // Times of a frame's shadows, and of its stencil pass, which is drawn again.
        let of_mesh = || {
            let mut scene = scene.borrow_mut();
            let frame = clock(&mut |encoder| {
                scene.encode(encoder, Until::Volumes(None), None)?;
                scene.draw(&mut seen.counted().begin(encoder), 0)?;
                shade.stencil(encoder, seen);
                Ok(())
            })?;
            let stencil = clock(&mut |encoder| scene.draw(&mut seen.counted().begin(encoder), 0))?;
            Ok(times([("frame", frame), ("stencil", stencil)]))
        };
        let eyes_depth = || {
            let ms = clock(&mut |encoder| {
                let mut pass = seen.drawn(0.0, Some(LoadOp::Clear(0))).begin(encoder);
                [sphere, &ground]
                    .iter()
                    .try_for_each(|drawn| Ok(drawn.for_eye.draw(&mut pass, drawn.positions(), eye)?))
            })?;
            Ok(times([("frame", ms)]))
        };
        let lookup = || {
            let ms = clock(&mut |encoder| {
                sphere.draw_map(encoder, map, light)?;
                shade.lookup(encoder);
                Ok(())
            })?;
            Ok(times([("frame", ms)]))
        };
        let mut contenders: Vec<(Variant, Contender<'_>)> = vec![
            (depth_maps::variant("the eye's depth, not counted below"), Box::new(eyes_depth)),
            (depth_maps::variant("volumes of the mesh"), Box::new(of_mesh)),
        ];
        for (name, method) in WAYS {
            let options = DepthMapOptions { method, ..Default::default() };
            let mut volumes = DepthMapVolumes::new(of_maps, [SIDE; 2], options)?;
            let run = move || {
                let mut drawn = None;
                let frame = clock(&mut |encoder| {
                    sphere.draw_map(encoder, map, light)?;
                    let of_light = DepthMap { texture: &map.read, light: *light, objects: None };
                    let frame = volumes.encode(encoder, &of_light, eye)?;
                    frame.draw(&mut seen.counted().begin(encoder), of_maps)?;
                    shade.stencil(encoder, seen);
                    drawn = Some(frame);
                    Ok(())
                })?;
                let stencil = clock(&mut |encoder| {
                    let mut pass = seen.counted().begin(encoder);
                    drawn.iter().try_for_each(|drawn| Ok(drawn.draw(&mut pass, of_maps)?))
                })?;
                Ok(times([("frame", frame), ("stencil", stencil)]))
            };
            contenders.push((depth_maps::variant(name), Box::new(run)));
        }
        contenders.push((depth_maps::variant("lookup"), Box::new(lookup)));
        let entries: Vec<Entry> = compare(Rounds::exactly(rounds), contenders, &())?;
        println!("{faces} faces");
        for entry in &entries {
            let stencil = entry.median(depth_maps::STENCIL).map_or_else(String::new, |ms| format!(" ({ms:.1})"));
            println!("  {:<36} {:>8.1}{stencil}", entry.variant.name, entry.ms("frame"));
        }
        rows.push(depth_maps::row(faces as u64, u64::from(SIDE), name, entries));
    }
    Ok(rows)
}

// The end of a frame: black where the stencil is not 0, or where a lookup in the map finds shadow.
const SHADER: &str = "
@group(0) @binding(0) var eye_depth: texture_2d<f32>;
@group(0) @binding(1) var map: texture_2d<f32>;
// From the eye's device coordinates to the light's.
@group(0) @binding(2) var<uniform> to_light: mat4x4<f32>;
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn black() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
@fragment fn lookup(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let depth = textureLoad(eye_depth, vec2<i32>(at.xy), 0).x;
  let ndc = 2.0 * at.xy / vec2<f32>(textureDimensions(eye_depth)) - 1.0;
  let seen = to_light * vec4<f32>(ndc.x, -ndc.y, depth, 1.0);
  let point = seen.xyz / seen.w;
  let texel = (0.5 + 0.5 * vec2<f32>(point.x, -point.y)) * vec2<f32>(textureDimensions(map));
  if (depth == 0.0 || point.z < textureLoad(map, vec2<i32>(texel), 0).x + 0.001) {
    discard;
  }
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
";

const COLOR: TextureFormat = TextureFormat::Rgba8Unorm;

struct Shade {
    black: wgpu::RenderPipeline,
    lookup: wgpu::RenderPipeline,
    /// Resources that a lookup reads.
    group: wgpu::BindGroup,
    color: wgpu::TextureView,
}

impl Shade {
    fn new(gpu: &Gpu, side: u32, [eye_depth, map]: [&Depths; 2], [eye, light]: [&ShadowCamera; 2]) -> Self {
        let compare = wgpu::CompareFunction::NotEqual;
        let unequal = wgpu::StencilFaceState { compare, ..wgpu::StencilFaceState::IGNORE };
        let stencil = wgpu::DepthStencilState {
            stencil: wgpu::StencilState { front: unequal, back: unequal, read_mask: 0xff, write_mask: 0 },
            ..depth(EYE, wgpu::CompareFunction::Always, false)
        };
        let make = |entry_point, depth_stencil| {
            let entry_points = [Some("everywhere"), Some(entry_point)];
            let targets = &[Some(COLOR.into())];
            Drawing { label: entry_point, source: SHADER, entry_points, depth_stencil, targets, ..Drawing::default() }
                .pipeline(&gpu.device)
        };
        let lookup = make("lookup", None);
        let [eye, light] = [eye, light].map(|camera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4());
        let matrix = (light * eye.inverse()).as_mat4().to_cols_array();
        let matrix = gpu.buffer(wgpu::BufferUsages::UNIFORM, &matrix);
        let [eye_depth, map] = [eye_depth, map].map(|depths| wgpu::BindingResource::TextureView(&depths.read));
        let group = group(&gpu.device, &lookup.get_bind_group_layout(0), [eye_depth, map, matrix.as_entire_binding()]);
        Self { black: make("black", Some(stencil)), lookup, group, color: gpu.texture([side; 2], COLOR) }
    }

    fn target(&self) -> Target<'_> {
        Target { color: Some((&self.color, LoadOp::Clear(wgpu::Color::WHITE))), ..Target::default() }
    }

    /// Black where the stencil is not 0.
    fn stencil(&self, encoder: &mut CommandEncoder, depths: &Depths) {
        let mut pass = Target { depth_stencil: Some(&depths.all), ..self.target() }.begin(encoder);
        pass.set_pipeline(&self.black);
        pass.draw(0..3, 0..1);
    }

    /// Black where the map has something nearer to the light.
    fn lookup(&self, encoder: &mut CommandEncoder) {
        let mut pass = self.target().begin(encoder);
        pass.set_pipeline(&self.lookup);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
