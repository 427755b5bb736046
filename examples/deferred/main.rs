//! A small deferred renderer, whose depth has no stencil: eight lamps, and an area light of 32 samples, whose masks are
//! one word a pixel. Writes `deferred.png`. Run it with `cargo run --release --example deferred`.

#[path = "../support/stage.rs"]
pub(crate) mod stage;
#[path = "../support/mod.rs"]
pub(crate) mod support;

use glam::{Affine3A, Mat4, Quat, Vec3};
use rimline::gpu::{Caster, FrameInputs, LightHandle, MaskInputs, Scene, SceneOptions, ShadowMasks};
use rimline::{AreaLight, AreaShape, DepthDirection, Light, Matrix3x4, ShadowCamera, wgpu};
use rimline_testkit::shapes::{self, Shape};
use stage::Camera;
use support::{Canvas, PipelineOptions};
use wgpu::TextureFormat::{Depth24Plus, R8Uint, R32Uint};

pub(crate) const AREA: AreaLight = AreaLight {
    light: Light::point([-4.0, 6.0, 7.0]).with_range(24.0),
    shape: AreaShape::Disc { radius: 0.7 },
    normal: [4.0, -6.0, -7.0],
};
pub(crate) const AREA_COLOR: [f32; 3] = [0.80, 0.76, 0.68];

/// Lamps between the slabs, with their colours.
pub(crate) fn lamps() -> [(Light, [f32; 3]); 8] {
    std::array::from_fn(|number| {
        let angle = std::f32::consts::TAU * (number as f32 + 0.5) / 8.0;
        let position = [3.1 * angle.cos(), 0.8, 3.1 * angle.sin()];
        let hue = |shift: f32| 0.20 + 0.20 * (angle + shift).cos();
        (Light::point(position).with_range(6.0), [0.0, 2.1, 4.2].map(hue))
    })
}

/// Shapes that cast, where they stand, and their colours.
pub(crate) fn bodies() -> [(Shape, Vec<Matrix3x4>, [f32; 3]); 3] {
    let at = |scale, turn, to| {
        let matrix = Mat4::from(Affine3A::from_scale_rotation_translation(scale, turn, to));
        [0, 1, 2].map(|row| matrix.row(row).to_array())
    };
    let slab = |number: usize| {
        let angle = std::f32::consts::TAU * number as f32 / 16.0;
        let position = Vec3::new(4.2 * angle.cos(), 0.7, 4.2 * angle.sin());
        at(Vec3::new(0.12, 0.7, 0.45), Quat::from_rotation_y(-angle), position)
    };
    let ring = at(Vec3::ONE, Quat::from_rotation_x(1.35), Vec3::new(0.0, 1.75, 0.0));
    let blob = at(Vec3::splat(0.55), Quat::IDENTITY, Vec3::new(0.0, 0.75, 0.0));
    [
        (shapes::cube(), (0..16).map(slab).collect(), [0.75, 0.73, 0.70]),
        (shapes::torus(64, 32, 1.1, 0.16), vec![ring], [0.85, 0.65, 0.35]),
        (shapes::blob(48, 0.3, 5), vec![blob], [0.70, 0.72, 0.78]),
    ]
}

/// All corners in world space, those of the floor first: position and colour, four numbers each.
pub(crate) fn corners() -> Vec<[f32; 8]> {
    let floor = [[-1, 1], [1, 1], [1, -1], [-1, 1], [1, -1], [-1, -1]];
    let floor = floor.map(|[x, z]| [40.0 * x as f32, 0.0, 40.0 * z as f32, 0.0, 0.78, 0.77, 0.75, 0.0]);
    let mut all: Vec<[f32; 8]> = floor.into();
    for (shape, transforms, [r, g, b]) in bodies() {
        for rows in transforms {
            let transform = |p: [f32; 3]| rows.map(|[x, y, z, to]| Vec3::new(x, y, z).dot(p.into()) + to);
            let corners = shape.faces.iter().flatten().map(|&vertex| transform(shape.positions[vertex as usize]));
            all.extend(corners.map(|[x, y, z]| [x, y, z, 0.0, r, g, b, 0.0]));
        }
    }
    all
}

pub(crate) fn camera() -> Camera {
    Camera::new([0.0, 6.4, 9.0], [0.0, 0.2, 0.1], 42.0).wide(1.5)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let canvas = Canvas::of_size([960, 640])?;
    let encoder = picture(&canvas)?;
    canvas.save(encoder, "deferred.png")
}

pub(crate) fn picture(canvas: &Canvas) -> Result<wgpu::CommandEncoder, Box<dyn std::error::Error>> {
    let (device, size) = (&canvas.device, canvas.size.map(|pixels| 2 * pixels));
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());

    // The renderer's own: faces and their depth.
    let (camera, corners) = (camera(), corners());
    let inverse = Mat4::from_cols_array_2d(&camera.view_projection).inverse();
    let matrices = [camera.view_projection, inverse.to_cols_array_2d()].as_flattened().concat();
    let mut words = [matrices, camera.eye.into(), vec![0.0]].concat();
    for (Light { xyz, range, .. }, color) in lamps().into_iter().chain([(AREA.light, AREA_COLOR)]) {
        words.extend([&xyz[..], &[range], &color, &[0.0]].concat());
    }
    let buffers = [canvas.uniform(bytemuck::cast_slice(&words)), canvas.storage(bytemuck::cast_slice(&corners))];
    let textures = [R32Uint, Depth24Plus, R8Uint, R32Uint].map(|format| canvas.target(size, 1, format));
    let views = textures.each_ref().map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let (uint, float) = (wgpu::TextureSampleType::Uint, wgpu::TextureSampleType::Float { filterable: false });
    let layouts = [
        canvas.layout(&[wgpu::BufferBindingType::Uniform, storage].map(buffer)),
        canvas.layout(&[uint, float, uint, uint].map(texture)),
    ];
    let world = canvas.group(&layouts[0], &buffers.each_ref().map(wgpu::Buffer::as_entire_binding));
    let seen = canvas.group(&layouts[1], &views.each_ref().map(wgpu::BindingResource::TextureView));
    let all = [&layouts[0], &layouts[1]];
    let pipeline = |layouts, entry_points, format, depth_stencil| {
        let topology = wgpu::PrimitiveTopology::TriangleList;
        let wgsl = include_str!("deferred.wgsl");
        canvas.pipeline(&PipelineOptions { layouts, wgsl, entry_points, topology, format, blend: None, depth_stencil })
    };
    let nearer = wgpu::DepthStencilState { format: Depth24Plus, ..stage::nearer() };
    let surfaces = pipeline(&all[..1], ["surface", "face_number"], R32Uint, Some(nearer));
    let light = pipeline(&all, ["whole", "light"], Canvas::FORMAT, None);
    let clear = (wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), wgpu::LoadOp::Clear(0.0));
    let mut pass = stage::begin(&mut encoder, &views[0], &views[1], clear);
    pass.set_pipeline(&surfaces);
    pass.set_bind_group(0, &world, &[]);
    pass.draw(0..corners.len() as u32, 0..1);
    drop(pass);

    // Rimline's: a scene of the casters, and two masks from that depth.
    let mut scene = Scene::new(device, &canvas.queue, SceneOptions { max_lights: 40, ..SceneOptions::default() })?;
    for (shape, transforms, _) in bodies() {
        let mesh = scene.add_mesh(&shape.mesh()?, &shape.positions)?;
        transforms.into_iter().try_for_each(|rows| scene.insert(Caster::rigid(mesh, rows)).map(drop))?;
    }
    let mut add = |light| scene.add_light(light);
    let few: Vec<LightHandle> = lamps().into_iter().map(|(light, _)| add(light)).collect::<Result<_, _>>()?;
    let many: Vec<LightHandle> = AREA.samples(32).into_iter().map(add).collect::<Result<_, _>>()?;
    let Camera { eye, view_projection } = camera;
    let view = ShadowCamera { view_projection, origin: eye, depth: DepthDirection::Reversed };
    let frame = scene.encode(&mut encoder, FrameInputs::new(&[view.into()]))?;
    let mut masks = ShadowMasks::new(device)?;
    for (lights, target) in [(&few, &textures[2]), (&many, &textures[3])] {
        let inputs = MaskInputs { depth: &views[1], view: 0, lights, target };
        frame.write_masks(&mut encoder, &mut masks, &inputs)?;
    }

    canvas.draw(&mut encoder, |pass| {
        pass.set_pipeline(&light);
        pass.set_bind_group(0, &world, &[]);
        pass.set_bind_group(1, &seen, &[]);
        pass.draw(0..3, 0..1);
    });
    Ok(encoder)
}
