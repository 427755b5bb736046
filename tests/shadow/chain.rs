//! All that `ShadowVolumes` records, from extraction to draws, against the twins in a row.

use rimline::gpu::{
    Extractor, ExtractorOptions, ListOptions, PositionBuffer, ShadowFormat, ShadowOptions, ShadowPipelines,
    ShadowVolumes,
};
use rimline::mesh::NO_FACE;
use rimline::reference::cpu::{self, Threads};
use rimline::reference::layout::{DrawArguments, EdgeMasks, ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics};
use rimline::reference::shadow::{
    self, CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005,
};
use rimline::{Counting, Light, Mesh, Predicate};

use crate::sides;
use crate::stages::{PLACES, drawn, placed, shape, unreached};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{chosen, interleaved};
use rimline_testkit::random::Random;
use rimline_testkit::same;
use rimline_testkit::scenes::{Scene, scene};

pub(crate) const TESTS: &[Test] =
    &[("shadow_volumes_choose_as_the_twins_in_a_row", chain), ("shadow_volumes_used_again_are_as_good_as_new", again)];

/// Every method, and its code.
const METHODS: [(Counting, u32); 5] = [
    (Counting::Auto, COUNT_AUTO),
    (Counting::ZpPlus, COUNT_ZP_PLUS),
    (Counting::ZpPlus2005, COUNT_ZP_PLUS_2005),
    (Counting::ZFail, COUNT_Z_FAIL),
    (Counting::ZPass, COUNT_Z_PASS),
];

const LIGHTS: usize = 40;

fn text<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

/// Distances come from a division and a square root, which WGSL lets be off by some units of the last place. No decision
/// depends on these bits. Differences up to eight units are accepted.
fn rounded_alike(found: Vec<ShadowLight>, twins: &[ShadowLight]) -> Vec<ShadowLight> {
    let near = |found: f32, twin: f32| {
        if (found - twin).abs() <= 8.0 * f32::EPSILON * twin.abs() { twin } else { found }
    };
    let pair = |(found, twin): (ShadowLight, &ShadowLight)| ShadowLight {
        frustum_near: near(found.frustum_near, twin.frustum_near),
        end: near(found.end, twin.end),
        ..found
    };
    found.into_iter().zip(twins).map(pair).collect()
}

/// Results of the twins for a scene.
struct Twins {
    lights: Vec<ShadowLight>,
    /// Draws of each light.
    draws: Vec<ShadowDraws>,
    statistics: ShadowStatistics,
    /// Lights that ZP+ as published left to z-fail.
    switched: usize,
    /// Lights with sides that excluded faces make.
    by_exclusion: usize,
}

/// The silhouettes of a caster, light by light.
struct Silhouettes<'a> {
    mesh: &'a Mesh,
    positions: &'a [[f32; 3]],
    masks: Vec<EdgeMasks>,
    /// Room in the GPU's lists.
    capacity: u32,
}

impl Silhouettes<'_> {
    fn list(&self, light: usize) -> cpu::CompactedList {
        let edges = self.mesh.edges().len();
        cpu::compact(&self.masks[light / 32 * edges..][..edges], light as u32 % 32, usize::MAX)
    }

    /// Edges as stages see them that read a list: all of them where it overflowed.
    fn listed(&self, light: usize) -> Vec<u32> {
        let list = self.list(light);
        if list.count > self.capacity {
            return (0..self.mesh.edges().len() as u32).collect();
        }
        list.entries.iter().map(|entry| entry & !cpu::WINDING).collect()
    }

    fn ends(&self, edge: u32) -> [[f32; 3]; 2] {
        self.mesh.edges().vertices()[edge as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// No stencil count of the light is above this.
    fn bound(&self, light: &ShadowLight, lists: &[Vec<u32>; 2], shape: &ShadowShape) -> u32 {
        let corners = |face: &[u32; 3]| face.map(|vertex| self.positions[vertex as usize]);
        let finite = self.mesh.faces().iter().map(corners).filter(|face| face.iter().all(|&p| cpu::is_finite(p)));
        let empty = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        let corners = finite.flatten().fold(empty, |[low, high], p| {
            let axis = |choose: fn(f32, f32) -> f32, so_far: [f32; 3]| {
                std::array::from_fn(|axis| choose(so_far[axis], p[axis]))
            };
            [axis(f32::min, low), axis(f32::max, high)]
        });
        let entries = lists.concat();
        // Lists that overflowed do not say which edges have sides.
        let sides: Vec<_> = if entries.len() > shape.side_capacity as usize {
            let weight = if light.casting == CAST_EVERY { 2 } else { 1 };
            (0..self.mesh.edges().len() as u32).map(|edge| (self.ends(edge), weight)).collect()
        } else {
            entries.iter().map(|entry| (self.ends(entry & !cpu::WINDING), 1)).collect()
        };
        if light.casting == CAST_NOTHING {
            return 0;
        }
        let [low, high] = corners;
        let own = cpu::CastingBox { low, high, faces: self.mesh.faces().len() as u32 };
        cpu::bound_casters(light.light, vec![(own, sides)])
    }
}

/// The draws with so many instances of each list: quadrilaterals, pentagons where they are clipped, and triangles. The published
/// ZP+ clips nothing. Light caps, which proxies alone have, are drawn from the lists of far caps.
fn draws(shape: &ShadowShape, instances: [u32; 6]) -> ShadowDraws {
    let draw = |vertices: u32, instances: u32| DrawArguments {
        vertex_count: if instances == 0 { 0 } else { vertices },
        instance_count: instances,
        first_vertex: 0,
        first_instance: 0,
    };
    let [clipped, near] = if shape.counting == COUNT_ZP_PLUS_2005 { [4, 3] } else { [5, 5] };
    let light = |far: u32| draw(4, if shape.proxies == 0 { 0 } else { far });
    ShadowDraws {
        plain: draw(4, instances[0]),
        clipped: draw(clipped, instances[1]),
        near_front: draw(near, instances[2]),
        near_back: draw(near, instances[3]),
        far_front: draw(3, instances[4]),
        far_back: draw(3, instances[5]),
        light_front: light(instances[4]),
        light_back: light(instances[5]),
    }
}

fn twins(scene: &Scene, shape: &ShadowShape, bounds_counts: bool) -> Result<Twins, String> {
    let (_, positions, mesh) = &scene.caster;
    let plain = &scene.lights;
    let facing = cpu::facing(positions, mesh.faces(), plain, Predicate::Exact, Threads::ONE);
    let masks = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), LIGHTS, Threads::ONE);
    let silhouettes = Silhouettes { mesh, positions, masks, capacity: shape.capacity };
    let view = shadow::view(&scene.camera).map_err(text)?;
    let mut lights: Vec<_> = scene.lights.iter().map(|&light| shadow::light(&scene.camera, &view, light)).collect();
    let excluded = cpu::excluded(positions, mesh.faces(), plain);
    let has_excluded = excluded.iter().any(|&mask| mask != 0);
    let bounds = cpu::bounds(positions, mesh.faces());
    let unreached = unreached(shape, &view, bounds, &lights);
    cpu::choose(shape, &view, bounds, has_excluded, &mut lights);
    let mut switched = 0;
    for (number, light) in lights.iter_mut().enumerate() {
        let is_published = light.casting != CAST_NOTHING && light.counting == COUNT_ZP_PLUS_2005;
        let ends = || silhouettes.listed(number).into_iter().map(|edge| silhouettes.ends(edge));
        if is_published && cpu::zp_plus_2005_cases(&view, light, ends()) {
            light.counting = COUNT_Z_FAIL;
            switched += 1;
        }
    }
    let caps = cpu::caps(&view, positions, mesh.faces(), &facing, &excluded, &lights, shape.proxies == 0);
    let capped: Vec<bool> = caps.iter().map(|lists| !lists[0].is_empty() || !lists[1].is_empty()).collect();
    let caps: Vec<_> = caps.iter().map(|lists| [0, 1, 2, 3].map(|list| lists[list].len() as u32)).collect();
    let packed = mesh.edges().packed_faces();
    let lists: Vec<_> = (0..)
        .zip(&lights)
        .zip(&capped)
        .map(|(light, &capped)| sides::lists(mesh, light, [&facing, &excluded], capped))
        .collect();
    // An edge between an excluded face and another, which is a side of weight 1 though no boundary.
    let by_exclusion = lists.iter().zip(&lights).filter(|(lists, light)| {
        let entries: Vec<u32> = lists.concat();
        let is_single = |entry: &&u32| entries.iter().filter(|other| other == entry).count() == 1;
        let is_inner = |entry: &u32| packed[(entry & !cpu::WINDING) as usize][1] != NO_FACE;
        light.casting == CAST_EVERY && entries.iter().filter(is_single).any(is_inner)
    });
    let by_exclusion = by_exclusion.count();
    let sides: Vec<_> = lists.iter().map(|lists| [0, 1].map(|list| lists[list].len() as u32)).collect();
    let draws = sides.iter().zip(&caps).map(|(&sides, &caps)| draws(shape, drawn(shape, sides, caps))).collect();
    let count = |is: &dyn Fn([u32; 2], [u32; 4]) -> bool| {
        sides.iter().zip(&caps).filter(|&(&sides, &caps)| is(sides, caps)).count() as u32
    };
    let mut statistics = ShadowStatistics {
        capped: count(&|_, [near_front, near_back, ..]| near_front + near_back > 0),
        overflowed_sides: count(&|[plain, clipped], _| plain + clipped > shape.side_capacity),
        overflowed_caps: count(&|_, [near_front, near_back, far_front, far_back]| {
            near_front + near_back > shape.near_capacity || far_front + far_back > shape.far_capacity
        }),
        ..bytemuck::Zeroable::zeroed()
    };
    statistics.skipped = lights.iter().filter(|light| light.casting == CAST_NOTHING).count() as u32;
    statistics.unreached = unreached;
    statistics.every_face = lights.iter().filter(|light| light.casting == CAST_EVERY).count() as u32;
    statistics.ended = lights.iter().filter(|light| light.end > 0.0).count() as u32;
    if bounds_counts {
        let bounds: Vec<u32> =
            lights.iter().zip(&lists).map(|(light, lists)| silhouettes.bound(light, lists, shape)).collect();
        statistics.count_bound = bounds.iter().copied().max().unwrap_or(0);
        statistics.may_wrap = bounds.iter().filter(|&&bound| bound > 255).count() as u32;
    }
    Ok(Twins { lights, draws, statistics, switched, by_exclusion })
}

/// In each counting method, with lists that fit or overflow.
fn chain() -> Result<(), String> {
    // z-fail needs depth to be unclipped where the camera has a far plane.
    let gpu = &*Gpu::shared_with_depth_features()?;
    let seed = 104;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut overflowed, mut doubled, mut switched, mut ended, mut bounded, mut excluded, mut overflowed_sides) =
        (0, 0, 0, 0, 0, 0, 0);
    for (counting, code) in METHODS {
        for number in 0..6 {
            let mut scene = scene(&mut random, number, LIGHTS);
            // Lights on vertices of the caster, so in planes of its faces.
            for light in &mut scene.lights[..4] {
                *light = Light::point(scene.caster.1[random.below(scene.caster.1.len())]);
            }
            let (name, (_, positions, mesh)) = (&scene.name, &scene.caster);
            let (depth, has_far_plane) = (scene.camera.depth, scene.camera.has_far_plane());
            let format = ShadowFormat { depth, has_far_plane, ..ShadowFormat::default() };
            let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, counting).map_err(text)?;
            let capacity = [None, Some(30)][number % 2];
            let lists = ListOptions { capacity, ordered: false, vertices_per_edge: 4 };
            // Ten more than are used.
            let options = ExtractorOptions { max_lights: LIGHTS + 10, lists: Some(lists), ..Default::default() };
            let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
            let options = ShadowOptions {
                every_face: number == 3,
                in_depth: !matches!(number, 1 | 5),
                cap_capacity: [None, Some(9)][number / 2 % 2],
                skip_unseen: number != 4,
                end_at_range: number % 3 == 2,
                bound_counts: number % 2 == 1 || number == 0,
                memory_limit: None,
            };
            let mut volumes = ShadowVolumes::new(&pipelines, &extractor, options).map_err(text)?;
            let place = PLACES[number % 3];
            let buffer = placed(gpu, positions, place);
            let bound =
                PositionBuffer { buffer: &buffer, offset: 4 * u64::from(place.0), stride: 4 * u64::from(place.1) };
            gpu.submit(|encoder| {
                let extraction = extractor.encode(encoder, bound, &scene.lights, None).map_err(text)?;
                volumes.encode(encoder, &extraction, &scene.camera, None).map_err(text)
            })?;
            let shape = shape(mesh, LIGHTS);
            let lists_all = options.end_at_range || matches!(counting, Counting::ZFail | Counting::ZpPlus2005);
            let some = 1024 + 16 * mesh.faces().len().isqrt() as u32;
            let near = match counting {
                Counting::ZPass | Counting::ZFail => 1,
                Counting::ZpPlus2005 => shape.faces,
                _ => some.min(shape.faces),
            };
            let lists_all = lists_all || !options.in_depth;
            let far = if lists_all { shape.faces } else { 1 };
            let asked = |default: u32| if default == 1 { 1 } else { options.cap_capacity.unwrap_or(default) };
            let shape = ShadowShape {
                averted: if options.every_face { 0 } else { shape.averted },
                proxies: u32::from(!options.in_depth),
                near_capacity: asked(near),
                far_capacity: asked(far),
                counting: code,
                skip_unseen: u32::from(options.skip_unseen),
                end_at_range: u32::from(options.end_at_range),
                capacity: extractor.results().capacity,
                side_capacity: extractor.results().capacity,
                ..shape
            };
            let twins = twins(&scene, &shape, options.bound_counts)?;
            let what = format!("{counting:?}, {name}");
            let found = rounded_alike(chosen(gpu, &volumes, LIGHTS)?, &twins.lights);
            same(&format!("{what}, lights"), &found, &twins.lights)?;
            let found: Vec<ShadowDraws> = gpu.read(&volumes.draw_arguments()[0], LIGHTS + 10)?;
            same(&format!("{what}, draws"), &found[..LIGHTS], &twins.draws)?;
            same(&format!("{what}, lights not in use"), &found[LIGHTS..], &[bytemuck::Zeroable::zeroed(); 10])?;
            let found: Vec<ShadowStatistics> = gpu.read(volumes.statistics(), 1)?;
            same(&format!("{what}, statistics"), &found, &[twins.statistics])?;
            overflowed += twins.statistics.overflowed_caps;
            ended += twins.statistics.ended;
            bounded += u32::from(twins.statistics.count_bound > 0);
            switched += twins.switched;
            excluded += twins.by_exclusion;
            overflowed_sides += twins.statistics.overflowed_sides;
            doubled += twins.lights.iter().filter(|light| light.casting == CAST_EVERY).count();
        }
    }
    println!(
        "{overflowed} lights with lists that overflow, {doubled} with every face, {switched} switched, {ended} ended, \
         {bounded} scenes with a bound, {excluded} lights with sides of excluded faces, {overflowed_sides} with lists of sides that overflow"
    );
    if overflowed.min(ended).min(bounded).min(overflowed_sides) == 0 || doubled.min(switched).min(excluded) == 0 {
        return Err("too few of a kind".to_owned());
    }
    Ok(())
}

/// Results that a frame prepared: lights, draws and statistics.
type Prepared = (Vec<ShadowLight>, Vec<ShadowDraws>, ShadowStatistics);

/// One extractor and its volumes for frames of other positions, lights and cameras, all in one buffer, against new ones for
/// each frame: nothing of an earlier frame is left.
fn again() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 107;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut caps, mut controls) = (0, 0);
    for counting in [Counting::Auto, Counting::ZFail] {
        for number in 0..4 {
            let base = scene(&mut random, number, LIGHTS);
            let (_, positions, mesh) = &base.caster;
            let pipelines = ShadowPipelines::new(&gpu.pipelines, &format_of(&base), counting).map_err(text)?;
            let options = ExtractorOptions { max_lights: LIGHTS, ..Default::default() };
            let make = || -> Result<_, String> {
                let extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
                let volumes = ShadowVolumes::new(&pipelines, &extractor, ShadowOptions::default()).map_err(text)?;
                Ok((extractor, volumes))
            };
            // The same body elsewhere, far behind it in the buffer.
            let moved: Vec<[f32; 3]> = positions.iter().map(|&[x, y, z]| [z + 3.0, x - 2.0, y]).collect();
            let mut words = interleaved(positions, 0, 12);
            let second = (4 * words.len() as u64).next_multiple_of(256) + 1024 + 4;
            words.extend_from_slice(&interleaved(&moved, second, 20)[words.len()..]);
            let buffer = gpu.storage(&words);
            let places = [(0, 12), (second, 20)];
            let prepare = |(extractor, volumes): &mut (Extractor, ShadowVolumes),
                           (offset, stride): (u64, u64),
                           lights: &[Light]|
             -> Result<Prepared, String> {
                let bound = PositionBuffer { buffer: &buffer, offset, stride };
                gpu.submit(|encoder| {
                    let extraction = extractor.encode(encoder, bound, lights, None).map_err(text)?;
                    volumes.encode(encoder, &extraction, &base.camera, None).map_err(text)
                })?;
                let statistics: Vec<ShadowStatistics> = gpu.read(volumes.statistics(), 1)?;
                // Lights of an earlier frame are never drawn; what was chosen for them stays.
                Ok((
                    chosen(gpu, volumes, lights.len())?,
                    gpu.read(&volumes.draw_arguments()[0], LIGHTS)?,
                    statistics[0],
                ))
            };
            let mut used = make()?;
            let mut last: Option<Prepared> = None;
            for (frame, (place, count)) in
                [(0, LIGHTS), (0, LIGHTS), (1, LIGHTS), (0, 5), (1, 33)].into_iter().enumerate()
            {
                let what = format!("{counting:?}, {}, frame {frame}", base.name);
                let lights = &base.lights[LIGHTS - count..];
                let found = prepare(&mut used, places[place], lights)?;
                let expected = prepare(&mut make()?, places[place], lights)?;
                same(&format!("{what}, lights"), &found.0, &expected.0)?;
                same(&format!("{what}, draws"), &found.1, &expected.1)?;
                same(&format!("{what}, statistics"), &[found.2], &[expected.2])?;
                caps += found
                    .1
                    .iter()
                    .filter(|draws| draws.near_front.instance_count + draws.far_front.instance_count > 0)
                    .count();
                controls += usize::from(last.replace(found).is_some_and(|last| last.1 != expected.1));
            }
        }
    }
    println!("{caps} lights with caps; {controls} frames unlike the one before");
    if caps < 20 || controls < 10 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

fn format_of(scene: &Scene) -> ShadowFormat {
    ShadowFormat { depth: scene.camera.depth, ..ShadowFormat::default() }
}
