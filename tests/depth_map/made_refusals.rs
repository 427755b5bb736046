//! Cubes, merged and converted maps and depths of scenes that are refused, and the errors for it.

use glam::DVec3;
use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapConversion, DepthMapCube, DepthMapError, DepthMapMerge, DepthMapOptions,
    DepthMapPipelines, DepthMetric, MeshDepth, SceneDepth, SceneDepthCasters,
};
use rimline::gpu::{DeviceError, PositionBuffer, ShadowError, ShadowFormat};
use rimline::internals::depth_map::metric_view;
use rimline::mesh::Weld;
use rimline::{CameraError, Light, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::refusals::{Expected, is, refusal, refused, says, shows};
use rimline_testkit::{same, shapes};
use wgpu::TextureFormat;

use crate::mesh_depth::{SIDE, map};
use crate::metric::aside;
use crate::picture::{REVERSED, STANDARD, by, contours, look, pipelines};
use crate::scene::Eye;
use crate::scene_depth::{Casters, FORMATS};
use crate::stages::camera;
use rimline_testkit::textures::{depth_view, objects, texture};

pub(crate) const TESTS: &[Test] = &[
    ("cubes_that_do_not_meet_are_refused", cubes),
    ("cameras_of_cubes_that_are_none_are_refused", cameras),
    ("the_limit_of_memory_holds_for_objects_of_cubes", memory),
    ("merges_and_conversions_that_cannot_be_made_or_recorded", made),
    ("depths_of_scenes_that_are_refused", scenes),
];

fn cubes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let one = pipelines(&gpu, REVERSED, 7..8)?;
    let two = DepthMapPipelines::antialiased(&gpu.pipelines, &ShadowFormat::default(), 6..8).map_err(text)?;
    let made = |side| DepthMapCube::new(&one, side, DepthMapOptions::default());
    let most = gpu.device.limits().max_texture_dimension_2d;
    refused([
        refusal("16", made(16), Expected::Taken),
        refusal("0", made(0), is(DepthMapError::Side(0))),
        refusal("2", made(2), is(DepthMapError::Side(2))),
        refusal("most", made(most), is(DepthMapError::Texture { size: [3 * most, 2 * most], max_side: most })),
        refusal("20,000", made(20_000), is(DepthMapError::Cells(20_000))),
        refusal("u32::MAX", made(u32::MAX), is(DepthMapError::Cells(u32::MAX))),
        refusal("bits", DepthMapCube::new(&two, 16, DepthMapOptions::default()), is(DepthMapError::OneBit(2))),
        refusal(
            "contours",
            DepthMapCube::new(&one, 8, by(contours([0.01, 0.25, 0.01]))),
            is(DepthMapError::CubeContours),
        ),
    ])?;
    // Nothing is there.
    let given = |lights: [ShadowCamera; 6]| {
        let mut cube = made(16).map_err(text)?;
        let maps = DepthCubeMaps { textures: [None; 6], lights, objects: [None; 6] };
        gpu.submit(|encoder| Ok(cube.encode(encoder, &maps, &camera(REVERSED))))
    };
    let position = [1.0, 2.0, 3.0];
    let right =
        |position, near, far, depth, side| DepthMapCube::cameras(position, near, far, depth, side).map_err(text);
    let cameras = right(position, 0.1, None, REVERSED, 16)?;
    let with = |face: usize, camera: ShadowCamera| {
        let mut cameras = cameras;
        cameras[face] = camera;
        given(cameras)
    };
    let apart = |face, what| is(DepthMapError::Apart { face, what });
    let lost = ShadowCamera { view_projection: [[0.0; 4]; 4], ..cameras[2] };
    let parallel = Eye { far: Some(9.0), half_width: Some(2.0), ..look(DVec3::ZERO, DVec3::X, 0.1) }.camera();
    let singular = DepthMapError::CubeLight { face: 1, error: CameraError::Singular };
    let [width, elsewhere, depths] = [
        "the middles of its outermost texels are not 45° from its middle",
        "it is at another position",
        "its near or far distance, or the scale of its matrix, differs",
    ];
    let axis = "it does not look along its axis of the cube, or is rotated";
    let ended = right(position, 0.1, Some(50.0), REVERSED, 16)?[4];
    let standard = right(position, 0.1, None, STANDARD, 16)?[3];
    refused([
        refusal("right", given(cameras)?, Expected::Taken),
        // Cameras for 90°: the width of a map with very many texels.
        refusal("90°", given(right(position, 0.1, None, REVERSED, 1 << 20)?)?, apart(0, width)),
        refusal("of 15 texels", given(right(position, 0.1, None, REVERSED, 15)?)?, apart(0, width)),
        refusal("position", with(1, right([1.0, 2.0, 3.001], 0.1, None, REVERSED, 16)?[1])?, apart(1, elsewhere)),
        refusal("near", with(5, right(position, 0.2, None, REVERSED, 16)?[5])?, apart(5, depths)),
        refusal("axis", with(3, cameras[2])?, apart(3, axis)),
        refusal("far", with(4, ended)?, apart(4, depths)),
        refusal("direction", with(3, standard)?, apart(3, "its depth direction differs")),
        refusal("parallel", with(0, parallel)?, is(DepthMapError::Parallel { face: 0 })),
        refusal("singular", with(1, lost)?, is(singular)),
    ])
}

fn cameras() -> Result<(), String> {
    let (inf, nan, position) = (f32::INFINITY, f32::NAN, [1.0, 2.0, 3.0]);
    let (at_least, near) = ("at least 3 texels a side", "`near` is ");
    let (range, far) = ("leave the normal range", "`near` 0.1; take a finite distance above `near`");
    let finite = "take finite coordinates";
    for depth in [REVERSED, STANDARD] {
        refused(
            [
                (position, 0.1, Some(50.0), 0, at_least),
                (position, 0.1, Some(50.0), 1, at_least),
                (position, 0.1, Some(50.0), 2, at_least),
                (position, 0.1, Some(50.0), 3, ""),
                (position, 0.0, None, 16, near),
                (position, -0.1, None, 16, near),
                (position, inf, None, 16, near),
                (position, nan, None, 16, near),
                (position, f32::MIN_POSITIVE, None, 16, range),
                (position, 1e-33, None, 16, ""),
                (position, 0.1, Some(0.1), 16, far),
                (position, 0.1, Some(0.05), 16, far),
                (position, 0.1, Some(-1.0), 16, far),
                (position, 0.1, Some(inf), 16, far),
                (position, 0.1, Some(nan), 16, far),
                (position, 0.1, Some(0.2), 16, ""),
                ([nan, 0.0, 0.0], 0.1, None, 16, finite),
                ([0.0, inf, 0.0], 0.1, None, 16, finite),
                ([1e30, 0.0, 0.0], 0.1, None, 16, ""),
            ]
            .map(|(position, near, far, side, part)| {
                let expected = if part.is_empty() { Expected::Taken } else { says(&[part]) };
                let made = DepthMapCube::cameras(position, near, far, depth, side);
                refusal(format!("{position:?} {near} {far:?} {side} {depth:?}"), made, expected)
            }),
        )?;
    }
    Ok(())
}

/// The limit of memory holds for textures and buffers together, and for those of the first objects.
fn memory() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, REVERSED, 7..8)?;
    let cameras = DepthMapCube::cameras([1.0, 2.0, 3.0], 0.1, None, REVERSED, 16).map_err(text)?;
    let made = |memory_limit| {
        DepthMapCube::new(&pipelines, 16, DepthMapOptions { memory_limit: Some(memory_limit), ..Default::default() })
    };
    let needed = |error: Option<DepthMapError>| match error {
        Some(DepthMapError::Device(DeviceError::MemoryLimit { bytes, .. })) => Ok(bytes),
        other => Err(format!("{other:?}")),
    };
    let texels = 6 * 16 * 16;
    let plain = needed(made(1).err())?;
    let map = depth_view(&texture(&gpu, [16; 2], TextureFormat::R32Float, &[0.5; 256])?);
    let objects = objects(&gpu, [16; 2], &[0; 256]);
    let with = |memory_limit, face: Option<usize>| {
        let mut cube = made(memory_limit).map_err(text)?;
        let mut maps = DepthCubeMaps { textures: [None; 6], lights: cameras, objects: [None; 6] };
        maps.textures[0] = Some(&map);
        if let Some(face) = face {
            maps.objects[face] = Some(&objects);
        }
        let found = gpu.submit(|encoder| Ok(cube.encode(encoder, &maps, &camera(REVERSED)).err()))?;
        Ok::<_, String>((found, cube.cells().size()))
    };
    let (found, cells) = with(plain, None)?;
    let all = needed(with(plain, Some(0))?.0)?;
    if all - plain != 4 * texels || plain < 4 * texels + cells {
        return Err(format!("{plain} bytes, {all} with objects"));
    }
    let found = [found, with(all, Some(0))?.0, with(all, Some(1))?.0];
    same("enough", &found, &[None, None, Some(DepthMapError::NoObjects { face: 0 })])?;
    needed(with(all - 1, Some(0))?.0).map(drop)
}

fn made() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let most = gpu.device.limits().max_texture_dimension_2d;
    let too_large = |size| is(DepthMapError::Texture { size, max_side: most });
    refused([
        refusal("no width", DepthMapMerge::new(&gpu.pipelines, [0, 4]), is(DepthMapError::Size(0, 4))),
        refusal("no height", DepthMapMerge::new(&gpu.pipelines, [4, 0]), is(DepthMapError::Size(4, 0))),
        refusal("too wide", DepthMapMerge::new(&gpu.pipelines, [most + 1, 1]), too_large([most + 1, 1])),
        refusal("a conversion", DepthMapConversion::new(&gpu.pipelines, [0, 4]), is(DepthMapError::Size(0, 4))),
        refusal("too high", DepthMapConversion::new(&gpu.pipelines, [1, most + 1]), too_large([1, most + 1])),
    ])?;
    let view = |size: [u32; 2], format| {
        let depths = vec![0.5; (size[0] * size[1]) as usize];
        Ok::<_, String>(depth_view(&texture(&gpu, size, format, &depths)?))
    };
    let fixed = view([4, 4], TextureFormat::Depth16Unorm)?;
    let (right, large) = (view([4, 4], TextureFormat::R32Float)?, view([4, 5], TextureFormat::R32Float)?);
    let depth = view([4, 4], TextureFormat::Depth32Float)?;
    let size = |map: &str| is(DepthMapError::MapSize { map: map.to_owned(), given: [4, 5], made: [4, 4] });
    let light = camera(STANDARD);
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..light };
    let eye = |near: f64, far| Eye { far, ..look(DVec3::ZERO, DVec3::NEG_Z, near) }.camera();
    // Planes that are too close to each other, and a near plane that is too close to the light.
    let (narrow, tiny, good) = (eye(1.0, Some(1.0005)), eye(1e-31, None), eye(1e-29, None));
    let format = DepthMapError::MapFormat {
        map: "the map".to_owned(),
        format: TextureFormat::Depth32Float,
        accepted: "R32Float for distances, or `DepthMetric::Device` for device depths",
    };
    let merge = DepthMapMerge::new(&gpu.pipelines, [4, 4]).map_err(text)?;
    let conversion = DepthMapConversion::new(&gpu.pipelines, [4, 4]).map_err(text)?;
    let of_light = || is(DepthMapError::Light(CameraError::Singular));
    let [device, axis, ray] = [DepthMetric::Device, DepthMetric::AlongAxis, DepthMetric::AlongRay];
    gpu.submit(|encoder| {
        let mut encode = |maps| merge.encode(encoder, maps, STANDARD);
        refused([
            refusal("map 1", encode([&fixed, &large]), size("map 1 of the merge")),
            refusal("map 0", encode([&large, &fixed]), size("map 0 of the merge")),
            refusal("its own", encode([merge.texture(), &fixed]), is(DepthMapError::OwnResult)),
            refusal("the same twice", encode([&fixed; 2]), Expected::Taken),
        ])?;
        let mut encode = |texture, light, metric| conversion.encode(encoder, &DepthMap::new(texture, light), metric);
        refused([
            refusal("size", encode(&large, light, ray), size("the map")),
            refusal("own", encode(conversion.texture(), light, ray), is(DepthMapError::OwnResult)),
            refusal("format", encode(&depth, light, axis), is(format)),
            refusal("light", encode(&right, singular, axis), of_light()),
            refusal("light of depths", encode(&right, singular, device), of_light()),
            refusal("distances", encode(&right, light, ray), Expected::Taken),
            refusal("depths", encode(&depth, light, device), Expected::Taken),
            refusal("the nearest plane", encode(&right, good, ray), Expected::Taken),
            refusal("planes that distances need", encode(&right, narrow, device), Expected::Taken),
        ])
    })?;
    let skewed = aside(light, [3000.0, 0.0]);
    refused(
        [narrow, tiny, skewed]
            .map(|camera| refusal("planes", metric_view(&camera, [4, 4], ray), shows(&["Distances {"]))),
    )
}

fn scenes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1717)?;
    let [mut casters, mut other] = [Casters::new(&gpu)?, Casters::new(&gpu)?];
    casters.fill(&gpu, &mut random, (4, 1.0))?;
    other.fill(&gpu, &mut random, (4, 1.0))?;
    let of_other = [other.placed[0].handle];
    let removed = casters.placed.swap_remove(1);
    casters.scene.remove(removed.handle).map_err(text)?;
    let dangling = [casters.placed[0].handle, removed.handle];
    let old = casters.scene.add_light(Light::point([1.0; 3])).map_err(text)?;
    let foreign = other.scene.add_light(Light::point([1.0; 3])).map_err(text)?;
    casters.scene.remove_light(old).map_err(text)?;
    let (light, standard) = (camera(REVERSED), camera(STANDARD));
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..light };
    let draws = SceneDepth::new(&gpu.pipelines, FORMATS[0], light.depth).map_err(text)?;
    // A scene of another device.
    let another = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let mut of_another = Casters::new(&another)?;
    of_another.fill(&another, &mut random, (4, 0.1))?;
    let straight = look(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z, 0.1).camera();
    // A mesh whose positions end too early.
    let shape = shapes::cube();
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Keep).map_err(text)?;
    let of_mesh = MeshDepth::new(&gpu.pipelines, &mesh, FORMATS[0], light.depth).map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let positions = |offset| PositionBuffer { buffer: &buffer, offset, stride: 12 };
    let (of_removed, of_other_scene) = (|what| ShadowError::Removed { what }, |what| ShadowError::OtherScene { what });
    let of_scene = |error| is(DepthMapError::Shadow(error));
    let mismatch = || is(DepthMapError::Depth { what: "the light", given: STANDARD, made: REVERSED });
    let depths = map(&gpu, FORMATS[0], &light, |pass| {
        let mut draw = |which, light| draws.draw(pass, &casters.scene, which, light);
        let all = SceneDepthCasters::All;
        refused([
            refusal("only", draw(SceneDepthCasters::Only(&dangling), &light), of_scene(of_removed("caster"))),
            refusal("except", draw(SceneDepthCasters::Except(&dangling), &light), of_scene(of_removed("caster"))),
            refusal("other", draw(SceneDepthCasters::Only(&of_other), &light), of_scene(of_other_scene("caster"))),
            refusal("light", draw(SceneDepthCasters::NotCastingFor(old), &light), of_scene(of_removed("light"))),
            refusal(
                "foreign",
                draw(SceneDepthCasters::NotCastingFor(foreign), &light),
                of_scene(of_other_scene("light")),
            ),
            refusal("direction", draw(all, &standard), mismatch()),
            refusal("singular", draw(all, &singular), is(DepthMapError::Light(CameraError::Singular))),
        ])?;
        refused([
            refusal("device", draws.draw(pass, &of_another.scene, all, &straight), shows(&["Refused {"])),
            refusal("short", of_mesh.draw(pass, positions(12), &light), shows(&["PositionsTooShort {"])),
            refusal("direction of a mesh", of_mesh.draw(pass, positions(0), &standard), mismatch()),
        ])
    })?;
    same("nothing is drawn", &depths, &[0.0; (SIDE * SIDE) as usize])?;
    let color = SceneDepth::new(&gpu.pipelines, TextureFormat::R32Float, light.depth);
    refused([refusal("format", color, is(DepthMapError::NoDepth(TextureFormat::R32Float)))])
}
