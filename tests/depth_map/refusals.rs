//! Input that is refused, and the errors for it.

use glam::DVec3;
use rimline::gpu::depth_map::{
    DanglingEdges, DepthCubeMaps, DepthMap, DepthMapCube, DepthMapError, DepthMapMethod, DepthMapOptions,
    DepthMapPipelines, DepthMapTexture, DepthMapVolumes, DepthMetric, MeshDepth, SceneDepth, SceneDepthCasters,
};
use rimline::gpu::{DeviceError, PositionBuffer, ShadowError, ShadowFormat};
use rimline::mesh::Weld;
use rimline::{CameraError, Light, Mesh, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::Eye;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::{self, depth_pass};
use rimline_testkit::refusals::{Expected, is, refusal, refused, says, shows};
use rimline_testkit::{same, shapes};
use wgpu::TextureFormat;

use crate::metric::aside;
use crate::picture::{REVERSED, STANDARD, by, contours, differences, look, pipelines};
use crate::scene_depth::{Casters, FORMATS, SIDE, map};
use crate::stages::camera;

pub(crate) const TESTS: &[Test] = &[
    ("pipelines_and_volumes_that_cannot_be_made", making),
    ("maps_objects_and_cameras_that_cannot_be_taken", encoding),
    ("frames_that_cannot_be_drawn", drawing),
    ("cubes_that_do_not_meet_are_refused", cubes),
    ("cameras_of_cubes_that_are_none_are_refused", cameras),
    ("the_limit_of_memory_holds_for_objects_of_cubes", memory),
    ("merges_and_conversions_that_cannot_be_made_or_recorded", made),
    ("depths_of_scenes_that_are_refused", scenes),
    ("errors_tell_which_texture_is_wrong", sentences),
];

/// Whole sentences: what is wrong, where, and what to do.
fn sentences() -> Result<(), String> {
    let map = || "map 2 of the cube".to_owned();
    let found = [
        DepthMapError::MapSize { map: map(), given: [9, 8], made: [4, 4] },
        DepthMapError::Usage(map()),
        DepthMapError::Samples { map: map(), samples: 4 },
        DepthMapError::MapFormat { map: map(), format: TextureFormat::R32Sint, accepted: "R32Uint" },
        DepthMapError::MipLevels { map: map(), levels: 3 },
        DepthMapError::NoObjects { face: 4 },
        DepthMapError::Option { name: "share", given: 1.5, range: "a share from 0 to 1" },
    ]
    .map(|error| error.to_string());
    let expected = [
        "map 2 of the cube has 9 × 8 texels, and 4 × 4 are needed; give textures of the size that was given to \
         `new`, or call `new` again",
        "map 2 of the cube lacks usage TEXTURE_BINDING; make the texture with it",
        "map 2 of the cube has 4 samples a texel; resolve it, or render it with one",
        "map 2 of the cube has R32Sint; take R32Uint",
        "map 2 of the cube has 3 mip levels; give a texture of one, for example a copy of that level",
        "map 4 of the cube has no texture of objects; give one for each map that is there, or none",
        "`share` is 1.5; take a share from 0 to 1",
    ]
    .map(str::to_owned);
    same("sentences", &found, &expected)
}

fn singular(camera: ShadowCamera) -> ShadowCamera {
    ShadowCamera { view_projection: [[0.0; 4]; 4], ..camera }
}

/// The bytes that an error says are needed.
fn needed(error: Option<DepthMapError>) -> Result<u64, String> {
    match error {
        Some(DepthMapError::Device(DeviceError::MemoryLimit { bytes, .. })) => Ok(bytes),
        other => Err(format!("{other:?}")),
    }
}

fn making() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let plain = ShadowFormat::default();
    let no_stencil = ShadowFormat { depth_stencil: TextureFormat::Depth32Float, ..plain.clone() };
    let stencil = DepthMapError::Shadow(ShadowError::NoStencil(TextureFormat::Depth32Float));
    let of_bits = |bits| DepthMapPipelines::antialiased(&gpu.pipelines, &plain, bits);
    // Parity bits beside counts of meshes.
    let beside = |count_bits, bits| {
        DepthMapPipelines::beside_meshes(&gpu.pipelines, &ShadowFormat { count_bits, ..plain.clone() }, bits)
    };
    refused([
        refusal("bit", DepthMapPipelines::new(&gpu.pipelines, &plain, 8), is(DepthMapError::Bits(8..9))),
        refusal("no bits", of_bits(3..3), is(DepthMapError::Bits(3..3))),
        refusal("stencil", DepthMapPipelines::new(&gpu.pipelines, &no_stencil, 0), is(stencil)),
        refusal("all count", beside(8, 7..8), is(DepthMapError::Counted { bit: 7, count_bits: 8 })),
        refusal("the lowest counts", beside(8, 0..1), is(DepthMapError::Counted { bit: 0, count_bits: 8 })),
        refusal("no bit beside", beside(4, 5..5), is(DepthMapError::Bits(5..5))),
        refusal("one of two", beside(7, 6..8), is(DepthMapError::Counted { bit: 6, count_bits: 7 })),
        refusal("no bit of the stencil", beside(7, 8..9), is(DepthMapError::Bits(8..9))),
    ])?;
    same("bits", &[beside(7, 7..8).map_err(text)?.bits(), beside(4, 4..8).map_err(text)?.bits()], &[7..8, 4..8])?;
    let (one, two) = (of_bits(7..8).map_err(text)?, of_bits(6..8).map_err(text)?);
    let made = |size, options| DepthMapVolumes::new(&one, size, options);
    refused([[0, 5], [5, 0], [u32::MAX, u32::MAX], [1 << 15, 1 << 15]].map(|size| {
        refusal("size", made(size, DepthMapOptions::default()), is(DepthMapError::Size(size[0], size[1])))
    }))?;
    let second = |low, high| by(DepthMapMethod::SecondDifferences { low, high, dangling: None });
    let dangling = |share, cells| by(DepthMapMethod::Automatic { dangling: Some(DanglingEdges { share, cells }) });
    let biased = |slope_bias, options| DepthMapOptions { slope_bias, ..options };
    let walled = by(contours([1.0, 0.25, 0.01]));
    // The number that is refused, if one is.
    let mut rows = vec![
        (second(0.5, 0.4), "low"),
        (second(0.5, 1.5), "high"),
        (second(0.5, 0.5), ""),
        (by(contours([1.5, 0.25, 0.01])), "threshold"),
        (by(contours([0.01, 0.6, 0.01])), "sideways"),
        (by(contours([0.01, 0.25, 1.5])), "depth"),
        (by(contours([1.0, 0.5, 1.0])), ""),
        (biased(255.0, walled), ""),
        (biased(255.5, walled), "slope_bias"),
        (by(differences(1.5)), "threshold"),
        (dangling(1.5, 1), "share"),
        (dangling(0.5, 0), "cells"),
        (dangling(0.5, 65), "cells"),
        (
            by(DepthMapMethod::Differences { threshold: 0.5, dangling: Some(DanglingEdges { share: 2.0, cells: 1 }) }),
            "share",
        ),
        (
            by(DepthMapMethod::SecondDifferences {
                low: 0.5,
                high: 0.5,
                dangling: Some(DanglingEdges { share: 0.5, cells: 65 }),
            }),
            "cells",
        ),
    ];
    for bad in [-0.1, f32::INFINITY, f32::NAN] {
        rows.extend([
            (second(bad, 0.5), "low"),
            (by(differences(bad)), "threshold"),
            (by(contours([bad, 0.25, 0.01])), "threshold"),
            (by(contours([0.01, bad, 0.01])), "sideways"),
            (by(contours([0.01, 0.25, bad])), "depth"),
            (biased(bad, DepthMapOptions::default()), "slope_bias"),
            (dangling(bad, 1), "share"),
        ]);
    }
    refused(rows.into_iter().map(|(options, name)| {
        let wrong = shows(&[&format!("Option {{ name: {name:?}")]);
        refusal(format!("{options:?}"), made([4, 4], options), if name.is_empty() { Expected::Taken } else { wrong })
    }))?;
    let format = TextureFormat::Rgba8Unorm;
    let rounded = DepthMapOptions { rounded_to: Some(format), ..Default::default() };
    // Eight bytes for a sample, which one binding holds.
    let side = gpu.device.limits().max_texture_dimension_2d;
    let limit = gpu.device.limits().max_storage_buffer_binding_size / 256 * 256;
    let is_taken = 4 * (u64::from(side) + 2).pow(2) <= limit;
    let too_large = shows(&["BindingTooLarge {", &format!("limit: {limit}")]);
    // The limit of memory holds for all buffers together.
    let limited =
        |memory_limit, options| made([40; 2], DepthMapOptions { memory_limit: Some(memory_limit), ..options });
    let bytes = needed(limited(1, walled).err())?;
    let largest = made([40; 2], walled).map_err(text)?.cells().size();
    if bytes <= largest {
        return Err(format!("{bytes} bytes, {largest} of them for walls"));
    }
    refused([
        refusal("format", made([4, 4], rounded), is(DepthMapError::RoundedTo(format))),
        refusal("bits", DepthMapVolumes::new(&two, [8, 8], walled), is(DepthMapError::OneBit(2))),
        refusal("the largest map", made([side; 2], walled), if is_taken { Expected::Taken } else { too_large }),
        refusal("enough", limited(bytes, walled), Expected::Taken),
        refusal("a byte less", limited(bytes - 1, walled), shows(&["Device(MemoryLimit {"])),
        refusal("no memory", limited(0, walled), shows(&["Device(MemoryLimit {", "limit: 0"])),
        refusal("100 bytes", limited(100, DepthMapOptions::default()), shows(&["Device(MemoryLimit {", "limit: 100"])),
    ])
}

/// A level of a texture of so many texels a side, samples and levels.
fn view(
    gpu: &Gpu,
    (format, side): (TextureFormat, u32),
    [sample_count, mip_level_count, base_mip_level]: [u32; 3],
    usage: wgpu::TextureUsages,
) -> wgpu::TextureView {
    let plain = passes::texture([side; 2], format);
    let texture = wgpu::TextureDescriptor { sample_count, mip_level_count, usage, ..plain.clone() };
    let level = wgpu::TextureViewDescriptor { base_mip_level, mip_level_count: Some(1), ..Default::default() };
    gpu.device.create_texture(&texture).create_view(&level)
}

const DRAWN: wgpu::TextureUsages = wgpu::TextureUsages::RENDER_ATTACHMENT;
const READ: wgpu::TextureUsages = wgpu::TextureUsages::TEXTURE_BINDING;
const ONE: [u32; 3] = [1, 1, 0];
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

fn encoding() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, REVERSED, 3..4)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let mut encode = |texture: &wgpu::TextureView, objects: Option<&wgpu::TextureView>, light, eye: ShadowCamera| {
        gpu.submit(|encoder| Ok(volumes.encode(encoder, &DepthMap { texture, light, objects }, &eye)))
    };
    let (good, standard) = (camera(REVERSED), camera(STANDARD));
    let accepted = "Depth16Unorm, Depth24Plus, Depth32Float, or R32Float";
    let (half, map) = (TextureFormat::R16Float, || "the map".to_owned());
    let wrong_format = is(DepthMapError::MapFormat { map: map(), format: half, accepted });
    let wrong_size = is(DepthMapError::MapSize { map: map(), given: [9, 9], made: [8, 8] });
    let levels = || is(DepthMapError::MipLevels { map: map(), levels: 2 });
    for (what, format, counts, usage, expected) in [
        ("good", (DEPTH, 8), ONE, DRAWN | READ, Expected::Taken),
        ("format", (half, 8), ONE, DRAWN | READ, wrong_format),
        ("size", (DEPTH, 9), ONE, DRAWN | READ, wrong_size),
        ("samples", (DEPTH, 8), [4, 1, 0], DRAWN | READ, is(DepthMapError::Samples { map: map(), samples: 4 })),
        ("usage", (DEPTH, 8), ONE, DRAWN, is(DepthMapError::Usage(map()))),
        // The second level has the right size, and so has the first; the view does not say which is shown.
        ("the second level", (DEPTH, 16), [1, 2, 1], READ, levels()),
        ("the first of two levels", (DEPTH, 8), [1, 2, 0], READ, levels()),
        ("the second of two levels", (DEPTH, 8), [1, 2, 1], READ, levels()),
    ] {
        refused([refusal(what, encode(&view(&gpu, format, counts, usage), None, standard, good)?, expected)])?;
    }
    let map = view(&gpu, (DEPTH, 8), ONE, DRAWN | READ);
    let of = |format, side, usage| view(&gpu, (format, side), ONE, usage);
    let (right, large) = (of(TextureFormat::R32Uint, 8, READ), of(TextureFormat::R32Uint, 9, READ));
    let unbound = of(TextureFormat::R32Uint, 8, wgpu::TextureUsages::COPY_DST);
    let signed = of(TextureFormat::R32Sint, 8, READ);
    let two_levels = view(&gpu, (TextureFormat::R32Uint, 8), [1, 2, 0], READ);
    let levels = DepthMapError::MipLevels { map: "the texture of objects".to_owned(), levels: 2 };
    let name = || "the texture of objects".to_owned();
    let format = DepthMapError::MapFormat { map: name(), format: TextureFormat::R32Sint, accepted: "R32Uint" };
    let size = DepthMapError::MapSize { map: name(), given: [9, 9], made: [8, 8] };
    let aspects = of(TextureFormat::Depth24PlusStencil8, 8, DRAWN | READ);
    let mismatch = DepthMapError::Depth { what: "the eye", given: STANDARD, made: REVERSED };
    // The far plane is behind infinity by rounding: w is 0 before the depth is that of the far end.
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -0.999, -0.1], [0.0, 0.0, -1.0, 0.0]];
    let columns = std::array::from_fn(|column| rows.map(|row: [f32; 4]| row[column]));
    let behind = ShadowCamera { view_projection: columns, origin: [0.0; 3], depth: STANDARD };
    refused([
        refusal("objects", encode(&map, Some(&right), good, good)?, Expected::Taken),
        refusal("size of objects", encode(&map, Some(&large), good, good)?, is(size)),
        refusal("usage of objects", encode(&map, Some(&unbound), good, good)?, is(DepthMapError::Usage(name()))),
        refusal("format of objects", encode(&map, Some(&signed), good, good)?, is(format)),
        refusal("levels of objects", encode(&map, Some(&two_levels), good, good)?, is(levels)),
        refusal("two aspects", encode(&aspects, None, standard, good)?, shows(&["Refused {"])),
        refusal("depth", encode(&map, None, good, standard)?, is(mismatch)),
        refusal("eye", encode(&map, None, good, singular(good))?, is(DepthMapError::Camera(CameraError::Singular))),
        refusal("light", encode(&map, None, singular(good), good)?, is(DepthMapError::Light(CameraError::Singular))),
        refusal("far plane", encode(&map, None, behind, good)?, is(DepthMapError::FarPlane)),
    ])
}

fn drawing() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let [pipelines, standard] = [pipelines(&gpu, REVERSED, 3..4)?, pipelines(&gpu, STANDARD, 3..4)?];
    // Where the device has it, another format of the eye's depth.
    let other = TextureFormat::Depth32FloatStencil8;
    let has_other = gpu.device.features().contains(other.required_features());
    let other = ShadowFormat { depth_stencil: other, ..Default::default() };
    let other = has_other.then(|| DepthMapPipelines::new(&gpu.pipelines, &other, 0)).transpose().map_err(text)?;
    let new = |options| DepthMapVolumes::new(&pipelines, [8, 8], options).map_err(text);
    let [mut volumes, mut walled] = [new(DepthMapOptions::default())?, new(by(contours([1.0, 0.25, 0.001])))?];
    let map = view(&gpu, (DEPTH, 8), ONE, DRAWN | READ);
    let view = view(&gpu, (TextureFormat::Depth24PlusStencil8, 8), ONE, DRAWN);
    gpu.submit(|encoder| {
        let map = DepthMap { texture: &map, light: camera(REVERSED), objects: None };
        let first = volumes.encode(encoder, &map, &camera(REVERSED)).map_err(text)?;
        let second = volumes.encode(encoder, &map, &camera(REVERSED)).map_err(text)?;
        let walls = walled.encode(encoder, &map, &camera(REVERSED)).map_err(text)?;
        let mut pass = encoder.begin_render_pass(&depth_pass(&view, (None, Some(wgpu::LoadOp::Load))));
        let mismatch = DepthMapError::Depth { what: "the pipelines", given: STANDARD, made: REVERSED };
        refused([
            refusal("an earlier frame", first.draw(&mut pass, &pipelines), is(DepthMapError::StaleFrame)),
            refusal("depth", second.draw(&mut pass, &standard), is(mismatch)),
            refusal("the later frame", second.draw(&mut pass, &pipelines), Expected::Taken),
            refusal("walls", walls.draw(&mut pass, &pipelines), Expected::Taken),
        ])?;
        let [volumes, pipelines] = [TextureFormat::Depth24PlusStencil8, TextureFormat::Depth32FloatStencil8];
        let format = || is(DepthMapError::DepthFormat { volumes, pipelines });
        refused(other.iter().map(|other| refusal("format", second.draw(&mut pass, other), format())))
    })
}

fn cubes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let [one, two] = [pipelines(&gpu, REVERSED, 7..8)?, pipelines(&gpu, REVERSED, 6..8)?];
    let made = |side| DepthMapCube::new(&one, side, DepthMapOptions::default());
    let most = gpu.device.limits().max_texture_dimension_2d;
    let walled = DepthMapCube::new(&one, 8, by(contours([0.01, 0.25, 0.01])));
    refused([
        refusal("0", made(0), is(DepthMapError::Side(0))),
        refusal("2", made(2), is(DepthMapError::Side(2))),
        refusal("most", made(most), is(DepthMapError::Texture { size: [3 * most, 2 * most], max_side: most })),
        // The largest side that the message of the next one names.
        refusal("9,460", made(9460), is(DepthMapError::Texture { size: [28_380, 18_920], max_side: most })),
        refusal("9,461", made(9461), is(DepthMapError::Cells(9461))),
        refusal("20,000", made(20_000), is(DepthMapError::Cells(20_000))),
        refusal("u32::MAX", made(u32::MAX), is(DepthMapError::Cells(u32::MAX))),
        refusal("bits", DepthMapCube::new(&two, 16, DepthMapOptions::default()), is(DepthMapError::OneBit(2))),
        refusal("contours", walled, is(DepthMapError::CubeContours)),
    ])?;
    // Nothing is there.
    let given = |lights: [ShadowCamera; 6]| {
        let mut cube = made(16).map_err(text)?;
        let maps = DepthCubeMaps { textures: [None; 6], lights, objects: [None; 6] };
        gpu.submit(|encoder| Ok(cube.encode(encoder, &maps, &camera(REVERSED))))
    };
    let of = |position, near, far, depth, side| DepthMapCube::cameras(position, near, far, depth, side).map_err(text);
    let position = [1.0, 2.0, 3.0];
    let cameras = of(position, 0.1, None, REVERSED, 16)?;
    let with = |face: usize, camera: ShadowCamera| {
        let mut cameras = cameras;
        cameras[face] = camera;
        given(cameras)
    };
    let apart = |face, what| is(DepthMapError::Apart { face, what });
    let parallel = Eye { far: Some(9.0), half_width: Some(2.0), ..look(DVec3::ZERO, DVec3::X, 0.1) }.camera();
    let no_inverse = is(DepthMapError::CubeLight { face: 1, error: CameraError::Singular });
    let [width, elsewhere, depths] = [
        "the middles of its outermost texels are not 45° from its middle",
        "it is at another position",
        "its near or far distance, or the scale of its matrix, differs",
    ];
    let axis = "it does not look along its axis of the cube, or is rotated";
    let standard = of(position, 0.1, None, STANDARD, 16)?[3];
    refused([
        refusal("right", given(cameras)?, Expected::Taken),
        // Cameras for 90°: the width of a map with very many texels.
        refusal("90°", given(of(position, 0.1, None, REVERSED, 1 << 20)?)?, apart(0, width)),
        refusal("of 15 texels", given(of(position, 0.1, None, REVERSED, 15)?)?, apart(0, width)),
        refusal("position", with(1, of([1.0, 2.0, 3.001], 0.1, None, REVERSED, 16)?[1])?, apart(1, elsewhere)),
        refusal("near", with(5, of(position, 0.2, None, REVERSED, 16)?[5])?, apart(5, depths)),
        refusal("far", with(4, of(position, 0.1, Some(50.0), REVERSED, 16)?[4])?, apart(4, depths)),
        refusal("axis", with(3, cameras[2])?, apart(3, axis)),
        refusal("direction", with(3, standard)?, apart(3, "its depth direction differs")),
        refusal("parallel", with(0, parallel)?, is(DepthMapError::Parallel { face: 0 })),
        refusal("singular", with(1, singular(cameras[2]))?, no_inverse),
    ])
}

fn cameras() -> Result<(), String> {
    let (inf, nan, position) = (f32::INFINITY, f32::NAN, [1.0, 2.0, 3.0]);
    let (at_least, near) = ("at least 3 texels a side", "`near` is ");
    let (range, far) = ("leave the normal range", "`near` 0.1; take a finite distance above `near`");
    let finite = "take finite coordinates";
    let rows = [
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
    ];
    refused([REVERSED, STANDARD].into_iter().flat_map(|depth| {
        rows.map(|(position, near, far, side, part)| {
            let expected = if part.is_empty() { Expected::Taken } else { says(&[part]) };
            let made = DepthMapCube::cameras(position, near, far, depth, side);
            refusal(format!("{position:?} {near} {far:?} {side} {depth:?}"), made, expected)
        })
    }))
}

/// The limit of memory holds for textures and buffers together, and for those of the first objects.
fn memory() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, REVERSED, 7..8)?;
    let cameras = DepthMapCube::cameras([1.0, 2.0, 3.0], 0.1, None, REVERSED, 16).map_err(text)?;
    let made = |memory_limit| {
        DepthMapCube::new(&pipelines, 16, DepthMapOptions { memory_limit: Some(memory_limit), ..Default::default() })
    };
    let texels = 6 * 16 * 16;
    let plain = needed(made(1).err())?;
    let map = view(&gpu, (DEPTH, 16), ONE, DRAWN | READ);
    let objects = view(&gpu, (TextureFormat::R32Uint, 16), ONE, READ);
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
        refusal("no width", DepthMapTexture::new(&gpu.pipelines, [0, 4]), is(DepthMapError::Size(0, 4))),
        refusal("no height", DepthMapTexture::new(&gpu.pipelines, [4, 0]), is(DepthMapError::Size(4, 0))),
        refusal("too wide", DepthMapTexture::new(&gpu.pipelines, [most + 1, 1]), too_large([most + 1, 1])),
        refusal("too high", DepthMapTexture::new(&gpu.pipelines, [1, most + 1]), too_large([1, most + 1])),
    ])?;
    let of = |format, side| view(&gpu, (format, side), ONE, DRAWN | READ);
    let (fixed, depth) = (of(TextureFormat::Depth16Unorm, 4), of(DEPTH, 4));
    let (right, large) = (of(TextureFormat::R32Float, 4), of(TextureFormat::R32Float, 5));
    let size = |map: &str| is(DepthMapError::MapSize { map: map.to_owned(), given: [5, 5], made: [4, 4] });
    let light = camera(STANDARD);
    let eye = |near: f64, far| Eye { far, ..look(DVec3::ZERO, DVec3::NEG_Z, near) }.camera();
    // Planes that are too close to each other, and a near plane that is too close to the light.
    let (narrow, tiny, good, skewed) =
        (eye(1.0, Some(1.0005)), eye(1e-31, None), eye(1e-29, None), aside(light, [3000.0, 0.0]));
    let format = DepthMapError::MapFormat {
        map: "the map".to_owned(),
        format: DEPTH,
        accepted: "R32Float for distances, or `DepthMetric::Device` for device depths",
    };
    let merge = DepthMapTexture::new(&gpu.pipelines, [4, 4]).map_err(text)?;
    let conversion = DepthMapTexture::new(&gpu.pipelines, [4, 4]).map_err(text)?;
    let of_light = || is(DepthMapError::Light(CameraError::Singular));
    let [device, axis, ray] = [DepthMetric::Device, DepthMetric::AlongAxis, DepthMetric::AlongRay];
    gpu.submit(|encoder| {
        let mut encode = |maps| merge.merge(encoder, maps, STANDARD);
        refused([
            refusal("map 1", encode([&fixed, &large]), size("map 1 of the merge")),
            refusal("map 0", encode([&large, &fixed]), size("map 0 of the merge")),
            refusal("its own", encode([merge.view(), &fixed]), is(DepthMapError::MapIsResult)),
            refusal("the same twice", encode([&fixed; 2]), Expected::Taken),
        ])?;
        let mut encode = |texture, light, metric| conversion.convert(encoder, &DepthMap::new(texture, light), metric);
        refused([
            refusal("size", encode(&large, light, ray), size("the map")),
            refusal("own", encode(conversion.view(), light, ray), is(DepthMapError::MapIsResult)),
            refusal("format", encode(&depth, light, axis), is(format)),
            refusal("light", encode(&right, singular(light), axis), of_light()),
            refusal("light of depths", encode(&right, singular(light), device), of_light()),
            refusal("distances", encode(&right, light, ray), Expected::Taken),
            refusal("depths", encode(&depth, light, device), Expected::Taken),
            refusal("the nearest plane", encode(&right, good, ray), Expected::Taken),
            refusal("planes that distances need", encode(&right, narrow, device), Expected::Taken),
        ])?;
        let wrong = |light| refusal("planes", encode(&right, light, ray), shows(&["Distances {"]));
        refused([narrow, tiny, skewed].map(wrong))
    })
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
    let removed = |what| is(DepthMapError::Shadow(ShadowError::Removed { what }));
    let elsewhere = |what| is(DepthMapError::Shadow(ShadowError::OtherScene { what }));
    let mismatch = || is(DepthMapError::Depth { what: "the light", given: STANDARD, made: REVERSED });
    let depths = map(&gpu, FORMATS[0], &light, |pass| {
        let mut draw = |which, light| draws.draw(pass, &casters.scene, which, light);
        let all = SceneDepthCasters::All;
        refused([
            refusal("only", draw(SceneDepthCasters::Only(&dangling), &light), removed("caster")),
            refusal("except", draw(SceneDepthCasters::Except(&dangling), &light), removed("caster")),
            refusal("other", draw(SceneDepthCasters::Only(&of_other), &light), elsewhere("caster")),
            refusal("light", draw(SceneDepthCasters::NotCastingFor(old), &light), removed("light")),
            refusal("foreign", draw(SceneDepthCasters::NotCastingFor(foreign), &light), elsewhere("light")),
            refusal("direction", draw(all, &standard), mismatch()),
            refusal("singular", draw(all, &singular(light)), is(DepthMapError::Light(CameraError::Singular))),
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
