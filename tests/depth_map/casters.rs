//! Depth maps that cast in a scene: the same pictures as each map by hand, whatever is kept and skipped.

use glam::{DVec2, DVec3};
use rimline::gpu::{
    DepthMap, DepthMapCaster, DepthMapCasterCounts, DepthMapCasterHandle, DepthMapCasters, DepthMapCastersFrame,
    DepthMapCastersOptions, DepthMapCube, DepthMapCubeCaster, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
    LightHandle, Scene, SceneOptions, ShadowFormat,
};
use rimline::{Cone, DepthDirection, Light, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::random::Random;
use rimline_measure::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::{device_depth, light, map, seen, vector};
use crate::picture::stencil_after;
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] =
    &[("maps_in_a_scene_cast_as_each_by_hand", histories), ("cells_of_maps_are_kept_and_found_again", kept)];

pub(crate) const SIDE: u32 = 32;
pub(crate) const SIZE: [u32; 2] = [9, 7];
const CUBE_SIDE: u32 = 5;
const NOTHING: DepthMapCastersOptions =
    DepthMapCastersOptions { keep_cells: false, skip_unreached: false, skip_unseen: false, skip_hidden: false };

/// A map of a light, with what is in its texture.
pub(crate) struct Cast {
    texture: wgpu::Texture,
    pub(crate) caster: DepthMapCaster,
    /// Among all casters, and among those that keep and skip nothing.
    pub(crate) handles: [DepthMapCasterHandle; 2],
}

/// Six maps around a light, some of which may not be there, with what is in their textures.
struct CubeCast {
    textures: [Option<wgpu::Texture>; 6],
    caster: DepthMapCubeCaster,
    handles: [DepthMapCasterHandle; 2],
}

/// A light of the scene, and the camera of its maps.
pub(crate) struct Lamp {
    pub(crate) handle: LightHandle,
    light: Light,
    camera: ShadowCamera,
}

impl Lamp {
    /// The cameras of six maps around it, or about where the light would be if it were not at infinity.
    fn cube(&self) -> Result<[ShadowCamera; 6], String> {
        let place = DVec3::from_array(self.light.xyz.map(f64::from)) / f64::from(self.light.w.max(0.2));
        let place = place.as_vec3().to_array();
        DepthMapCube::cameras(place, 0.5, Some(40.0), DepthDirection::Reversed, CUBE_SIDE).map_err(text)
    }
}

/// What an eye sees at each pixel, and the depths there.
pub(crate) struct Seen {
    pub(crate) eye: ShadowCamera,
    places: Vec<DVec3>,
    depths: Vec<f32>,
    bounds: Option<[[f32; 3]; 2]>,
}

pub(crate) struct World<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) pipelines: [DepthMapPipelines; 2],
    pub(crate) scene: Scene,
    pub(crate) casters: [DepthMapCasters; 2],
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) casts: Vec<Cast>,
    cubes: Vec<CubeCast>,
    version: u64,
}

fn contents(random: &mut Random, camera: &ShadowCamera, size: [u32; 2]) -> Vec<f32> {
    let map = map(random, camera);
    let texel =
        |at: u32| map.depths[((at / size[0] % map.size[1]) * map.size[0] + at % size[0] % map.size[0]) as usize];
    Map::new(size, map.is_reversed, texel).depths
}

fn lamp_light(random: &mut Random) -> (Light, ShadowCamera) {
    let (camera, at) = light(random);
    let mut light = Light::homogeneous(at.as_vec4().to_array());
    if at.w > 0.0 {
        light.range = [f32::INFINITY, 0.3, 6.0, 12.0][random.below(4)];
        let axis = if random.below(2) == 0 { -at.truncate() } else { vector(random) };
        let cone = Cone::new(axis.as_vec3().to_array(), random.between(0.2, 1.4));
        light.cone = (random.below(2) == 0).then_some(cone);
    }
    (light, camera)
}

/// Whether a light adds anything at a place.
fn is_lit(light: &Light, place: DVec3) -> bool {
    if light.w == 0.0 {
        return true;
    }
    let from = place - DVec3::from_array(light.xyz.map(f64::from)) / f64::from(light.w);
    let in_cone = |cone: Cone| {
        let axis = DVec3::from_array(cone.axis.map(f64::from)).normalize();
        from.normalize().dot(axis) >= f64::from(cone.cosine)
    };
    from.length() <= f64::from(light.range) && light.cone.is_none_or(in_cone)
}

fn look(random: &mut Random) -> Seen {
    let place = f64::from(random.between(0.5, 9.0)) * vector(random);
    // To the middle, or past it.
    let to = if random.below(2) == 0 { vector(random) * 3.0 } else { place * 3.0 };
    let forward = to - place;
    let near = f64::from(random.between(0.05, 3.0));
    let (far, half_width) = [(None, None), (Some(60.0), None), (Some(60.0), Some(2.0))][random.below(3)];
    let depth = DepthDirection::Reversed;
    let eye = Eye { place, forward, near, is_relative: random.below(2) == 0, depth, far, half_width }.camera();
    let rays = Rays::new(&eye, SIDE);
    let seen = seen(random, &rays);
    let pixel = |at: u32| DVec2::new(f64::from(at % SIDE) + 0.5, f64::from(at / SIDE) + 0.5);
    let places: Vec<_> = (0..SIDE * SIDE).map(|at| seen(pixel(at)).1).collect();
    let depths = places.iter().map(|&place| device_depth(&eye, place)).collect();
    let low = (vector(random) * 9.0).as_vec3();
    let high = low + glam::Vec3::splat(random.between(0.5, 6.0));
    let bounds = (random.below(2) == 0).then(|| [low.to_array(), high.to_array()]);
    Seen { eye, places, depths, bounds }
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, depths: &[f32]) {
    let bytes_per_row = Some(4 * texture.width());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(depths), layout, texture.size());
}

impl<'a> World<'a> {
    fn new(gpu: &'a Gpu) -> Result<Self, String> {
        let format = ShadowFormat { count_bits: 7, ..Default::default() };
        let parity = DepthMapPipelines::new(&gpu.pipelines, &format, 7).map_err(text)?;
        let counting = DepthMapPipelines::counting(&gpu.pipelines, &format).map_err(text)?;
        let scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { count_bits: 7, ..Default::default() })
            .map_err(text)?;
        let casters = [DepthMapCastersOptions::default(), NOTHING].map(|options| DepthMapCasters::new(&scene, options));
        let pipelines = [parity, counting];
        Ok(Self { gpu, pipelines, scene, casters, lamps: Vec::new(), casts: Vec::new(), cubes: Vec::new(), version: 0 })
    }

    pub(crate) fn volumes(&self) -> Result<DepthMapVolumes, String> {
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        DepthMapVolumes::new(&self.pipelines[0], SIZE, options).map_err(text)
    }

    fn add_lamp(&mut self, random: &mut Random) -> Result<(), String> {
        let (light, camera) = lamp_light(random);
        let handle = self.scene.add_light(light).map_err(text)?;
        self.lamps.push(Lamp { handle, light, camera });
        Ok(())
    }

    fn add_cast(&mut self, random: &mut Random, lamp: usize) -> Result<(), String> {
        let Lamp { handle, camera, .. } = self.lamps[lamp];
        let texture = texture(self.gpu, SIZE, TextureFormat::R32Float, &contents(random, &camera, SIZE))?;
        let version = (random.below(4) > 0).then_some(self.version);
        let caster = DepthMapCaster { light: handle, texture: depth_view(&texture), objects: None, camera, version };
        let volumes = [self.volumes()?, self.volumes()?];
        let mut handles = Vec::new();
        for (casters, volumes) in self.casters.iter_mut().zip(volumes) {
            handles.push(casters.insert(volumes, caster.clone()).map_err(text)?);
        }
        self.casts.push(Cast { texture, caster, handles: [handles[0], handles[1]] });
        Ok(())
    }

    /// Other depths in the texture of a map.
    fn rewrite(&mut self, random: &mut Random, cast: usize, is_told: bool) -> Result<(), String> {
        let Cast { texture, caster, handles } = &mut self.casts[cast];
        write(self.gpu, texture, &contents(random, &caster.camera, SIZE));
        self.version += 1;
        if is_told && caster.version.is_some() {
            caster.version = Some(self.version);
            for (casters, handle) in self.casters.iter_mut().zip(handles) {
                casters.set_version(*handle, caster.version).map_err(text)?;
            }
        }
        Ok(())
    }

    fn cube(&self) -> Result<DepthMapCube, String> {
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        // Any that meet: a caster has its own.
        let cameras = DepthMapCube::cameras([0.0; 3], 1.0, None, DepthDirection::Reversed, CUBE_SIDE).map_err(text)?;
        DepthMapCube::new(&self.pipelines[0], CUBE_SIDE, &cameras, options).map_err(text)
    }

    fn add_cube(&mut self, random: &mut Random, lamp: usize) -> Result<(), String> {
        let (light, cameras) = (self.lamps[lamp].handle, self.lamps[lamp].cube()?);
        let mut textures = [const { None }; 6];
        for (own, camera) in textures.iter_mut().zip(&cameras) {
            if random.below(4) > 0 {
                let depths = contents(random, camera, [CUBE_SIDE; 2]);
                *own = Some(texture(self.gpu, [CUBE_SIDE; 2], TextureFormat::R32Float, &depths)?);
            }
        }
        let version = (random.below(4) > 0).then_some(self.version);
        let views = textures.each_ref().map(|texture| texture.as_ref().map(depth_view));
        let caster = DepthMapCubeCaster { light, textures: views, objects: [const { None }; 6], cameras, version };
        let cubes = [self.cube()?, self.cube()?];
        let mut handles = Vec::new();
        for (casters, cube) in self.casters.iter_mut().zip(cubes) {
            handles.push(casters.insert_cube(cube, caster.clone()).map_err(text)?);
        }
        self.cubes.push(CubeCast { textures, caster, handles: [handles[0], handles[1]] });
        Ok(())
    }

    /// Other depths in the textures of six maps.
    fn rewrite_cube(&mut self, random: &mut Random, cube: usize) -> Result<(), String> {
        let CubeCast { textures, caster, handles } = &mut self.cubes[cube];
        for (texture, camera) in textures.iter().zip(&caster.cameras) {
            if let Some(texture) = texture {
                write(self.gpu, texture, &contents(random, camera, [CUBE_SIDE; 2]));
            }
        }
        self.version += 1;
        caster.version = caster.version.map(|_| self.version);
        for (casters, handle) in self.casters.iter_mut().zip(handles) {
            casters.set_version(*handle, caster.version).map_err(text)?;
        }
        Ok(())
    }

    /// One change at random of six maps.
    fn change_cubes(&mut self, random: &mut Random) -> Result<(), String> {
        let [cube, lamp] = [random.below(self.cubes.len().max(1)), random.below(self.lamps.len())];
        match random.below(6) {
            0 | 1 if !self.cubes.is_empty() => self.rewrite_cube(random, cube)?,
            2 if !self.cubes.is_empty() => {
                let CubeCast { handles, .. } = self.cubes.swap_remove(cube);
                for (casters, handle) in self.casters.iter_mut().zip(handles) {
                    casters.remove(handle).map_err(text)?;
                }
            }
            3 if self.cubes.len() < 3 => self.add_cube(random, lamp)?,
            4 if !self.cubes.is_empty() => {
                // A map comes or goes, and the version stays.
                let own = &mut self.cubes[cube];
                let face = random.below(6);
                let (camera, size) = (own.caster.cameras[face], [CUBE_SIDE; 2]);
                own.textures[face] = if own.textures[face].is_some() {
                    None
                } else {
                    Some(texture(self.gpu, size, TextureFormat::R32Float, &contents(random, &camera, size))?)
                };
                own.caster.textures[face] = own.textures[face].as_ref().map(depth_view);
                for (casters, handle) in self.casters.iter_mut().zip(own.handles) {
                    casters.set_cube(handle, own.caster.clone()).map_err(text)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// One change at random.
    fn change(&mut self, random: &mut Random) -> Result<(), String> {
        let [cast, lamp] = [random.below(self.casts.len().max(1)), random.below(self.lamps.len())];
        match random.below(8) {
            0..3 if !self.casts.is_empty() => self.rewrite(random, cast, true)?,
            3 => {
                // A lamp moves, and its maps with it.
                let (light, camera) = lamp_light(random);
                let own = &mut self.lamps[lamp];
                (own.light, own.camera) = (light, camera);
                self.scene.set_light(own.handle, light).map_err(text)?;
                let handle = own.handle;
                for cast in 0..self.casts.len() {
                    if self.casts[cast].caster.light == handle {
                        self.casts[cast].caster.camera = camera;
                        let Cast { caster, handles, .. } = &self.casts[cast];
                        for (casters, handle) in self.casters.iter_mut().zip(handles) {
                            casters.set(*handle, caster.clone()).map_err(text)?;
                        }
                        self.rewrite(random, cast, true)?;
                    }
                }
                let cameras = self.lamps[lamp].cube()?;
                for cube in self.cubes.iter_mut().filter(|cube| cube.caster.light == handle) {
                    cube.caster.cameras = cameras;
                    for (casters, handle) in self.casters.iter_mut().zip(cube.handles) {
                        casters.set_cube(handle, cube.caster.clone()).map_err(text)?;
                    }
                }
            }
            4 if !self.casts.is_empty() => {
                let Cast { handles, .. } = self.casts.swap_remove(cast);
                for (casters, handle) in self.casters.iter_mut().zip(handles) {
                    casters.remove(handle).map_err(text)?;
                }
            }
            5 => self.add_cast(random, lamp)?,
            6 if self.lamps.len() > 2 => {
                let Lamp { handle, .. } = self.lamps.swap_remove(lamp);
                self.scene.remove_light(handle).map_err(text)?;
                self.add_lamp(random)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn encode(&mut self, seen: &[Seen]) -> Result<[DepthMapCastersFrame; 2], String> {
        let cameras: Vec<_> = seen.iter().map(|seen| seen.eye).collect();
        let boxes: Vec<_> = seen.iter().map(|seen| seen.bounds).collect();
        let Self { gpu, scene, casters: [all, nothing], .. } = self;
        gpu.submit(|encoder| {
            let frame = scene.encode(encoder, &cameras, None).map_err(text)?;
            let mut encode = |casters: &mut DepthMapCasters| {
                casters.encode_for(encoder, &frame, &cameras, &boxes, None).map_err(text)
            };
            Ok([encode(all)?, encode(nothing)?])
        })
    }

    /// How many cubes, and single maps, a light has.
    fn casters_of(&self, lamp: &Lamp) -> [usize; 2] {
        let cubes = self.cubes.iter().filter(|cube| cube.caster.light == lamp.handle).count();
        [cubes, self.casts.iter().filter(|cast| cast.caster.light == lamp.handle).count()]
    }

    /// The pictures of a light: kept and skipped, neither, and each map by hand.
    fn pictures(
        &self,
        frames: &[DepthMapCastersFrame; 2],
        (view, seen): (usize, &Seen),
        lamp: &Lamp,
    ) -> Result<[Vec<u8>; 3], String> {
        let own: Vec<_> = self.casts.iter().filter(|cast| cast.caster.light == lamp.handle).collect();
        let cubes: Vec<_> = self.cubes.iter().filter(|cube| cube.caster.light == lamp.handle).collect();
        let pipelines = &self.pipelines[usize::from(own.len() + cubes.len() > 1)];
        let target = (SIDE, &seen.depths[..]);
        let drawn = |frame: &DepthMapCastersFrame| {
            stencil_after(self.gpu, target, |_| {
                Ok(|pass: &mut wgpu::RenderPass<'_>| frame.draw(pass, pipelines, view, lamp.handle).map_err(text))
            })
        };
        let by_hand = stencil_after(self.gpu, target, |encoder| {
            let mut frames = Vec::new();
            for Cast { caster, .. } in &own {
                let map = DepthMap { texture: &caster.texture, light: caster.camera };
                frames.push(self.volumes()?.encode(encoder, &map, &seen.eye, None).map_err(text)?);
            }
            for CubeCast { caster, .. } in &cubes {
                let mut cube = self.cube()?;
                cube.set_cameras(&caster.cameras).map_err(text)?;
                let maps = caster.textures.each_ref().map(Option::as_ref);
                frames.push(cube.encode(encoder, maps, &seen.eye, None).map_err(text)?);
            }
            Ok(move |pass: &mut wgpu::RenderPass<'_>| {
                frames.iter().try_for_each(|frame| frame.draw(pass, pipelines).map_err(text))
            })
        })?;
        Ok([drawn(&frames[0])?, drawn(&frames[1])?, by_hand])
    }
}

/// Compares pictures where the light adds something and, with a box, in the box.
fn compare(what: &str, found: &[u8], expected: &[u8], seen: &Seen, light: &Light) -> Result<usize, String> {
    let is_in = |place: DVec3| {
        let place = place.to_array();
        let inside = |[low, high]: [[f32; 3]; 2]| {
            (0..3).all(|axis| (f64::from(low[axis])..=f64::from(high[axis])).contains(&place[axis]))
        };
        is_lit(light, DVec3::from_array(place)) && seen.bounds.is_none_or(inside)
    };
    let counted = |picture: &[u8]| -> Vec<u8> {
        picture.iter().zip(&seen.places).filter(|(_, place)| is_in(**place)).map(|(value, _)| *value).collect()
    };
    let expected = counted(expected);
    same(what, &counted(found), &expected)?;
    Ok(expected.iter().filter(|&&value| value != 0).count())
}

/// Maps change, versions rise, lights move, casters and lights come and go, encoders are dropped.
fn histories() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut dark, mut of_cubes, mut noticed) = (0, 0, 0);
    let mut counts = DepthMapCasterCounts::default();
    for seed in 0..if is_long() { 40 } else { 8 } {
        println!("seed {}", 1680 + seed);
        let mut random = Random::new(1680 + seed);
        let mut world = World::new(gpu)?;
        for lamp in 0..3 {
            world.add_lamp(&mut random)?;
            world.add_cast(&mut random, lamp)?;
        }
        world.add_cube(&mut random, 1)?;
        let mut eyes = [look(&mut random), look(&mut random)];
        for step in 0..12 {
            world.change(&mut random)?;
            world.change_cubes(&mut random)?;
            if random.below(2) == 0 {
                eyes = [look(&mut random), look(&mut random)];
            }
            if random.below(4) == 0 {
                // Recorded, but never submitted.
                let mut dropped = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let frame = world.scene.encode(&mut dropped, &[], None).map_err(text)?;
                let cameras = [eyes[0].eye];
                world.casters[0].encode(&mut dropped, &frame, &cameras, None).map_err(text)?;
            }
            // Nobody is told of a change.
            let cast = random.below(world.casts.len().max(1));
            let is_secret = step % 4 == 3 && !world.casts.is_empty();
            if is_secret {
                world.encode(&eyes)?;
                world.rewrite(&mut random, cast, false)?;
            }
            let frames = world.encode(&eyes)?;
            let [all, nothing] = frames.each_ref().map(DepthMapCastersFrame::counts);
            if nothing.skipped != nothing.unlit || nothing.kept > 0 {
                return Err(format!("switched off, and {nothing:?}"));
            }
            counts.encoded += all.encoded;
            counts.kept += all.kept;
            counts.skipped += all.skipped;
            counts.unlit += all.unlit;
            counts.unreached += all.unreached;
            counts.draws += all.draws;
            counts.near_caps_lit += all.near_caps_lit;
            counts.near_caps_told += all.near_caps_told;
            for (view, seen) in eyes.iter().enumerate() {
                for lamp in &world.lamps {
                    let [kept, anew, by_hand] = world.pictures(&frames, (view, seen), lamp)?;
                    let what = format!("seed {}, step {step}, view {view}", 1680 + seed);
                    let found = compare(&format!("{what}, switched off"), &anew, &by_hand, seen, &lamp.light)?;
                    let [cubes, maps] = world.casters_of(lamp);
                    dark += found;
                    of_cubes += if cubes > 0 && maps == 0 { found } else { 0 };
                    let outcome = compare(&what, &kept, &by_hand, seen, &lamp.light);
                    if is_secret {
                        noticed += usize::from(outcome.is_err());
                    } else {
                        outcome?;
                    }
                }
            }
            if is_secret {
                world.rewrite(&mut random, cast, true)?;
            }
        }
    }
    println!(
        "{dark} dark pixels, {of_cubes} of them of cubes alone, {noticed} pictures with cells of other maps, {counts:?}"
    );
    let unseen = counts.skipped - counts.unlit - counts.unreached;
    let least = [counts.encoded, counts.kept, unseen, counts.unlit, counts.unreached].into_iter().min();
    // Few eyes are beside a map. Each draw has one cap.
    let DepthMapCasterCounts { near_caps_lit, near_caps_told, draws, .. } = counts;
    let has_caps = near_caps_lit > 0 && near_caps_told > 50 && near_caps_lit + near_caps_told <= draws;
    if dark < 2000 || of_cubes < 500 || least < Some(5) || !has_caps {
        return Err("too few of a kind".to_owned());
    }
    // Negative control: a map that changed, and a version that did not.
    if noticed < 2 { Err("cells of other maps went unnoticed".to_owned()) } else { Ok(()) }
}

/// A lamp above the middle whose map has a square in it, and eyes to it, away from it, and with boxes.
pub(crate) fn lone(gpu: &Gpu) -> Result<(World<'_>, Seen, Seen), String> {
    let mut world = World::new(gpu)?;
    let (depth, far) = (DepthDirection::Reversed, None);
    let eye = |place: DVec3, forward: DVec3| {
        Eye { place, forward, near: 0.1, is_relative: false, depth, far, half_width: None }.camera()
    };
    let camera = eye(DVec3::new(0.0, 8.0, 0.0), DVec3::NEG_Y);
    let place = |texel: u32| if texel % 9 > 2 && texel % 9 < 6 { 0.1 / 4.0 } else { 0.0 };
    let texture = texture(gpu, SIZE, TextureFormat::R32Float, &Map::new(SIZE, true, place).depths)?;
    let light = Light::point([0.0, 8.0, 0.0]).with_range(20.0);
    let handle = world.scene.add_light(light).map_err(text)?;
    let (view, version) = (depth_view(&texture), Some(1));
    let caster = DepthMapCaster { light: handle, texture: view, objects: None, camera, version };
    let volumes = [world.volumes()?, world.volumes()?];
    let mut handles = Vec::new();
    for (casters, volumes) in world.casters.iter_mut().zip(volumes) {
        handles.push(casters.insert(volumes, caster.clone()).map_err(text)?);
    }
    world.version = 1;
    world.lamps.push(Lamp { handle, light, camera });
    world.casts.push(Cast { texture, caster, handles: [handles[0], handles[1]] });
    let floor = |eye: ShadowCamera| {
        let rays = Rays::new(&eye, SIDE);
        let at = |pixel: u32| {
            let (from, direction) = rays.ray(pixel % SIDE, pixel / SIDE);
            from + direction * if direction.y < 0.0 { -from.y / direction.y } else { 50.0 }
        };
        let places: Vec<_> = (0..SIDE * SIDE).map(at).collect();
        let depths = places.iter().map(|&place| device_depth(&eye, place)).collect();
        Seen { eye, places, depths, bounds: None }
    };
    let towards = floor(eye(DVec3::new(6.0, 3.0, 0.0), DVec3::new(-2.0, -1.0, 0.0)));
    let away = floor(eye(DVec3::new(9.0, 3.0, 0.0), DVec3::new(2.0, 0.3, 0.0)));
    Ok((world, towards, away))
}

fn kept() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut world, towards, away) = lone(gpu)?;
    let encode = |world: &mut World<'_>, seen: &[Seen]| world.encode(seen).map(|[all, _]| all.counts());
    let one = DepthMapCasterCounts::default();
    // The eye's near rectangle is beside the map.
    let drawn = DepthMapCasterCounts { draws: 1, near_caps_lit: 1, ..one };
    let (found, again) = (DepthMapCasterCounts { encoded: 1, ..drawn }, DepthMapCasterCounts { kept: 1, ..drawn });
    let skipped = DepthMapCasterCounts { skipped: 1, ..one };
    let seen = [towards];
    let mut steps = vec![encode(&mut world, &seen)?, encode(&mut world, &seen)?];
    // Out of sight and back.
    let (away, mut random) = ([away], Random::new(1690));
    steps.extend([encode(&mut world, &away)?, encode(&mut world, &seen)?]);
    world.rewrite(&mut random, 0, true)?;
    steps.extend([encode(&mut world, &away)?, encode(&mut world, &seen)?, encode(&mut world, &seen)?]);
    same("steps", &steps, &[found, again, skipped, again, skipped, found, again])?;
    // The commands that find the cells are dropped.
    world.rewrite(&mut random, 0, true)?;
    let mut dropped = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let frame = world.scene.encode(&mut dropped, &[], None).map_err(text)?;
    let lost = world.casters[0].encode(&mut dropped, &frame, &[seen[0].eye], None).map_err(text)?.counts();
    drop(dropped);
    let steps = [lost, encode(&mut world, &seen)?, encode(&mut world, &seen)?];
    same("dropped", &steps, &[found, found, again])?;
    let handle = world.casts[0].handles[0];
    world.casters[0].set_version(handle, None).map_err(text)?;
    let steps = [encode(&mut world, &seen)?, encode(&mut world, &seen)?];
    same("any", &steps, &[found, found])?;
    // Another camera, another texture, or a light that moves, and the same version.
    let mut caster = DepthMapCaster { version: Some(9), ..world.casts[0].caster.clone() };
    let mut steps = Vec::new();
    for change in 0..4 {
        match change {
            1 => caster.camera.origin[0] += 0.125,
            2 => caster.texture = depth_view(&world.casts[0].texture),
            _ => {}
        }
        let (handle, light) = (world.lamps[0].handle, world.lamps[0].light.with_range(20.0 + change as f32));
        world.scene.set_light(handle, light).map_err(text)?;
        world.casters[0].set(world.casts[0].handles[0], caster.clone()).map_err(text)?;
        steps.push(encode(&mut world, &seen)?);
    }
    same("set", &steps, &[found, found, found, again])?;
    world.casters[0].set(handle, world.casts[0].caster.clone()).map_err(text)?;
    world.casters[0].set_version(handle, None).map_err(text)?;
    // A box beside the shadow, one in it, and one in it that the light does not reach.
    let deep = [[-1.0, -40.0, -1.0], [1.0, -30.0, 1.0]];
    let boxes = [[[7.0, 0.0, 7.0], [9.0, 1.0, 9.0]], [[0.0; 3], [1.0; 3]], deep];
    let [mut beside, mut within, deep] = boxes.map(|bounds| {
        let Seen { eye, places, depths, .. } = &seen[0];
        [Seen { eye: *eye, places: places.clone(), depths: depths.clone(), bounds: Some(bounds) }]
    });
    let steps = [encode(&mut world, &beside)?, encode(&mut world, &within)?, encode(&mut world, &deep)?];
    same("boxes", &steps, &[skipped, found, skipped])?;
    // Negative control: shadows outside of the box are missed.
    let (light, lamp) = (world.lamps[0].light, 0);
    for (of, is_skipped) in [(&mut beside, true), (&mut within, false)] {
        let frames = world.encode(of)?;
        let [found, _, by_hand] = world.pictures(&frames, (0, &of[0]), &world.lamps[lamp])?;
        compare("in the box", &found, &by_hand, &of[0], &light)?;
        of[0].bounds = None;
        let outcome = compare("everywhere", &found, &by_hand, &of[0], &light);
        if is_skipped { must_fail("a box that is too small", &outcome)? } else { outcome.map(drop)? }
    }
    // The light ends before the map begins, and is removed.
    let handle = world.lamps[0].handle;
    world.scene.set_light(handle, light.with_range(0.09)).map_err(text)?;
    let unreached = encode(&mut world, &seen)?;
    world.scene.remove_light(handle).map_err(text)?;
    let unlit = encode(&mut world, &seen)?;
    let [of_range, of_light] =
        [[1, 0], [0, 1]].map(|[unreached, unlit]| DepthMapCasterCounts { unreached, unlit, ..skipped });
    same("without light", &[unreached, unlit], &[of_range, of_light])
}
