//! Zero of anything with depth maps: meshes without a triangle, no map, no caster, no view, no light, no bit. Nothing is drawn,
//! or a typed error says what is missing.

use rimline::gpu::{
    DepthEdges, DepthMap, DepthMapCasterCounts, DepthMapCasters, DepthMapCastersOptions, DepthMapCube,
    DepthMapCubeError, DepthMapOptions, DepthMapPipelines, DepthMapPipelinesError, DepthMapReconstruction,
    DepthMapVolumes, DepthMapVolumesError, MemoryError, MeshDepth, PositionBuffer, Scene, SceneOptions, ShadowFormat,
};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{DepthDirection, Light, Mesh};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::{must_fail, same};
use wgpu::TextureFormat::{Depth32Float, R32Float};

use crate::picture::{stencil_after, stencil_of};
use crate::scene_depth::map;
use crate::stages::camera;
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] = &[
    ("meshes_without_a_triangle_have_no_depth", without_triangles),
    ("maps_of_nothing_cast_nothing", without_depths),
    ("scenes_without_maps_lights_and_views_cast_nothing", without_casters),
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
    let contours = DepthMapReconstruction::Contours { sideways: 0.0, depth: 0.0 };
    let outlines = DepthEdges::Outlines;
    let plain = DepthMapOptions { capacity: Some(0), slope_bias: 0.0, ..Default::default() };
    let lit = vec![0; (SIDE * SIDE) as usize];
    for options in [
        plain,
        DepthMapOptions { capacity: None, ..plain },
        DepthMapOptions { edges: DepthEdges::EveryCell, ..plain },
        DepthMapOptions { edges: outlines, reconstruction: contours, ..plain },
    ] {
        let mut volumes = DepthMapVolumes::new(&pipelines, [1; 2], options).map_err(text)?;
        let mut drawn = |view: &wgpu::TextureView| {
            stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
                let map = DepthMap { texture: view, light: eye };
                volumes.encode(encoder, &map, &eye, None).map_err(text)
            })
        };
        same(&format!("{options:?}"), &drawn(&empty)?, &lit)?;
        must_fail("a texel", &same("stencil", &drawn(&full)?, &lit))?;
    }
    let cameras = DepthMapCube::cameras([0.0, 0.0, 3.0], 0.1, None, REVERSED, 3).map_err(text)?;
    for capacity in [Some(0), None] {
        let options = DepthMapOptions { capacity, ..Default::default() };
        let mut cube = DepthMapCube::new(&pipelines, 3, &cameras, options).map_err(text)?;
        let drawn = stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
            cube.encode(encoder, [None; 6], &eye, None).map_err(text)
        })?;
        same("a cube without maps", &drawn, &lit)?;
    }
    Ok(())
}

fn without_casters() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions::default()).map_err(text)?;
    let mut casters = DepthMapCasters::new(&scene, DepthMapCastersOptions::default());
    let light = scene.add_light(Light::point([0.0, 5.0, 0.0])).map_err(text)?;
    let pipelines = DepthMapPipelines::counting(&gpu.pipelines, &ShadowFormat::default()).map_err(text)?;
    let eye = camera(REVERSED);
    for views in [&[][..], &[eye]] {
        let (mut found, mut statistics) = (Vec::new(), Vec::new());
        let stencil = stencil_after(&gpu, (SIDE, &vec![0.01; (SIDE * SIDE) as usize]), |encoder| {
            let frame = scene.encode(encoder, views, None).map_err(text)?;
            let frame = casters.encode_for(encoder, &frame, views, &[], None).map_err(text)?;
            statistics.push(frame.statistics(encoder).map_err(text)?.is_none());
            found.push((frame.counts(), frame.drawn().count()));
            let (pipelines, has_view) = (&pipelines, !views.is_empty());
            Ok(
                move |pass: &mut wgpu::RenderPass<'_>| {
                    if has_view { frame.draw(pass, pipelines, 0, light).map_err(text) } else { Ok(()) }
                },
            )
        })?;
        same("stencil", &stencil, &[0; (SIDE * SIDE) as usize])?;
        same("counts", &found, &[(DepthMapCasterCounts::default(), 0)])?;
        same("no statistics", &statistics, &[true])?;
    }
    Ok(())
}

fn without_room() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let format = ShadowFormat::default();
    let antialiased = DepthMapPipelines::antialiased(&gpu.pipelines, &format, 3..3).err();
    same("no bits", &[antialiased], &[Some(DepthMapPipelinesError::Bits(3..3))])?;
    let pipelines = DepthMapPipelines::new(&gpu.pipelines, &format, 0).map_err(text)?;
    let volumes = |options| DepthMapVolumes::new(&pipelines, [4, 4], options).err();
    let none = volumes(DepthMapOptions { bits: 0, ..Default::default() });
    same("volumes of no bits", &[none], &[Some(DepthMapVolumesError::Bits(0))])?;
    let none = volumes(DepthMapOptions { memory_limit: Some(0), ..Default::default() });
    if !matches!(none, Some(DepthMapVolumesError::Memory(MemoryError::Total { limit: 0, .. }))) {
        return Err(format!("no memory: {none:?}"));
    }
    let cameras = DepthMapCube::cameras([0.0; 3], 0.1, None, REVERSED, 3).map_err(text)?;
    let cube = |side, bits| {
        DepthMapCube::new(&pipelines, side, &cameras, DepthMapOptions { bits, ..Default::default() }).err()
    };
    same("a cube without texels", &[cube(0, 1)], &[Some(DepthMapCubeError::Side(0))])?;
    same("a cube of no bits", &[cube(3, 0)], &[Some(DepthMapCubeError::Bits(0))])
}
