//! Maps of distances: the depths that `depth_metric` makes from them against `f64`, within the bound of
//! docs/numerics/depth-maps.md, "Maps of distances", and shadows of maps that were converted. Two maps in one by
//! `depth_merge`.

use glam::{DVec2, DVec3, Mat4};
use rimline::gpu::depth_map::{DepthMap, DepthMapOptions, DepthMapTexture, DepthMetric};
use rimline::internals::depth_map::metric_steps;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};
use wgpu::TextureFormat;

use crate::distances::Measured;
use crate::maps::maps;
use crate::parity::device_depth;
use crate::picture::{Maps, REVERSED, STANDARD, Target, look};
use crate::stages::camera;
use rimline_testkit::frames::{Eye, Rays, vector};
use rimline_testkit::textures::{depth_view, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("distances_become_the_depths_of_their_places", depths),
    ("a_flat_ground_of_distances_has_no_specks", flat),
    ("merged_maps_have_the_nearer_depth_and_converted_ones_theirs", nearer),
];

/// Values that are no distance.
const NONE: [f32; 12] = [
    f32::INFINITY,
    f32::NAN,
    f32::from_bits(0xffc0_1234),
    f32::MAX,
    1e38,
    f32::NEG_INFINITY,
    -1.0,
    -f32::MAX,
    -0.0,
    0.0,
    f32::from_bits(1),
    f32::from_bits(0x8000_0001),
];

const DISTANCES: [DepthMetric; 2] = [DepthMetric::AlongAxis, DepthMetric::AlongRay];

/// The camera with its picture moved aside, so that rays that meet lie askew around the axis, and parallel ones askew to it.
pub(crate) fn aside(camera: ShadowCamera, by: [f32; 2]) -> ShadowCamera {
    let mut rows = Mat4::from_cols_array_2d(&camera.view_projection).transpose();
    let is_parallel = rows.w_axis.truncate() == glam::Vec3::ZERO;
    let sheared = if is_parallel { rows.z_axis } else { rows.w_axis };
    rows.x_axis += by[0] * sheared;
    rows.y_axis += by[1] * sheared;
    ShadowCamera { view_projection: rows.transpose().to_cols_array_2d(), ..camera }
}

/// A camera of any kind, and the distances of its near and far plane.
fn light(random: &mut Random, number: usize) -> (ShadowCamera, [f64; 2]) {
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][number % 2];
    let near = [0.01, 0.5, 3.0][random.below(3)];
    let (far, half_width) =
        [(None, None), (Some(40.0), None), (Some(3.5), None), (Some(40.0), Some(4.0))][number / 2 % 4];
    let forward = vector(random);
    let position = -9.0 * forward;
    let eye = Eye { position, forward, near, is_relative: random.below(3) > 0, depth, far, half_width };
    let by = if random.below(3) == 0 { [random.between(-1.5, 1.5), random.between(-1.5, 1.5)] } else { [0.0; 2] };
    let from_near = if half_width.is_some() { near } else { 0.0 };
    (aside(eye.camera(), by), [near - from_near, far.unwrap_or(1e6) - from_near])
}

/// Distances around and between the planes, and many close to the far one.
fn distances(random: &mut Random, texels: u32, [near, far]: [f64; 2]) -> Vec<f32> {
    let one = |_| {
        let share = f64::from(random.between(0.0, 1.0));
        let distance = match random.below(5) {
            0 => near * (0.3 + share) - 0.01,
            1 => far * (1.0 - 0.01 * share * share),
            2 => near + (far.min(50.0) - near) * share,
            3 => near * 3.0 * share,
            _ => (near.max(0.01).ln() * (1.0 - share) + (1.3 * far).ln() * share).exp(),
        };
        distance as f32
    };
    (0..texels).map(one).collect()
}

/// The middle of a texel, from -1 to 1 to the right and up.
fn middle(size: [u32; 2], texel: usize) -> DVec2 {
    let [x, y] = [texel as u32 % size[0], texel as u32 / size[0]].map(|at| f64::from(at) + 0.5);
    DVec2::new(2.0 * x / f64::from(size[0]) - 1.0, 1.0 - 2.0 * y / f64::from(size[1]))
}

/// Compares depths with those of the positions. Returns the largest share of the bound that a depth is off.
fn compare(
    camera: &ShadowCamera,
    metric: DepthMetric,
    (size, given): ([u32; 2], &[f32]),
    found: &[f32],
) -> Result<f64, String> {
    let measured = Measured::new(camera);
    let [share, constant] = metric_steps(camera, metric).map_err(text)?;
    let is_reversed = camera.depth == DepthDirection::Reversed;
    let (near, far) = if is_reversed { (1.0, 0.0) } else { (0.0, 1.0) };
    let rays_meet = camera.view_projection[..3].iter().any(|column| column[3] != 0.0);
    let mut most = 0.0_f64;
    for (texel, (&distance, &found)) in given.iter().zip(found).enumerate() {
        // NaN and numbers that are too large are far, to the bit. The others of `NONE` are near, to the bit where rays meet;
        // a matrix of parallel ones is tilted by rounding.
        let is_far = distance.is_nan() || distance > 1e37;
        if is_far || (rays_meet && NONE.contains(&distance)) {
            let end = if is_far { far } else { near as f32 };
            same(&format!("{metric:?} {distance}"), &bits(&[found]), &bits(&[end]))?;
            continue;
        }
        let position = measured.position(metric, middle(size, texel), f64::from(distance));
        let (depth, is_before) = measured.depth(position);
        let truth = if is_before { depth.clamp(0.0, 1.0) } else { near };
        let bound = share * truth + constant;
        let off = (f64::from(found) - truth).abs() / bound;
        let clamped = if is_before { depth } else { near };
        // Beyond the far plane there is nothing, to the bit.
        let is_nothing = if is_reversed { clamped < -constant } else { clamped > 1.0 + share + constant };
        if off.is_nan() || off > 1.0 || (is_nothing && found != far) {
            return Err(format!(
                "texel {texel}, {metric:?} {distance}: {found} for {depth}, {off} of the bound; {camera:?}"
            ));
        }
        most = most.max(off);
    }
    Ok(most)
}

fn converted(
    gpu: &Gpu,
    camera: &ShadowCamera,
    metric: DepthMetric,
    (size, given): ([u32; 2], &[f32]),
) -> Result<wgpu::Texture, String> {
    let map = texture(gpu, size, TextureFormat::R32Float, given)?;
    let conversion = DepthMapTexture::new(&gpu.pipelines, size).map_err(text)?;
    let view = depth_view(&map);
    let map = DepthMap::new(&view, *camera);
    gpu.submit(|encoder| conversion.convert(encoder, &map, metric).map_err(text))?;
    Ok(conversion.view().texture().clone())
}

fn depths() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1701)?;
    let (mut texels, mut most, mut others) = (0, 0.0_f64, 0);
    for number in 0..48 {
        let (camera, planes) = light(&mut random, number);
        let size = [[1, 1], [7, 45], [64, 33]][number % 3];
        let mut given = distances(&mut random, size[0] * size[1], planes);
        if number % 3 > 0 {
            given[..NONE.len()].copy_from_slice(&NONE);
        }
        for metric in DISTANCES {
            let found = read(&gpu, &converted(&gpu, &camera, metric, (size, &given))?)?;
            most = most.max(compare(&camera, metric, (size, &given), &found)?);
            texels += given.len();
            // Negative controls: a depth is off by twice the bound, and distances have the other metric.
            let [share, constant] = metric_steps(&camera, metric).map_err(text)?;
            let mut off = found.clone();
            let last = off.len() - 1;
            let bound = share * f64::from(off[last]) + constant + f64::from(off[last]) * 1e-7;
            off[last] += if off[last] > 0.5 { -2.5 * bound } else { 2.5 * bound } as f32;
            must_fail("a depth is off", &compare(&camera, metric, (size, &given), &off))?;
            let other = DISTANCES[usize::from(metric == DISTANCES[0])];
            // At the right of the picture the metrics differ, but for parallel rays at right angles to the planes.
            let measured = Measured::new(&camera);
            let position = measured.position(metric, DVec2::new(0.9, 0.0), 1.0);
            if size[0] == 64 && (measured.distance(other, position) - 1.0).abs() > 1e-3 {
                others += 1;
                must_fail("the other metric", &compare(&camera, other, (size, &given), &found))?;
            }
        }
    }
    println!("{texels} texels; off by at most {most} of the bound");
    // A bound that is far too wide would prove little.
    if most > 0.2 && others > 20 { Ok(()) } else { Err(format!("{most}, {others}")) }
}

/// A ground at right angles to the light's axis, where no slope moves the boundary, is lit.
fn flat() -> Result<(), String> {
    const SIDE: u32 = 64;
    const TEXELS: u32 = 256;
    let (gpu, mut random) = Gpu::seeded(1704)?;
    // Dark pixels, and, the negative control, those without what the conversion may be off by.
    let mut dark = [0; 2];
    for number in 0..16 {
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][number % 2];
        // The ground is close to the far plane, or close to the near plane of a camera without one, or between them.
        let (near, far) = [(5.0, Some(100.0)), (60.0, None), (0.1, Some(90.5)), (75.0, Some(110.0))][number / 2 % 4];
        let is_relative = random.below(2) == 0;
        let camera = Eye { is_relative, depth, far, ..look(DVec3::new(0.0, 90.0, 0.0), DVec3::NEG_Y, near) }.camera();
        let measured = Measured::new(&camera);
        let on_ground = |rays: &Rays, pixel: u32, side: u32| {
            let (from, direction) = rays.at(crate::parity::middle(pixel, side));
            from - from.y / direction.y * direction
        };
        let rays = Rays::new(&camera, TEXELS);
        let distance = |texel| measured.distance(DISTANCES[1], on_ground(&rays, texel, TEXELS)) as f32;
        let distances: Vec<f32> = (0..TEXELS * TEXELS).map(distance).collect();
        let map = converted(&gpu, &camera, DISTANCES[1], ([TEXELS; 2], &distances))?;
        // All pixels are well within the map, and the eye's depth is more precise than the map's.
        let mut aside = || f64::from(random.between(-40.0, 40.0));
        let eye = look(DVec3::new(aside(), 2.0, aside()), DVec3::NEG_Y, 1.9).camera();
        let rays = Rays::new(&eye, SIDE);
        let depths: Vec<_> = (0..SIDE * SIDE).map(|pixel| device_depth(&eye, on_ground(&rays, pixel, SIDE))).collect();
        for (dark, metric) in dark.iter_mut().zip([DISTANCES[1], DepthMetric::Device]) {
            let options = DepthMapOptions { metric, ..Default::default() };
            let stencil = Target::new(eye, &depths).stencil(&gpu, &Maps::one(&map, camera), options)?;
            *dark += stencil.iter().filter(|&&stencil| stencil != 0).count();
        }
    }
    println!("dark: {}; without what the conversion may be off by: {}", dark[0], dark[1]);
    if dark[0] == 0 && dark[1] > 20 { Ok(()) } else { Err(format!("{dark:?}")) }
}

const FORMATS: [[TextureFormat; 2]; 4] = [
    [TextureFormat::R32Float; 2],
    [TextureFormat::Depth32Float, TextureFormat::R32Float],
    [TextureFormat::Depth16Unorm, TextureFormat::Depth24PlusStencil8],
    [TextureFormat::R32Float, TextureFormat::Depth16Unorm],
];

/// A depth as stages read it: NaN is far, numbers are clamped, and what is smaller than every normal number is 0.
fn cleaned(depth: f32, far: f32) -> f32 {
    match depth {
        depth if depth.is_nan() => far,
        depth if f64::from(depth) < 2.0_f64.powi(-126) => 0.0,
        depth => depth.min(1.0),
    }
}

pub(crate) fn bits(depths: &[f32]) -> Vec<u32> {
    depths.iter().map(|depth| depth.to_bits()).collect()
}

/// Device depths that are merged or converted are clamped, and cleared of what is no depth.
fn nearer() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1641)?;
    let (mut texels, mut nearest) = (0, [0; 2]);
    for formats in FORMATS {
        // Hostile maps meet others of their size.
        let (firsts, mut others) = (maps(&mut random), maps(&mut random));
        others.chunks_mut(5).for_each(|chunk| chunk.rotate_left(1));
        for pair in firsts.into_iter().zip(others).map(|(a, b)| [a, b]) {
            let (size, is_reversed) = (pair[0].size, pair[0].is_reversed);
            let texture = |at: usize| texture(&gpu, size, formats[at], &pair[at].for_format(formats[at]).depths);
            let textures = [texture(0)?, texture(1)?];
            let views = textures.each_ref().map(depth_view);
            let read_of = |at: usize| {
                let depths = read(&gpu, &textures[at])?.into_iter();
                Ok::<_, String>(depths.map(|depth| cleaned(depth, pair[0].far())).collect::<Vec<_>>())
            };
            let [first, second] = [read_of(0)?, read_of(1)?];
            let nearest_of = |(&a, &b): (&f32, &f32)| if is_reversed { a.max(b) } else { a.min(b) };
            let truth: Vec<_> = first.iter().zip(&second).map(nearest_of).collect();
            let map = DepthMapTexture::new(&gpu.pipelines, size).map_err(text)?;
            let merged = |depth| {
                gpu.submit(|encoder| map.merge(encoder, views.each_ref(), depth).map_err(text))?;
                Ok::<_, String>(bits(&read(&gpu, map.view().texture())?))
            };
            let what = format!("{formats:?} {size:?}, reversed {is_reversed}");
            same(&what, &merged(pair[0].direction())?, &bits(&truth))?;
            let given = DepthMap::new(&views[0], camera(pair[0].direction()));
            gpu.submit(|encoder| map.convert(encoder, &given, DepthMetric::Device).map_err(text))?;
            let converted = bits(&read(&gpu, map.view().texture())?);
            same("converted", &converted, &bits(&first))?;
            // Negative controls: the other map, and the other direction, which takes the farther depth.
            if first != second {
                must_fail("the other map", &same("converted", &converted, &bits(&second)))?;
            }
            let is_inner = |depth: f32| (0.1..0.9).contains(&depth);
            if first.iter().zip(&second).any(|(&a, &b)| a != b && is_inner(a) && is_inner(b)) {
                let other = merged(if is_reversed { STANDARD } else { REVERSED })?;
                must_fail("the other direction", &same(&what, &other, &bits(&truth)))?;
            }
            texels += truth.len();
            for (nearest, depths) in nearest.iter_mut().zip([&first, &second]) {
                *nearest += depths.iter().zip(&truth).filter(|(depth, truth)| depth == truth).count();
            }
        }
    }
    println!("{texels} texels, {nearest:?} nearest from the first and the second");
    if nearest.iter().any(|&nearest| nearest * 4 < texels) { Err(format!("{nearest:?} of {texels}")) } else { Ok(()) }
}
