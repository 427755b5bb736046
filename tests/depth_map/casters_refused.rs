//! Depth maps in a scene: what is refused, and how the errors tell.

use glam::DVec3;
use rimline::gpu::{
    DepthEdges, DepthMapCaster, DepthMapCasterHandle, DepthMapCasterVolumes, DepthMapCasters, DepthMapCastersError,
    DepthMapCastersOptions, DepthMapCube, DepthMapCubeCaster, DepthMapCubeError, DepthMapDrawError,
    DepthMapEncodeError, DepthMapOptions, DepthMapPipelines, DepthMapTexture, DepthMapVolumes, DeviceError, Scene,
    SceneFrame, SceneOptions, ShadowFormat,
};
use rimline::{CameraError, DepthDirection, Light, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::same;
use wgpu::TextureFormat;

use crate::casters::{SIDE, SIZE, World, lone};
use crate::picture::stencil_after;
use crate::scene::Eye;
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] =
    &[("casters_that_are_refused", refused), ("casters_in_bits_that_counts_of_a_scene_own", bits)];

/// A scene owns the bits that its options say, if it draws.
fn bits() -> Result<(), String> {
    use DepthMapCastersError as Error;
    let gpu = &*Gpu::shared()?;
    let place = Eye {
        place: DVec3::ZERO,
        forward: DVec3::X,
        near: 0.1,
        is_relative: false,
        depth: DepthDirection::Reversed,
        far: None,
        half_width: None,
    };
    let camera = place.camera();
    let format = |count_bits| ShadowFormat { count_bits, ..Default::default() };
    let parity = |count_bits, bit| DepthMapPipelines::new(&gpu.pipelines, &format(count_bits), bit).map_err(text);
    let counting = |count_bits| DepthMapPipelines::counting(&gpu.pipelines, &format(count_bits)).map_err(text);
    let [highest, seventh, alone] = [parity(7, 7)?, parity(6, 6)?, parity(8, 7)?];
    let counts = [counting(7)?, counting(8)?];
    let mut found = Vec::new();
    for (count_bits, is_drawn) in [(8, true), (7, true), (8, false)] {
        let options = SceneOptions { count_bits, ..Default::default() };
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let light = scene.add_light(Light::point([0.0, 5.0, 0.0])).map_err(text)?;
        let mut casters = DepthMapCasters::new(&scene, DepthMapCastersOptions::default());
        let views = if is_drawn { &[camera][..] } else { &[] };
        let frame = gpu.submit(|encoder| {
            let frame = scene.encode(encoder, views, None).map_err(text)?;
            casters.encode(encoder, &frame, &[camera], None).map_err(text)
        })?;
        stencil_after(gpu, (SIDE, &vec![0.5; (SIDE * SIDE) as usize]), |_| {
            Ok(|pass: &mut wgpu::RenderPass<'_>| {
                let all = [&highest, &seventh, &alone, &counts[0], &counts[1]];
                found.extend(all.map(|pipelines| frame.draw(pass, pipelines, 0, light)));
                Ok(())
            })
        })?;
    }
    let counted = |bit, count_bits| Err(Error::Counted { bit, count_bits });
    let differ = |scene, pipelines| Err(Error::CountBits { scene, pipelines });
    let of_eight = [counted(7, 8), counted(6, 8), counted(7, 8), differ(8, 7), Ok(())];
    let of_seven = [Ok(()), counted(6, 7), Ok(()), Ok(()), differ(7, 8)];
    let undrawn = [Ok(()), Ok(()), Ok(()), Ok(()), Ok(())];
    same("draws", &found, &[of_eight, of_seven, undrawn].concat())
}

fn refused() -> Result<(), String> {
    use DepthMapCastersError as Error;
    let gpu = &*Gpu::shared()?;
    let (mut world, seen, _) = lone(gpu)?;
    let (mut other, ..) = lone(gpu)?;
    let caster = world.casts[0].caster.clone();
    let [own, foreign] = [&world, &other].map(|world| world.casts[0].handles[0]);
    let stale = world.casts[0].handles[1];
    world.casters[1].remove(stale).map_err(text)?;
    let [small, objects] = [(TextureFormat::R32Float, [4, 4]), (TextureFormat::R32Float, SIZE)]
        .map(|(format, size)| texture(gpu, size, format, &[0.0; 63]).map(|texture| depth_view(&texture)));
    let (small, objects) = (small?, objects?);
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..caster.camera };
    let elsewhere = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let pipelines = DepthMapPipelines::new(&elsewhere.pipelines, &ShadowFormat::default(), 7).map_err(text)?;
    let volumes = DepthMapVolumes::new(&pipelines, SIZE, DepthMapOptions::default()).map_err(text)?;
    let spare = world.volumes()?;
    let [casters, removed] = &mut world.casters;
    let found = [
        casters.insert(volumes, caster.clone()).err(),
        casters.insert(spare, DepthMapCaster { light: other.lamps[0].handle, ..caster.clone() }).err(),
        casters.set(own, DepthMapCaster { texture: small, ..caster.clone() }).err(),
        casters.set(own, DepthMapCaster { objects: Some(objects), ..caster.clone() }).err(),
        casters.set(own, DepthMapCaster { camera: singular, ..caster.clone() }).err(),
        casters.set_version(foreign, None).err(),
        casters.remove(foreign).err(),
        removed.set_version(stale, None).err(),
        removed.remove(stale).err(),
        removed.set(stale, caster.clone()).err(),
    ];
    let of_other = |what| Some(Error::OtherScene { what });
    let map = |error| Some(Error::Refused(error));
    let device = DeviceError::OtherDevice { what: "the volumes", with: "the scene" };
    let expected = [
        Some(device.into()),
        of_other("light"),
        map(DepthMapEncodeError::Size { texture: DepthMapTexture::Map, given: [4, 4], made: SIZE }),
        map(DepthMapEncodeError::UnusedObjects),
        map(DepthMapEncodeError::Light(CameraError::Singular)),
        of_other("caster"),
        of_other("caster"),
        Some(Error::Stale),
        Some(Error::Stale),
        Some(Error::Stale),
    ];
    same("changes", &found, &expected)?;
    cubes_refused(&mut world, own)?;
    encodes_and_draws_refused((&mut world, &mut other), (seen.eye, singular), own)
}

fn cubes_refused(world: &mut World<'_>, own: DepthMapCasterHandle) -> Result<(), String> {
    use DepthMapCastersError as Error;
    let gpu = world.gpu;
    let side = 4;
    let texture = |size: [u32; 2], format| {
        texture(gpu, size, format, &vec![0.0; (size[0] * size[1]) as usize]).map(|texture| depth_view(&texture))
    };
    let (map, small) = (texture([side; 2], TextureFormat::R32Float)?, texture([3; 2], TextureFormat::R32Float)?);
    let cameras =
        |side| DepthMapCube::cameras([0.0, 8.0, 0.0], 0.1, None, DepthDirection::Reversed, side).map_err(text);
    let (meeting, others) = (cameras(side)?, cameras(9)?);
    let cube = |objects| {
        let options = DepthMapOptions { objects, edges: DepthEdges::Outlines, ..Default::default() };
        DepthMapCube::new(&world.pipelines[0], side, &meeting, options).map_err(text)
    };
    let caster = DepthMapCubeCaster {
        light: world.lamps[0].handle,
        textures: [0; 6].map(|_| Some(map.clone())),
        objects: [const { None }; 6],
        cameras: meeting,
        version: Some(1),
    };
    let wrong = |view: &wgpu::TextureView| {
        let mut textures = caster.textures.clone();
        textures[4] = Some(view.clone());
        DepthMapCubeCaster { textures, ..caster.clone() }
    };
    let objects = [0; 6].map(|_| Some(map.clone()));
    let apart = DepthMapCubeCaster { cameras: others, ..caster.clone() };
    let [plain, of_objects, another] = [cube(false)?, cube(true)?, cube(false)?];
    let first = world.casts[0].caster.clone();
    let casters = &mut world.casters[0];
    let no_objects = casters.insert_cube(of_objects, caster.clone()).err();
    let refused = casters.insert_cube(another, apart.clone()).err();
    let there = casters.insert_cube(plain, caster.clone()).map_err(text)?;
    let meeting = cube_error(&world.pipelines[0], &apart.cameras, side)?;
    let found = [
        no_objects,
        refused,
        casters.set(there, first).err(),
        casters.set_cube(own, caster.clone()).err(),
        casters.set_cube(there, wrong(&small)).err(),
        casters.set_cube(there, DepthMapCubeCaster { objects, ..caster.clone() }).err(),
        casters.set_cube(there, apart).err(),
        casters.set_cube(there, caster).err(),
    ];
    let map = |error| Some(Error::Refused(error));
    let expected = [
        map(DepthMapEncodeError::NoObjects { face: Some(0) }),
        Some(Error::Cube(meeting.clone())),
        Some(Error::Kind { own: "six maps", with: "set_cube" }),
        Some(Error::Kind { own: "one map", with: "set" }),
        map(DepthMapEncodeError::Size { texture: DepthMapTexture::CubeMap(4), given: [3; 2], made: [side; 2] }),
        map(DepthMapEncodeError::UnusedObjects),
        Some(Error::Cube(meeting)),
        None,
    ];
    same("cubes", &found, &expected)?;
    match casters.remove(there).map_err(text)? {
        DepthMapCasterVolumes::Cube(_) => Ok(()),
        DepthMapCasterVolumes::Map(_) => Err("the volumes of one map".to_owned()),
    }
}

/// Why six cameras make no cube.
fn cube_error(
    pipelines: &DepthMapPipelines,
    cameras: &[ShadowCamera; 6],
    side: u32,
) -> Result<DepthMapCubeError, String> {
    let made = DepthMapCube::new(pipelines, side, cameras, DepthMapOptions::default());
    made.err().ok_or_else(|| "maps that do not meet were taken".to_owned())
}

fn encodes_and_draws_refused(
    (world, other): (&mut World<'_>, &mut World<'_>),
    (eye, singular): (ShadowCamera, ShadowCamera),
    own: DepthMapCasterHandle,
) -> Result<(), String> {
    use DepthMapCastersError as Error;
    let gpu = world.gpu;
    let [frame, foreign] = [&mut world.scene, &mut other.scene]
        .map(|scene| gpu.submit(|encoder| scene.encode(encoder, &[], None).map_err(text)));
    let (frame, foreign) = (frame?, foreign?);
    let [low, high] = [[0.0; 3], [1.0, -1.0, 1.0]];
    let standard = ShadowCamera { depth: DepthDirection::Standard, ..eye };
    let depth = Eye {
        place: DVec3::ZERO,
        forward: DVec3::X,
        near: 0.1,
        is_relative: false,
        depth: standard.depth,
        far: None,
        half_width: None,
    };
    let mut encode = |frame: &SceneFrame, camera: ShadowCamera, boxes: &[_]| {
        gpu.submit(|encoder| Ok(world.casters[0].encode_for(encoder, frame, &[camera], boxes, None)))
    };
    let found = [
        encode(&foreign, eye, &[])?.err(),
        encode(&frame, singular, &[])?.err(),
        encode(&frame, depth.camera(), &[])?.err(),
        encode(&frame, eye, &[None, None])?.err(),
        encode(&frame, eye, &[Some([low, high])])?.err(),
    ];
    let [camera, pipelines] = [DepthDirection::Standard, DepthDirection::Reversed];
    let error = DepthMapEncodeError::Depth { camera, pipelines };
    let expected = [
        Some(Error::OtherScene { what: "frame" }),
        Some(Error::Camera { view: 0, error: CameraError::Singular }),
        Some(Error::Map { caster: own, light: world.lamps[0].handle, view: 0, error }),
        Some(Error::TooManyBounds { given: 2, views: 1 }),
        Some(Error::Bounds { view: 0, low, high }),
    ];
    same("encodes", &found, &expected)?;
    // Two maps of one light, encoded twice without a version.
    let (caster, volumes) = (world.casts[0].caster.clone(), world.volumes()?);
    let second = world.casters[0].insert(volumes, DepthMapCaster { version: None, ..caster }).map_err(text)?;
    let late = world.scene.add_light(Light::point([1.0; 3])).map_err(text)?;
    let mut encode = || gpu.submit(|encoder| world.casters[0].encode(encoder, &frame, &[eye], None).map_err(text));
    let (before, now) = (encode()?, encode()?);
    let (light, [parity, counting]) = (world.lamps[0].handle, &world.pipelines);
    let mut found = Vec::new();
    stencil_after(gpu, (SIDE, &vec![0.5; (SIDE * SIDE) as usize]), |_| {
        Ok(|pass: &mut wgpu::RenderPass<'_>| {
            found.extend([
                now.draw(pass, parity, 0, light),
                now.draw(pass, counting, 1, light),
                now.draw(pass, counting, 0, other.lamps[0].handle),
                now.draw(pass, counting, 0, late),
                before.draw(pass, counting, 0, light),
                now.draw(pass, counting, 0, light),
                before.draw_caster(pass, parity, 0, own),
                before.draw_caster(pass, parity, 0, second),
                now.draw_caster(pass, parity, 0, second),
                now.draw_caster(pass, parity, 0, other.casts[0].handles[0]),
            ]);
            Ok(())
        })
    })?;
    let overwritten = || Err(DepthMapDrawError::StaleFrame.into());
    let expected = [
        Err(Error::OneParity { casters: 2 }),
        Err(Error::NoSuchView { view: 1, views: 1 }),
        Err(Error::OtherScene { what: "light" }),
        Err(Error::NotEncoded { what: "light" }),
        overwritten(),
        Ok(()),
        Ok(()),
        overwritten(),
        Ok(()),
        Err(Error::OtherScene { what: "caster" }),
    ];
    same("draws", &found, &expected)
}
