//! Zero of anything with depth maps: meshes without a triangle, no map, no bit. Nothing is drawn,
//! or a typed error says what is missing.

use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapCube, DepthMapError, DepthMapMethod, DepthMapOptions, DepthMapPipelines,
    DepthMapVolumes, MeshDepth,
};
use rimline::gpu::{DeviceError, PositionBuffer, ShadowFormat};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{DepthDirection, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same};
use wgpu::TextureFormat::{Depth32Float, R32Float};

use crate::picture::stencil_of;
use crate::scene_depth::map;
use crate::stages::camera;
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] = &[
    ("meshes_without_a_triangle_have_no_depth", without_triangles),
    ("maps_of_nothing_cast_nothing", without_depths),
    ("no_bits_sides_and_memory_are_typed_errors", without_room),
];

const REVERSED: DepthDirection = DepthDirection::Reversed;
const SIDE: u32 = 16;

fn without_triangles() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let light = camera(REVERSED);
    let corners = [[1.0, -3.0, 3.0], [4.0, -3.0, 3.0], [2.5, -3.0, 6.0]];
    let walked_back = PolygonLoops { polygon_loops: &[1], loop_sizes: &[4], loop_corners: &[0, 1, 1, 0] };
    let drawn = |mesh: &Mesh| {
        let buffer = gpu.storage(&corners);
        let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        let renderer = MeshDepth::new(&gpu.pipelines, mesh, Depth32Float, REVERSED).map_err(text)?;
        map(&gpu, Depth32Float, &light, |pass| renderer.draw(pass, positions, &light).map_err(text))
    };
    let nothing = map(&gpu, Depth32Float, &light, |_| Ok(()))?;
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

/// Maps in which nothing is, and cubes without a map, with lists that have room for nothing. The eye sees a wall.
fn without_depths() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 0).map_err(text)?;
    let eye = camera(REVERSED);
    let depths = vec![0.01; (SIDE * SIDE) as usize];
    let empty = depth_view(&texture(&gpu, [1; 2], R32Float, &[0.0])?);
    let full = depth_view(&texture(&gpu, [1; 2], R32Float, &[0.5])?);
    let contours = DepthMapMethod::Contours { threshold: 1.0, sideways: 0.0, depth: 0.0 };
    let plain = DepthMapOptions { capacity: Some(0), slope_bias: 0.0, ..Default::default() };
    let lit = vec![0; (SIDE * SIDE) as usize];
    for options in [
        plain,
        DepthMapOptions { capacity: None, ..plain },
        DepthMapOptions { method: DepthMapMethod::EveryCell, ..plain },
        DepthMapOptions { method: contours, ..plain },
    ] {
        let mut volumes = DepthMapVolumes::new(&pipelines, [1; 2], options).map_err(text)?;
        let mut drawn = |view: &wgpu::TextureView| {
            stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
                let map = DepthMap { texture: view, light: eye, objects: None };
                volumes.encode(encoder, &map, &eye).map_err(text)
            })
        };
        same(&format!("{options:?}"), &drawn(&empty)?, &lit)?;
        must_fail("a texel", &same("stencil", &drawn(&full)?, &lit))?;
    }
    let cameras = DepthMapCube::cameras([0.0, 0.0, 3.0], 0.1, None, REVERSED, 3).map_err(text)?;
    for capacity in [Some(0), None] {
        let options = DepthMapOptions { capacity, ..Default::default() };
        let mut cube = DepthMapCube::new(&pipelines, 3, options).map_err(text)?;
        let drawn = stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
            let maps = DepthCubeMaps { textures: [None; 6], lights: cameras, objects: [None; 6] };
            cube.encode(encoder, &maps, &eye).map_err(text)
        })?;
        same("a cube without maps", &drawn, &lit)?;
    }
    Ok(())
}

fn without_room() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let format = ShadowFormat::default();
    let antialiased = DepthMapPipelines::antialiased(&gpu.pipelines, &format, 3..3).err();
    same("no bits", &[antialiased], &[Some(DepthMapError::Bits(3..3))])?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &format, 0).map_err(text)?;
    let options = DepthMapOptions { memory_limit: Some(0), ..Default::default() };
    let none = DepthMapVolumes::new(&pipelines, [4, 4], options).err();
    if !matches!(none, Some(DepthMapError::Device(DeviceError::MemoryLimit { limit: 0, .. }))) {
        return Err(format!("no memory: {none:?}"));
    }
    let cube = DepthMapCube::new(&pipelines, 0, DepthMapOptions::default()).err();
    same("a cube without texels", &[cube], &[Some(DepthMapError::Side(0))])
}
