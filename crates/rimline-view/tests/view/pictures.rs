//! Pictures: shadows are where rays say, switches change nothing or what they are for, and nothing is drawn twice.

use glam::{Vec2, Vec3};
use rimline::Light;
use rimline::cpu::{Threads, shadow_depth};
use rimline::gltf::{CameraProjection, SceneCamera};
use rimline_files::{ReadOptions, read_bytes};
use rimline_testkit::harness::Test;
use rimline_view::{
    Action, Body, BodyError, Counting, Event, LampKind, Mode, Modifiers, Picture, Renderer, Skipping, Source, Viewer,
    scenes,
};

use crate::support::{Outcome, block, drag, finish, gpu, handle, hold, on_ground, picture, rest, say, viewer};

pub(crate) const TESTS: [Test; 16] = [
    ("a light dragged moves its shadow to where rays say", a_light_dragged_moves_its_shadow),
    ("a light with an area has soft shadows", soft_shadows),
    ("a spot lights a circle that is dragged", spots),
    ("a still viewer draws nothing", a_still_viewer_draws_nothing),
    ("a large picture that moves has half the rows and columns of the full one", a_moving_picture_is_coarse),
    ("a state that cannot be drawn leaves the last picture, of its size", a_failure_leaves_the_last_picture),
    ("counting methods and levels of skipping change no picture", switches_change_no_picture),
    ("a model that nothing seen needs is left out, if that is wanted", casters_that_are_not_needed),
    ("every overlay and mode changes the picture and nothing fails", overlays_change_the_picture),
    ("creases are drawn where faces meet at an edge", creases),
    ("clusters are those of the pose in which they are switched on again", clusters_anew),
    ("cameras of the file are looked through", cameras),
    ("models have their base colours, or are of clay", base_colors),
    ("built-in scenes are drawn in every moment", scenes_are_drawn),
    ("a screenshot has more pixels and the same picture", screenshots),
    ("lights come, go and change their kind", lights_come_and_go),
];

/// A pixel, the point of the ground there, and counts of faces.
type Seen = ([u32; 2], Vec3, Vec<i32>);

/// Every third pixel of each axis that shows the ground, with the point there and the faces of all models between each
/// light and the points at these offsets.
fn ground(viewer: &Viewer, lights: &[Light], offsets: &[[f32; 2]]) -> Result<Vec<Seen>, String> {
    let [width, height] = viewer.size();
    let pixels = (0..height).step_by(3).flat_map(|y| (0..width).step_by(3).map(move |x| [x, y]));
    let pixels: Vec<_> = pixels.filter_map(|at| Some((at, on_ground(viewer, at)?))).collect();
    let points: Vec<[f32; 3]> =
        pixels.iter().flat_map(|(_, p)| offsets.iter().map(move |[x, z]| [p.x + x, p.y, p.z + z])).collect();
    let lights = [lights, &[Light::point(viewer.camera().view.eye.into())]].concat();
    let mut counts = vec![0; points.len() * lights.len()];
    for body in &viewer.bodies {
        let seconds = viewer.clock.seconds;
        let mesh = body.model().mesh(&body.pose(seconds).map_err(say)?).map_err(say)?;
        let world = body.positions(seconds).map_err(say)?;
        let found = shadow_depth(&world, &mesh, &points, &lights, Threads::all()).map_err(say)?;
        counts.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
    }
    let of_pixels = pixels.into_iter().zip(counts.chunks(offsets.len() * lights.len()));
    let seen = of_pixels.filter_map(|((at, point), counts)| {
        let mut of_points = counts.chunks(lights.len());
        let is_seen = of_points.all(|counts| counts.last() == Some(&0));
        let others = counts.chunks(lights.len()).flat_map(|counts| &counts[..lights.len() - 1]);
        is_seen.then(|| (at, point, others.copied().collect()))
    });
    Ok(seen.collect())
}

/// Pixels of the ground whose shadow the picture shows wrongly, and those that were looked at: far enough from models and
/// borders of shadows that a pixel's width does not matter.
fn wrong_on_ground(viewer: &Viewer, picture: &Picture, dark: &Picture) -> Result<[usize; 3], String> {
    let (mut wrong, mut shadowed, mut lit) = (0, 0, 0);
    // Each point and four around it: where all five agree, no border is near.
    let near = 1.5 * viewer.camera().pixel() * viewer.orbit.distance;
    let around = [[0.0, 0.0], [near, 0.0], [-near, 0.0], [0.0, near], [0.0, -near]];
    for (at, _, counts) in ground(viewer, &[viewer.lamps[0].light()], &around)? {
        let is_dark = counts[0] != 0;
        if counts.iter().all(|&count| (count != 0) == is_dark) {
            // Ambient light alone, or more.
            let shows_dark = (sum(picture, at) - sum(dark, at)).abs() <= 6;
            *(if is_dark { &mut shadowed } else { &mut lit }) += 1;
            wrong += usize::from(shows_dark != is_dark);
        }
    }
    Ok([wrong, shadowed, lit])
}

fn a_light_dragged_moves_its_shadow() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::still_life, [420, 300])?;
    viewer.lamps.truncate(1);
    viewer.lamps[0].color = [1.0; 3];
    let before = picture(&viewer, &mut renderer)?;
    let from = handle(&viewer, 0)?;
    for (to, modifiers) in [
        (from, Modifiers::default()),
        (from + Vec2::new(150.0, 20.0), Modifiers::default()),
        (from + Vec2::new(100.0, 40.0), Modifiers { shift: true, ..Modifiers::default() }),
    ] {
        let start = handle(&viewer, 0)?;
        drag(&mut viewer, start, to, modifiers);
        let lit = picture(&viewer, &mut renderer)?;
        // The same without what the light adds: darkness, as bright as ambient light is.
        let ambient = ambient_only(&mut viewer, &mut renderer)?;
        let [wrong, shadowed, bright] = wrong_on_ground(&viewer, &lit, &ambient)?;
        println!("{to}: {wrong} wrong of {shadowed} in shadow and {bright} lit");
        hold(wrong == 0, format!("{to}: {wrong} wrong of {shadowed} in shadow and {bright} lit"))?;
        hold(shadowed > 40 && bright > 400, format!("{to}: only {shadowed} in shadow and {bright} lit"))?;
    }
    hold(picture(&viewer, &mut renderer)? != before, "the picture did not change")
}

/// Brightness of a pixel.
fn sum(picture: &Picture, at: [u32; 2]) -> i32 {
    picture.at(at)[..3].iter().map(|&c| i32::from(c)).sum()
}

fn soft_shadows() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::still_life, [420, 300])?;
    viewer.lamps.truncate(1);
    viewer.lamps[0].color = [1.0; 3];
    let radius = 0.25 * viewer.bounds().extent();
    viewer.lamps[0].radius = Some(radius);
    let soft = picture(&viewer, &mut renderer)?;
    let ambient = ambient_only(&mut viewer, &mut renderer)?;
    viewer.options.shadows = false;
    let unshadowed = picture(&viewer, &mut renderer)?;
    viewer.options.shadows = true;
    let sources: Vec<Light> = viewer.lamps[0].sources().iter().map(rimline_view::Lamp::light).collect();
    hold(sources.len() == 16, "an area has sixteen samples")?;
    let pixels = ground(&viewer, &sources, &[[0.0; 2]])?;
    let (mut wrong, mut between) = (0, 0);
    for (at, _, counts) in &pixels {
        let share = counts.iter().filter(|&&count| count == 0).count() as f64 / 16.0;
        let [now, dark, bright] = [&soft, &ambient, &unshadowed].map(|picture| sum(picture, *at));
        // Borders pass through some pixels, so a share may be off by three samples.
        if bright - dark >= 60 && (0.25..=0.75).contains(&share) {
            between += 1;
            wrong += usize::from(now < dark + 8 || now > bright - 8);
        }
    }
    println!("{wrong} wrong of {between} in half shadow");
    hold(wrong == 0 && between > 60, format!("{wrong} wrong of {between} in half shadow"))?;
    let area = format!(",radius={radius} --samples 16 --one-pattern ");
    hold(viewer.command().contains(&area), viewer.command())?;
    viewer.lamps[0].radius = None;
    let hard = picture(&viewer, &mut renderer)?;
    let differing = pixels.iter().filter(|(at, ..)| (sum(&hard, *at) - sum(&soft, *at)).abs() > 20).count();
    hold(differing > 60, format!("only {differing} pixels are softer than with a point"))
}

fn spots() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::moebius, [320, 240])?;
    viewer.lamps.truncate(1);
    viewer.options.shadows = false;
    let bounds = viewer.bounds();
    viewer.lamps[0].set_spot(true, &bounds);
    let aimed = viewer.lamps[0].clone();
    viewer.lamps[0].cone = Some((Vec3::Y, 0.1));
    let ambient = picture(&viewer, &mut renderer)?;
    viewer.lamps[0] = aimed;
    let check = |viewer: &Viewer, picture: &Picture| {
        let (LampKind::Point(from), Some((axis, angle))) = (viewer.lamps[0].kind, viewer.lamps[0].cone) else {
            return Err("it is no spot".to_owned());
        };
        let (mut wrong, mut counts) = (0, [0; 2]);
        for (at, point, _) in ground(viewer, &[], &[[0.0; 2]])? {
            let away = (point - from).normalize().angle_between(axis);
            let is_lit = away < 0.7 * angle;
            // Farther away the ground fades into what is behind it.
            let is_far = point.distance(bounds.centre()) > bounds.extent();
            if is_far || (0.7 * angle..1.02 * angle).contains(&away) {
                continue;
            }
            counts[usize::from(is_lit)] += 1;
            wrong += usize::from((sum(picture, at) > sum(&ambient, at) + 6) != is_lit);
        }
        println!("{wrong} wrong of {counts:?}");
        hold(wrong == 0 && counts.iter().all(|&count| count > 100), format!("{wrong} wrong of {counts:?}"))
    };
    let before = picture(&viewer, &mut renderer)?;
    check(&viewer, &before)?;
    let target = viewer.lamps[0].target(&bounds).ok_or("a spot has a target")?;
    let from = viewer.camera().project(target).ok_or("the target is behind the eye")?;
    drag(&mut viewer, from, from + Vec2::new(70.0, 20.0), Modifiers::default());
    let after = picture(&viewer, &mut renderer)?;
    hold(after != before && viewer.lamps[0].target(&bounds) != Some(target), "the target was not dragged")?;
    check(&viewer, &after)?;
    // The light itself moves, and stays aimed.
    let target = viewer.lamps[0].target(&bounds).ok_or("a spot has a target")?;
    viewer.handle(Event::Acted(Action::LightLeft));
    let (LampKind::Point(from), Some((axis, _))) = (viewer.lamps[0].kind, viewer.lamps[0].cone) else {
        return Err("it is no spot".into());
    };
    hold((target - from).normalize().distance(axis) < 1e-5, "the spot is not aimed where it was")
}

/// The picture with the ground in ambient light only: the light shines from below it, as brightly.
fn ambient_only(viewer: &mut Viewer, renderer: &mut Renderer) -> Result<Picture, String> {
    let lamp = viewer.lamps[0].clone();
    let at = lamp.handle(&viewer.bounds());
    viewer.lamps[0].kind = LampKind::Point(at.with_y(2.0 * viewer.ground() - at.y));
    let picture = picture(viewer, renderer);
    viewer.lamps[0] = lamp;
    picture
}

fn a_still_viewer_draws_nothing() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::moebius, [160, 120])?;
    hold(renderer.draw(&viewer).map_err(say)?, "the first picture was not drawn")?;
    // Faces, their normals and slots, positions; light, depth and picture.
    let (report, bytes) = (viewer.bodies[0].report(), renderer.counters().bytes);
    let least = (12 + 12 + 4) * report.faces + 12 * report.vertices + 20 * 160 * 120;
    hold(bytes >= least as u64, format!("{bytes} bytes are counted of {least} and more"))?;
    for event in [Event::Moved([10.0, 10.0]), Event::Released, Event::Passed(1.0), Event::Acted(Action::Boxes)] {
        let text = format!("{event:?}");
        viewer.handle(event);
        hold(!renderer.is_stale(&viewer) && !renderer.draw(&viewer).map_err(say)?, format!("{text} drew a picture"))?;
    }
    hold(renderer.pictures() == 1, "more than one picture was drawn")?;
    viewer.handle(Event::Acted(Action::TurnLeft));
    hold(renderer.draw(&viewer).map_err(say)?, "turning drew no picture")
}

/// On a software device, which that of the tests is said to be.
fn a_moving_picture_is_coarse() -> Outcome {
    // With odd numbers the last row and column reach over the border.
    [[520, 512], [521, 513]].into_iter().try_for_each(coarse_and_full)
}

fn coarse_and_full(size: [u32; 2]) -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::still_life, size)?;
    viewer.options.samples = 1;
    let coarse = picture(&viewer, &mut renderer)?;
    let half = size.map(|side| side.div_ceil(2));
    hold(coarse.size == half && renderer.step() == 2, format!("{:?}", coarse.size))?;
    hold(renderer.is_coarse(&viewer) && !renderer.is_stale(&viewer), "it does not stay for refinement")?;
    renderer.refine(&viewer).map_err(say)?;
    let full = picture(&viewer, &mut renderer)?;
    hold(full.size == size && renderer.step() == 1, format!("{:?}", full.size))?;
    hold(!renderer.is_coarse(&viewer) && renderer.pictures() == 2, "it was not refined once")?;
    // Four pixels of the full picture against one, which may be mirrored.
    let differing = |is_mirrored: bool| {
        let pixels = (0..256).flat_map(|y| (0..260).map(move |x| [x, y]));
        let is_other = |&[x, y]: &[u32; 2]| {
            let four = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| sum(&full, [2 * x + i, 2 * y + j]));
            let at = [if is_mirrored { 259 - x } else { x }, y];
            (four.iter().sum::<i32>() - 4 * sum(&coarse, at)).abs() > 400
        };
        pixels.filter(is_other).count()
    };
    let (differing, mirrored) = (differing(false), differing(true));
    println!("{size:?}: {differing} pixels differ, {mirrored} mirrored");
    hold(differing < 2000, format!("{differing} pixels differ"))?;
    hold(mirrored > 2000, format!("negative control: {mirrored} pixels differ"))?;
    viewer.handle(Event::Acted(Action::TurnLeft));
    hold(renderer.draw(&viewer).map_err(say)? && renderer.step() == 2, "it is not coarse when it moves again")
}

fn a_failure_leaves_the_last_picture() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::still_life, [160, 120])?;
    let before = picture(&viewer, &mut renderer)?;
    viewer.handle(Event::Resized([120, 200]));
    viewer.lamps[0].kind = LampKind::Point(Vec3::NAN);
    hold(renderer.draw(&viewer).is_err(), "a light that is nowhere was drawn")?;
    let after = renderer.read().ok_or("the picture is gone")?;
    hold(finish(&renderer, after)? == before, "a failure changed the picture")?;
    let mut first = Renderer::new(gpu()?).map_err(say)?;
    hold(first.draw(&viewer).is_err() && first.texture().is_none(), "a picture that was not drawn is shown")
}

fn switches_change_no_picture() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::still_life, [240, 160])?;
    let before = picture(&viewer, &mut renderer)?;
    let same = |viewer: &Viewer, renderer: &mut _, what: &str| {
        let now = picture(viewer, renderer)?;
        let differing = now.pixels.iter().zip(&before.pixels).filter(|(a, b)| a != b).count();
        hold(differing == 0, format!("{what}: {differing} pixels differ"))
    };
    for counting in [Counting::ZpPlus, Counting::ZFail, Counting::Auto] {
        viewer.options.counting = counting;
        same(&viewer, &mut renderer, &format!("{counting:?}"))?;
    }
    let all = Skipping::default();
    for (skipping, what) in [
        (Skipping { range: false, ..all }, "range"),
        (Skipping { view: false, ..all }, "view"),
        (Skipping { receivers: false, ..all }, "receivers"),
        (Skipping { casters: false, ..all }, "casters"),
        (Skipping { bits: false, ..all }, "bits"),
        (Skipping { lists: false, ..all }, "lists"),
        (Skipping { faces: false, ..all }, "faces"),
    ] {
        viewer.options.skipping = skipping;
        same(&viewer, &mut renderer, what)?;
    }
    // Shadows end behind what is seen.
    for receivers in [true, false] {
        viewer.options.skipping = Skipping { receivers, ..all };
        // The first picture of a scene is drawn without their depth.
        for action in [Action::TurnLeft, Action::TurnRight] {
            viewer.handle(Event::Acted(action));
            picture(&viewer, &mut renderer)?;
            renderer.poll();
        }
        let ended = renderer.counters().shadow.map(|shadow| shadow.ended);
        hold(ended.is_some_and(|ended| (ended > 0) == receivers), format!("{receivers}: {ended:?} end"))?;
    }
    Ok(())
}

fn casters_that_are_not_needed() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::walking_figure, [160, 120])?;
    // The eye looks away from the figure, with the light between them: the shadow falls behind the figure.
    let (bounds, [_, _, forward]) = (viewer.bounds(), viewer.orbit.axes());
    viewer.lamps.truncate(1);
    viewer.lamps[0].kind = LampKind::Point(bounds.centre() + 3.0 * bounds.extent() * forward);
    viewer.orbit.target += 50.0 * bounds.extent() * forward;
    let mut pictures = Vec::new();
    for casters in [true, false] {
        viewer.options.skipping.casters = casters;
        // The counters that arrive may be of the picture before.
        for action in [Action::TurnLeft, Action::TurnRight] {
            viewer.handle(Event::Acted(action));
            pictures.push(picture(&viewer, &mut renderer)?);
            renderer.poll();
        }
        let culled = renderer.counters().scene.map(|scene| scene.culled_casters);
        hold(culled.is_some_and(|culled| (culled > 0) == casters), format!("{casters}: {culled:?} are culled"))?;
    }
    hold(pictures[1] == pictures[3], "a caster that is not needed changes the picture")
}

fn overlays_change_the_picture() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::moebius, [240, 160])?;
    let before = picture(&viewer, &mut renderer)?;
    for action in [
        Action::Silhouettes,
        Action::LightSilhouettes,
        Action::Volumes,
        Action::Caps,
        Action::Boundary,
        Action::NonManifold,
        Action::Clusters,
        Action::Receivers,
        Action::Ground,
        Action::Shadows,
        Action::Smooth,
        Action::NextMode,
    ] {
        viewer.handle(Event::Acted(action));
        let now = picture(&viewer, &mut renderer)?;
        hold(now != before, format!("{action:?} changed nothing"))?;
        viewer.handle(Event::Acted(action));
        if action != Action::NextMode {
            hold(picture(&viewer, &mut renderer)? == before, format!("{action:?} did not go back"))?;
        }
    }
    viewer.options.mode = Mode::default();
    // All is certain from here, but not in the plane of faces.
    viewer.handle(Event::Acted(Action::Exact));
    hold(picture(&viewer, &mut renderer)? == before, "faces are marked that f32 decides")?;
    let corner = Vec3::from(viewer.bodies[0].positions(0.0).map_err(say)?[40]);
    let was = std::mem::replace(&mut viewer.lamps[0].kind, LampKind::Point(corner));
    let marked = picture(&viewer, &mut renderer)?;
    viewer.handle(Event::Acted(Action::Exact));
    hold(picture(&viewer, &mut renderer)? != marked, "faces that meet at the light are not marked")?;
    viewer.lamps[0].kind = was;
    for (mode, name) in Mode::ALL {
        viewer.options.mode = mode;
        let now = picture(&viewer, &mut renderer)?;
        hold((now == before) == (mode == Mode::Additive), name)?;
    }
    Ok(())
}

fn creases() -> Outcome {
    // The still life has a block.
    let (mut viewer, mut renderer) = viewer(scenes::still_life, [240, 160])?;
    let before = picture(&viewer, &mut renderer)?;
    viewer.handle(Event::Acted(Action::Creases));
    let now = picture(&viewer, &mut renderer)?;
    let changed = now.pixels.iter().zip(&before.pixels).filter(|(a, b)| a != b).count();
    hold((30..4000).contains(&changed), format!("creases change {changed} pixels"))?;
    viewer.handle(Event::Acted(Action::Creases));
    hold(picture(&viewer, &mut renderer)? == before, "creases did not go back")
}

fn clusters_anew() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::walking_figure, [240, 160])?;
    // Volumes of a renderer's first frame end elsewhere than later ones, so a pixel at a border may differ.
    viewer.options.shadows = false;
    // The other edges stay.
    viewer.handle(Event::Acted(Action::Silhouettes));
    for _ in 0..2 {
        viewer.handle(Event::Acted(Action::Clusters));
        picture(&viewer, &mut renderer)?;
    }
    viewer.clock.seconds = 0.4 * viewer.duration();
    viewer.handle(Event::Acted(Action::Clusters));
    let expected = picture(&viewer, &mut Renderer::new(gpu()?).map_err(say)?)?;
    hold(picture(&viewer, &mut renderer)? == expected, "clusters are those of the pose before")
}

/// A block with cameras.
struct Filmed(rimline::Model, Vec<SceneCamera>);

impl Source for Filmed {
    fn model(&self) -> &rimline::Model {
        &self.0
    }

    fn pose(&self, _: Option<usize>, _: f32) -> Result<rimline::Pose, BodyError> {
        rest()
    }

    fn cameras(&self) -> Vec<SceneCamera> {
        self.1.clone()
    }
}

fn cameras() -> Outcome {
    let model = block()?;
    let (eye, forward) = (Vec3::new(3.0, 4.0, 5.0), Vec3::new(-3.0, -3.5, -5.0).normalize());
    let up = Vec3::Y.reject_from_normalized(forward).normalize();
    let of = |name: Option<&str>, projection| SceneCamera {
        name: name.map(str::to_owned),
        eye: eye.into(),
        forward: forward.into(),
        up: up.into(),
        projection,
    };
    let perspective = CameraProjection::Perspective { yfov: 0.5, aspect_ratio: None, znear: 0.1, zfar: None };
    let parallel = CameraProjection::Orthographic { xmag: 2.0, ymag: 1.5, znear: 0.0, zfar: 50.0 };
    let cameras = vec![of(Some("door"), perspective), of(None, parallel)];
    let mut viewer = Viewer::new(vec![Body::new("block", None, Filmed(model, cameras)).map_err(say)?]);
    viewer.handle(Event::Resized([200, 150]));
    let names: Vec<String> = viewer.cameras().into_iter().map(|(name, _)| name).collect();
    hold(names == ["door", "camera 1"], format!("{names:?}"))?;
    viewer.handle(Event::Acted(Action::NextCamera));
    let camera = viewer.camera();
    hold(camera.view.eye.distance(eye) < 1e-4 && camera.view.forward.distance(forward) < 1e-4, format!("{camera:?}"))?;
    hold(
        camera.view.up.distance(up) < 1e-4 && (viewer.orbit.fov - 0.5_f32.to_degrees()).abs() < 1e-3,
        format!("{camera:?}"),
    )?;
    // A point at the upper border of what the parallel camera sees, beside what it looks at.
    viewer.handle(Event::Acted(Action::NextCamera));
    let target = viewer.orbit.target;
    let border = viewer.camera().project(target + 1.5 * up).ok_or("the border is behind the eye")?;
    hold(border.y.abs() < 0.5 && (border.x - 100.0).abs() < 0.1, format!("{border}"))?;
    viewer.handle(Event::Acted(Action::NextCamera));
    hold(viewer.camera().view.eye.distance(eye) < 1e-4, "after the last camera comes the first")
}

fn base_colors() -> Outcome {
    let ply = |colors: [&str; 4]| {
        let [a, b, c, d] = colors;
        let axes = ["x", "y", "z"].map(|axis| format!("property float {axis}\n")).concat();
        let channels = ["red", "green", "blue"].map(|channel| format!("property uchar {channel}\n")).concat();
        let vertices = format!("0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n0 0 1 {d}\n");
        let faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
        let header =
            format!("element vertex 4\n{axes}{channels}element face 4\nproperty list uchar int vertex_index\n");
        format!("ply\nformat ascii 1.0\n{header}end_header\n{vertices}{faces}")
    };
    let viewer = |colors| {
        let file = read_bytes(ply(colors).as_bytes(), None, &ReadOptions::default()).map_err(say)?;
        let mut viewer = Viewer::new(vec![Body::new("tetrahedron", None, file).map_err(say)?]);
        viewer.handle(Event::Resized([240, 160]));
        Ok::<_, String>(viewer)
    };
    let mut renderer = Renderer::new(gpu()?).map_err(say)?;
    let is_red = |pixel: &&[u8; 4]| pixel[0] > 100 && pixel[1] < 50 && pixel[2] < 50;
    let mut clay = None;
    for (color, is_colored) in [("255 255 255", false), ("255 0 0", true)] {
        let mut viewer = viewer([color; 4])?;
        let red = picture(&viewer, &mut renderer)?.pixels.iter().filter(is_red).count();
        hold((red > 500) == is_colored && (red == 0) != is_colored, format!("{color}: {red} pixels are red"))?;
        viewer.handle(Event::Acted(Action::Colors));
        let plain = picture(&viewer, &mut renderer)?;
        hold(clay.replace(plain.clone()).is_none_or(|clay| clay == plain), "it is not of clay")?;
        hold(viewer.command().contains("--plain"), viewer.command())?;
    }
    Ok(())
}

fn scenes_are_drawn() -> Outcome {
    for (name, make) in scenes::ALL {
        let (mut viewer, mut renderer) = viewer(make, [320, 200])?;
        let first = picture(&viewer, &mut renderer)?;
        viewer.clock.is_running = true;
        viewer.handle(Event::Passed(0.3));
        let later = picture(&viewer, &mut renderer)?;
        hold((first == later) == (viewer.duration() == 0.0), format!("{name}: animation"))?;
        let colors: std::collections::HashSet<_> = first.pixels.iter().collect();
        hold(colors.len() > 500, format!("{name} has {} colours", colors.len()))?;
    }
    Ok(())
}

fn screenshots() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::walking_figure, [200, 140])?;
    viewer.options.overlays.silhouettes = true;
    let small = picture(&viewer, &mut renderer)?;
    let large = renderer.screenshot(&viewer, 4).map_err(say)?;
    let large = finish(&renderer, large)?;
    hold(large.size == [800, 560], format!("{:?}", large.size))?;
    let mut apart = 0.0;
    for y in 0..140 {
        for x in 0..200 {
            let of = |picture: &Picture, at| f64::from(picture.at(at)[1]);
            apart += (of(&small, [x, y]) - of(&large, [4 * x + 2, 4 * y + 2])).abs();
        }
    }
    hold(apart / 28_000.0 < 4.0, format!("{} apart", apart / 28_000.0))?;
    hold(!renderer.is_stale(&viewer), "the screenshot changed the picture")?;
    let huge = renderer.screenshot(&viewer, 1000).err().map(|error| error.to_string()).unwrap_or_default();
    hold(huge.contains("too large"), huge)
}

fn lights_come_and_go() -> Outcome {
    let (mut viewer, mut renderer) = viewer(scenes::still_life, [160, 120])?;
    let before = picture(&viewer, &mut renderer)?;
    for _ in 0..7 {
        viewer.handle(Event::Acted(Action::AddLight));
        picture(&viewer, &mut renderer)?;
    }
    hold(viewer.lamps.len() == 8 && viewer.message.is_some(), "there may be eight lights")?;
    viewer.handle(Event::Acted(Action::ChangeLightKind));
    let direction = picture(&viewer, &mut renderer)?;
    viewer.handle(Event::Acted(Action::SwitchLight));
    hold(picture(&viewer, &mut renderer)? != direction, "a light off changes nothing")?;
    for _ in 0..5 {
        viewer.handle(Event::Acted(Action::RemoveLight));
        picture(&viewer, &mut renderer)?;
    }
    hold(viewer.lamps.len() == 3 && picture(&viewer, &mut renderer)? == before, "the first lights are not as before")?;
    for _ in 0..3 {
        viewer.handle(Event::Acted(Action::RemoveLight));
    }
    picture(&viewer, &mut renderer)?;
    hold(viewer.lamps.is_empty() && viewer.selected.is_none(), "a light is left")
}
