//! Shadows of distance fields and meshes against rays to the light: a wrong pixel is at most a texel of the map away from
//! the border of a shadow. By one map, by six, and of the classes of frames of shadow volumes.

use glam::DVec3;
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapCube, DepthMapMethod, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::rays::Tracer;
use wgpu::TextureFormat;

use crate::picture::{AUTOMATIC, EVERY_CELL, Encoded, REVERSED, STANDARD, Target, by, contours, differences, look};
use crate::views::{Receiver, Seen, Sun, Tally, View, worlds};
use crate::worlds::World;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::{Body, Eye, Frame};
use rimline_testkit::textures::objects;

pub(crate) const TESTS: &[Test] = &[
    ("shadows_are_right_but_for_a_texel", of_methods),
    ("classes_of_shadow_volumes_are_right_but_for_a_texel", of_classes),
    ("shadows_of_edges_of_objects_are_right_but_for_a_texel", of_objects),
    ("open_sheets_swap_few_pixels_and_none_with_every_cell", of_sheets),
    ("borders_of_more_bits_are_nearer_to_the_truth", of_bits),
];

/// How a map is made and drawn.
#[derive(Clone, Copy)]
struct Way {
    options: DepthMapOptions,
    /// Texels by which the map is moved: a negative control.
    off: usize,
    /// Whether there are objects.
    has_objects: bool,
    bits: u32,
}

impl Way {
    fn new(options: DepthMapOptions) -> Self {
        Self { options, off: 0, has_objects: false, bits: 1 }
    }

    /// Draws a view, and compares it with rays.
    fn add(self, gpu: &Gpu, view: &View<'_>, format: TextureFormat, tally: &mut Tally) -> Result<Encoded, String> {
        let Self { options, off, has_objects, bits } = self;
        let mut maps = view.moved_maps(gpu, format, off)?;
        if has_objects {
            // The ground is one object, and what stands on it is another.
            let on_ground = |seen: &Seen| u32::from(seen.is_some_and(|(position, _)| position.y < 1e-7));
            let numbers: Vec<_> = view.light_seen()[0].iter().map(on_ground).collect();
            maps.objects = vec![Some(objects(gpu, maps.size, &numbers))];
        }
        let depths = view.eye_depths();
        let (stencil, encoded) =
            Target { bits: 8 - bits..8, ..Target::new(view.eye, &depths) }.draw(gpu, &maps, options)?;
        tally.add(view, &stencil, bits);
        Ok(encoded)
    }
}

/// Draws each view in each way, of worlds that are chosen.
fn trials<const N: usize>(seed: u64, ways: [Way; N], is_chosen: fn(&World) -> bool) -> Result<(), String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let mut all = ways.map(|_| Tally::default());
    // Negative control: the columns of the map are moved.
    let mut off = Tally::default();
    for format in [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm] {
        let mut tallies = ways.map(|_| Tally::default());
        for round in 0..if is_long() { 12 } else { 4 } {
            for world in worlds(&mut random).iter().filter(|world| is_chosen(world)) {
                let Some(view) = View::random(&mut random, world) else { continue };
                for (tally, way) in tallies.iter_mut().zip(ways) {
                    way.add(&gpu, &view, format, tally)?;
                }
                if round == 0 && format == TextureFormat::Depth32Float {
                    Way { off: 3, ..Way::new(by(EVERY_CELL)) }.add(&gpu, &view, format, &mut off)?;
                }
            }
        }
        for ((all, tally), way) in all.iter_mut().zip(tallies).zip(ways) {
            println!("{format:?} {:?}: {tally:?}", way.options.method);
            // The move by the slope is for folds.
            let folds = if way.options.slope_bias > 0.0 { 10_000 } else { 2_000 };
            let is_tried = tally.dark > 1000 && tally.lit > 1000;
            let pixels = tally.pixels();
            if !is_tried || tally.at_borders * 20 > pixels || tally.at_folds * folds > pixels {
                return Err(format!("{format:?} {:?}: {tally:?}", way.options.method));
            }
            all.sum(tally);
        }
    }
    let of_cells = all[0].at_borders;
    for (tally, way) in all.into_iter().zip(ways) {
        // A detector may miss an edge. Walls miss more, at rims that are steeper than the texels show.
        let pixels = tally.pixels();
        let allowed = match way.options.method {
            DepthMapMethod::EveryCell => 0,
            DepthMapMethod::Contours { .. } => pixels / 10_000,
            DepthMapMethod::SecondDifferences { .. } => 1 + pixels / 100_000,
            _ => pixels / 100_000,
        };
        // Contours lie between samples, so borders are smoother than those of every cell, the first way.
        let is_smooth =
            !matches!(way.options.method, DepthMapMethod::Contours { .. }) || 2 * tally.at_borders < of_cells;
        if tally.wrong > allowed || !is_smooth {
            return Err(format!("{:?}: {tally:?}", way.options.method));
        }
    }
    if off.wrong > 50 { Ok(()) } else { Err(format!("negative control: {off:?}")) }
}

/// Each view is drawn with every cell, with cells that detectors mark, and with contours.
fn of_methods() -> Result<(), String> {
    let dangling = Some(DanglingEdges::default());
    let automatic = DepthMapMethod::Automatic { dangling };
    let second = DepthMapMethod::SecondDifferences { low: 0.0005, high: 0.05, dangling };
    let methods = [EVERY_CELL, differences(0.0005), contours([0.0005, 0.25, 0.002]), automatic, second];
    trials(1631, methods.map(|method| Way::new(by(method))), |_| true)
}

/// Objects that cast no shadow onto themselves. Steep sides of the boxes are omitted. Moved, they would leave the boxes
/// behind, and rays would miss a crossing there, so they are not moved.
fn of_objects() -> Result<(), String> {
    let options = DepthMapOptions { slope_bias: 0.0, ..by(differences(1.0)) };
    let way = Way { has_objects: true, ..Way::new(options) };
    trials(1634, [way], |world| matches!(world, World::Sphere { .. } | World::Cuboid { .. }))
}

/// The same views with one bit and with more. The error of a pixel is the difference between the share of its bits that
/// are dark and the truth.
fn of_bits() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1635)?;
    let ways = [(1, EVERY_CELL), (4, EVERY_CELL), (8, EVERY_CELL), (4, differences(0.0005))];
    let mut tallies = ways.map(|_| Tally::default());
    for world in worlds(&mut random).into_iter().chain(worlds(&mut random)) {
        let Some(view) = View::random(&mut random, &world) else { continue };
        for (tally, (bits, method)) in tallies.iter_mut().zip(ways) {
            Way { bits, ..Way::new(by(method)) }.add(&gpu, &view, TextureFormat::Depth32Float, tally)?;
        }
    }
    let errors = tallies.map(|tally| tally.squares);
    println!("mean squares are {:.2} and {:.2} of those of one bit", errors[1] / errors[0], errors[2] / errors[0]);
    // Equal bits would have the error of one bit.
    let is_right = tallies.iter().all(|tally| tally.wrong == 0);
    if is_right && errors[1] < 0.8 * errors[0] && errors[2] < errors[1] { Ok(()) } else { Err(format!("{tallies:?}")) }
}

/// Folds beside each other, some of them steep, of quadrilaterals in two triangles each.
fn sheet(random: &mut Random) -> Vec<[DVec3; 3]> {
    const ACROSS: usize = 9;
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    let (turn, lift, tilt) = (between(0.0, 6.3), between(1.5, 2.5), between(-0.5, 0.5));
    let mut x = -1.5;
    let mut columns = Vec::new();
    for number in 0..ACROSS {
        let height = if number % 2 == 0 { 1.0 } else { -1.0 } * between(0.1, 0.7);
        columns.push((x, height));
        x += between(0.15, 0.6);
    }
    let rows: Vec<_> = (0..4).map(|row| (f64::from(row) - 1.5) * between(0.7, 1.1)).collect();
    let wobbles: Vec<_> = (0..ACROSS * rows.len()).map(|_| between(-1.0, 1.0)).collect();
    let (sin, cos) = turn.sin_cos();
    let position = |column: usize, row: usize| {
        let ((x, height), wobble) = (columns[column], wobbles[row * ACROSS + column]);
        let z = rows[row] * (1.0 + 0.15 * wobble);
        DVec3::new(cos * x - sin * z, lift + height * (1.0 + 0.3 * wobble) + tilt * z, sin * x + cos * z)
    };
    let cells = (1..rows.len()).flat_map(|row| (1..ACROSS).map(move |column| [column, row]));
    let triangles = cells.flat_map(|[x, y]| {
        let [a, b, c, d] = [position(x - 1, y - 1), position(x, y - 1), position(x, y), position(x - 1, y)];
        [[a, b, c], [a, c, d]]
    });
    triangles.collect()
}

/// A ground that is not in the map, beside the shadows of open sheets. The default swaps few pixels of it, and every cell none
/// (docs/numerics/depth-maps.md, "Open sheets").
fn of_sheets() -> Result<(), String> {
    /// Texels of a map a side, and pixels of a picture.
    const SIDE: u32 = 256;
    let (gpu, mut random) = Gpu::seeded(28_001)?;
    let [mut every, mut automatic] = [Tally::default(); 2];
    for round in 0..if is_long() { 60 } else { 4 } {
        let triangles = sheet(&mut random);
        let tracer = || Tracer::build(triangles.iter().map(|&corners| (corners, ())));
        let (casting, drawn) = (World::Bare(tracer()), World::Mesh(tracer()));
        let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
        let towards = DVec3::new(between(-0.8, 0.8), 1.0, between(-0.8, 0.8)).normalize();
        let (depth, light) = ([REVERSED, STANDARD][round % 2], look(towards * 9.0, -towards, 1.0));
        let light = Eye { depth, far: Some(20.0), half_width: Some(4.0), ..light }.camera();
        for _ in 0..6 {
            let angle = between(0.0, 6.3);
            let position = DVec3::new(3.5 * angle.cos(), between(0.3, 4.0), 3.5 * angle.sin());
            let forward = DVec3::new(between(-0.7, 0.7), between(0.6, 2.2), between(-0.7, 0.7)) - position;
            let eye = Eye { is_relative: false, ..look(position, forward, 0.05) }.camera();
            let mut view = View::new((&casting, &drawn), Sun::new(towards, true, vec![light], SIDE), eye, SIDE);
            let all = std::mem::take(&mut view.receivers);
            // Lit ground that has nothing in the map two rows and columns around it.
            let is_nothing = |x: i64, y: i64| {
                let is_outside = [x, y].iter().any(|at| !(0..i64::from(SIDE)).contains(at));
                is_outside || view.light_seen()[0][(y * i64::from(SIDE) + x) as usize].is_none()
            };
            let is_open = |receiver: &Receiver| {
                let at = view.sun.in_map(receiver.seen.0) * f64::from(SIDE);
                let [x, y] = [at.x, at.y].map(|at| at.floor() as i64);
                let is_lit_ground = receiver.seen.0.y < 1e-7 && receiver.is_lit;
                is_lit_ground && (-2..=2).all(|down| (-2..=2).all(|across| is_nothing(x + across, y + down)))
            };
            view.receivers = all.into_iter().filter(is_open).collect();
            for (tally, method) in [(&mut every, EVERY_CELL), (&mut automatic, AUTOMATIC)] {
                Way::new(by(method)).add(&gpu, &view, TextureFormat::Depth32Float, tally)?;
            }
        }
    }
    println!("{every:?}, {automatic:?}");
    // Wherever the borders are. Without wrong pixels the limit is gone, and the documents have to say so.
    let (pixels, [every_wrong, wrong]) = (automatic.lit, [every, automatic].map(|tally| tally.squares));
    // Nothing derives how few they are: the bounds are measured. The long run had 1,029 of 5,963,571 wrong (1.7 in 10,000), the
    // short one 13 of 520,040.
    let most = if is_long() { 1.0 / 5000.0 } else { 1.0 / 10_000.0 };
    if every_wrong == 0.0 && pixels > 300_000 && wrong > 0.0 && wrong < most * pixels as f64 {
        Ok(())
    } else {
        Err(format!("{every:?}, {automatic:?}"))
    }
}

/// Texels of a map of a frame. The near planes of its light are as far away as `NEAR`, and nothing casts that is nearer.
const TEXELS: u32 = 96;
const NEAR: f64 = 0.01;

/// The triangles of bodies that `is_wanted` takes.
fn triangles(frame: &Frame, is_wanted: fn(&Body) -> bool) -> Vec<[DVec3; 3]> {
    let wanted = frame.bodies.iter().filter(|body| is_wanted(body));
    let triangles = wanted.flat_map(|body| {
        let corner = |v: u32| DVec3::from_array(body.shape.positions[v as usize].map(f64::from));
        body.finite_faces().into_iter().map(move |face| face.map(corner))
    });
    triangles.collect()
}

/// The light of a frame, with one camera if the casters fit it, or six.
fn sun_of(frame: &Frame, depth: DepthDirection) -> Result<Sun, String> {
    let points = triangles(frame, |body| body.casts).concat();
    let centre = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let radius = points.iter().map(|point| point.distance(centre)).fold(0.0, f64::max);
    let light = frame.lights[0];
    let at = DVec3::from_array(light.xyz.map(f64::from));
    if light.w == 0.0 {
        let towards = at.normalize();
        let (far, half_width) = (Some(2.0 * radius + 2.0), Some(1.05 * radius));
        let eye = look(centre + (radius + 1.0) * towards, -towards, 0.5);
        return Ok(Sun::new(towards, true, vec![Eye { depth, far, half_width, ..eye }.camera()], TEXELS));
    }
    let way = centre - at;
    if radius < 0.45 * way.length() {
        let eye = Eye { depth, ..look(at, way, (way.length() - radius) / 2.0) };
        return Ok(Sun::new(at, false, vec![eye.camera()], TEXELS));
    }
    let cameras = DepthMapCube::cameras(at.as_vec3().to_array(), NEAR as f32, None, depth, TEXELS).map_err(text)?;
    Ok(Sun::new(at, false, cameras.to_vec(), TEXELS))
}

/// Classes in which the default detector may be wrong: the light is within a caster, or shines into one through a hole,
/// or the near plane cuts casters. docs/measured.md, "Casters without a mesh". In all others it is right, in some of
/// them with the near rectangle within a caster, too.
const MAY_BE_WRONG: [&str; 6] = [
    "directional lights",
    "near plane through caster and almost the light",
    "light on the near plane",
    "light inside a caster",
    "nested and inverted bodies",
    "faces that are not finite",
];

/// The cameras and scenes of the tests of shadow volumes: their casters in one map of a light, or in six.
fn of_classes() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_701)?;
    let [mut every, mut automatic, mut moved] = [Tally::default(); 3];
    // Frames with one map and six, and those with a near cap that is drawn. Wrong with the default detector in the
    // other classes.
    let (mut maps, mut caps, mut without) = ([0; 2], 0, 0);
    for class in CLASSES {
        let mut of_class = Tally::default();
        for round in 0..if is_long() { 40 } else { 2 } {
            let frame = (class.frame)(&mut random);
            let sun = sun_of(&frame, [REVERSED, STANDARD][round % 2])?;
            let bare = |is_wanted| {
                World::Bare(Tracer::build(triangles(&frame, is_wanted).into_iter().map(|corners| (corners, ()))))
            };
            let (casting, drawn) = (bare(|body| body.casts), bare(|body| body.is_drawn));
            let view = View::new((&casting, &drawn), sun, frame.eye.camera(), 64);
            // Frames with a surface near the light's near plane are skipped: a surface before that plane casts from the
            // plane.
            let at = view.sun.homogeneous();
            let is_near = |seen: &Seen| seen.is_some_and(|(position, _)| position.distance(at.truncate()) < 2.0 * NEAR);
            if at.w != 0.0 && view.light_seen().iter().flatten().any(is_near) {
                continue;
            }
            let format = TextureFormat::Depth32Float;
            caps += usize::from(Way::new(by(EVERY_CELL)).add(&gpu, &view, format, &mut every)?.has_cap());
            Way::new(by(AUTOMATIC)).add(&gpu, &view, format, &mut of_class)?;
            if round == 0 {
                // The negative control takes long.
                let way = Way { off: 20 * TEXELS as usize + 20, ..Way::new(by(EVERY_CELL)) };
                way.add(&gpu, &view, format, &mut moved)?;
            }
            maps[usize::from(view.sun.cameras.len() > 1)] += 1;
        }
        println!("{}, by the default detector: {of_class:?}", class.name);
        without += if MAY_BE_WRONG.contains(&class.name) { 0 } else { of_class.wrong };
        automatic.sum(of_class);
    }
    println!("{every:?}, {automatic:?}, moved {moved:?}, {maps:?} with one map and six, {caps} near caps");
    println!("wrong with the default detector in classes where it is right: {without}");
    let is_tried = maps[0].min(maps[1]) > 10 && caps > 20 && every.dark * 5 > every.pixels();
    let is_right = every.wrong == 0 && without == 0 && automatic.wrong * 10_000 <= automatic.pixels();
    if is_tried && is_right && every.at_borders * 50 < every.pixels() && moved.wrong * 50 > moved.pixels() {
        Ok(())
    } else {
        Err(format!("{every:?}, {automatic:?}, {moved:?}, {without}"))
    }
}
