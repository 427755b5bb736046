//! Every stage against its CPU twin.

use rimline::cpu::{self, Threads};
use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::layout::{DrawArguments, DrawShape, Masks, Statistics};
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Method, shapes};

use crate::common::device::Gpu;
use crate::common::random::Random;
use crate::common::{lights, same};

pub(crate) const TESTS: &[crate::Test] = &[
    ("facing_and_edges_equal_their_twins", facing_and_edges),
    ("ordered_lists_equal_their_twin", ordered_lists),
    ("unordered_lists_hold_the_same_edges", unordered_lists),
    ("overflowing_lists_are_counted_and_drawn_whole", overflow),
    ("per_edge_equals_its_twin", per_edge),
];

/// What one extraction left in its buffers.
pub(crate) struct Found {
    pub(crate) facing: Vec<u32>,
    pub(crate) masks: Vec<Masks>,
    pub(crate) lists: Vec<Vec<u32>>,
    pub(crate) counts: Vec<u32>,
    pub(crate) draws: Vec<DrawArguments>,
    pub(crate) statistics: Statistics,
}

/// Extracts on the GPU and reads everything back.
pub(crate) fn extract(
    gpu: &Gpu,
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    options: ExtractorOptions,
) -> Result<Found, String> {
    let buffer = gpu.storage(positions);
    let mut extractor = Extractor::new(&gpu.device, mesh, options).map_err(|error| error.to_string())?;
    let positions = PositionBuffer {
        buffer: &buffer,
        offset: 0,
        stride: 12,
    };
    gpu.submit(|encoder| {
        extractor
            .encode(encoder, positions, lights, None)
            .map_err(|error| error.to_string())
    })?;
    read(gpu, &extractor, mesh, options.max_lights)
}

pub(crate) fn read(gpu: &Gpu, extractor: &Extractor, mesh: &Mesh, max_lights: usize) -> Result<Found, String> {
    let results = extractor.results();
    let mut found = Found {
        facing: Vec::new(),
        masks: Vec::new(),
        lists: Vec::new(),
        counts: gpu.read(results.counts, max_lights)?,
        draws: gpu.read(results.draw_arguments, max_lights)?,
        statistics: gpu.read(results.statistics, 1)?[0],
    };
    for plane in results.facing {
        found.facing.extend(gpu.read::<u32>(plane, mesh.faces().len())?);
    }
    for plane in results.masks {
        found.masks.extend(gpu.read::<Masks>(plane, mesh.edges().len())?);
    }
    for (word, list) in results.lists.iter().enumerate() {
        let capacity = results.capacity as usize;
        let entries: Vec<u32> = gpu.read(list, usize::MAX)?;
        for light in 0..(max_lights - 32 * word).min(32) {
            let count = (found.counts[32 * word + light] as usize).min(capacity);
            found.lists.push(entries[light * capacity..][..count].to_vec());
        }
    }
    Ok(found)
}

/// Shapes of every topology: closed, open, non-orientable, non-manifold, with faces that name a vertex twice.
pub(crate) fn topologies() -> Vec<(&'static str, Vec<[f32; 3]>, Mesh)> {
    let mut soup = shapes::torus(12, 9, 1.0, 0.4);
    let mut random = Random::new(7);
    for _ in 0..60 {
        soup.faces.push(std::array::from_fn(|_| random.below(24) as u32));
    }
    let shapes = [
        ("torus", shapes::torus(40, 30, 1.0, 0.4)),
        ("blob", shapes::blob(4, 0.3, 1)),
        ("grid", shapes::plane_grid(17, 9)),
        ("moebius", shapes::moebius(40, 4)),
        ("three sheets", shapes::three_sheets(5)),
        ("soup", soup),
    ];
    shapes
        .into_iter()
        .map(|(name, shape)| {
            let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).expect("a shape is a mesh");
            (name, shape.positions, mesh)
        })
        .collect()
}

const LIGHT_COUNTS: [usize; 6] = [1, 12, 31, 32, 33, 100];

fn facing_and_edges() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let seed = 1;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    for (name, positions, mesh) in topologies() {
        for count in LIGHT_COUNTS {
            let lights = lights(&mut random, count);
            let options = ExtractorOptions {
                max_lights: count,
                masks: true,
                lists: None,
                ..Default::default()
            };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            let twin = cpu::facing(&positions, mesh.faces(), &lights, Threads::all());
            same(&format!("{name}, {count} lights, facing"), &found.facing, &twin)?;
            let masks = cpu::edges(mesh.edges(), &twin, mesh.faces().len(), count, Threads::all());
            same(&format!("{name}, {count} lights, masks"), &found.masks, &masks)?;
        }
    }
    Ok(())
}

fn twin_masks(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light]) -> Vec<Masks> {
    cpu::extract(positions, mesh, lights, Method::FaceMask, Threads::all())
        .expect("good lights")
        .masks
}

fn list_options(capacity: Option<u32>, ordered: bool) -> Option<ListOptions> {
    Some(ListOptions {
        capacity,
        ordered,
        vertices_per_edge: 6,
    })
}

fn ordered_lists() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(2);
    for (name, positions, mesh) in topologies() {
        for (count, masks) in LIGHT_COUNTS
            .into_iter()
            .flat_map(|count| [(count, false), (count, true)])
        {
            let lights = lights(&mut random, count);
            let options = ExtractorOptions {
                max_lights: count,
                masks,
                lists: list_options(None, true),
                ..Default::default()
            };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            let twins = twin_masks(&positions, &mesh, &lights);
            for light in 0..count {
                let plane = &twins[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
                let twin = cpu::compact(plane, light as u32 % 32, usize::MAX);
                same(
                    &format!("{name}, light {light} of {count}, list"),
                    &found.lists[light],
                    &twin.entries,
                )?;
                same(
                    &format!("{name}, light {light} of {count}, count"),
                    &[found.counts[light]],
                    &[twin.count],
                )?;
            }
        }
    }
    Ok(())
}

fn unordered_lists() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(3);
    for (name, positions, mesh) in topologies() {
        for count in LIGHT_COUNTS {
            let lights = lights(&mut random, count);
            let unordered = ExtractorOptions {
                max_lights: count,
                lists: list_options(Some(u32::MAX), false),
                ..Default::default()
            };
            let ordered = ExtractorOptions {
                lists: list_options(Some(u32::MAX), true),
                ..unordered
            };
            let mut found = extract(gpu, &positions, &mesh, &lights, unordered)?;
            let expected = extract(gpu, &positions, &mesh, &lights, ordered)?;
            found
                .lists
                .iter_mut()
                .for_each(|list| list.sort_by_key(|entry| entry & !cpu::WINDING));
            same(&format!("{name}, {count} lights, lists"), &found.lists, &expected.lists)?;
            same(&format!("{name}, {count} lights, draws"), &found.draws, &expected.draws)?;
        }
    }
    Ok(())
}

fn overflow() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(4);
    let lights = lights(&mut random, 40);
    for (name, positions, mesh) in topologies() {
        let whole = ExtractorOptions {
            max_lights: 40,
            lists: list_options(Some(u32::MAX), true),
            ..Default::default()
        };
        let whole = extract(gpu, &positions, &mesh, &lights, whole)?;
        for ordered in [false, true] {
            let options = ExtractorOptions {
                max_lights: 40,
                lists: list_options(Some(20), ordered),
                ..Default::default()
            };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            same(&format!("{name}, counts"), &found.counts, &whole.counts)?;
            let shape = DrawShape {
                lights: 40,
                capacity: 20,
                edges: mesh.edges().len() as u32,
                vertices_per_edge: 6,
            };
            let (draws, overflowed) = cpu::arguments(shape, &whole.counts);
            same(&format!("{name}, draws"), &found.draws, &draws)?;
            same(
                &format!("{name}, overflowed"),
                &[found.statistics.overflowed_lists],
                &[overflowed],
            )?;
            for (list, whole) in found.lists.iter().zip(&whole.lists) {
                if ordered {
                    same(&format!("{name}, list"), list, &whole[..whole.len().min(20)])?;
                } else if !list.iter().all(|entry| whole.contains(entry)) {
                    return Err(format!("{name}: a list holds what is no silhouette"));
                }
            }
        }
    }
    Ok(())
}

fn per_edge() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(5);
    for (name, positions, mesh) in topologies() {
        for count in LIGHT_COUNTS {
            let lights = lights(&mut random, count);
            let options = ExtractorOptions {
                max_lights: count,
                method: Method::PerEdge,
                masks: true,
                lists: list_options(None, false),
                ..Default::default()
            };
            let found = extract(gpu, &positions, &mesh, &lights, options)?;
            let twin = cpu::per_edge(&positions, &mesh, &lights, Threads::all());
            same(&format!("{name}, {count} lights"), &found.masks, &twin)?;
        }
    }
    Ok(())
}
