//! Boxes of poses hold what deforming makes of every vertex, in `f64` and in `f32`.

use rimline::cpu::{self, Threads};
use rimline::model::Box3;
use rimline::{
    Geometry, GeometryOptions, Influences, Instance, InstancePose, Matrix3x4, Model, ModelBounds, ModelError, Pose,
};
use rimline_testkit::is_long;
use rimline_testkit::models::{bending_tube, random_matrix, random_model, random_pose};
use rimline_testkit::on_gpu::text;
use rimline_testkit::poser::{self, within_boxes};
use rimline_testkit::random::Random;

const IDENTITY: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Checks the boxes of a pose against the poser, which shares no code, and against the stage's CPU reference.
fn check_pose(model: &Model, pose: &Pose) -> Result<Vec<Option<Box3>>, String> {
    let boxes = ModelBounds::new(model).boxes(pose, 0.0).map_err(text)?;
    let exact: Vec<[f64; 3]> = poser::of_model(model, pose).iter().map(|posed| posed.position).collect();
    within_boxes(model, &boxes, &exact)?;
    within_boxes(model, &boxes, &cpu::deform(model, pose, 0.0, None, Threads::ONE).map_err(text)?)?;
    Ok(boxes)
}

fn skinned(positions: &[[f32; 3]], influences: &[&[(u32, f32)]], morph_targets: Vec<Vec<[f32; 3]>>) -> Model {
    let mut offsets = vec![0];
    offsets.extend(influences.iter().scan(0, |end, of_vertex| {
        *end += of_vertex.len() as u32;
        Some(*end)
    }));
    let (joints, weights) = influences.iter().flat_map(|of_vertex| of_vertex.iter().copied()).unzip();
    let influences = Some(Influences::new(offsets, joints, weights).expect("they go together"));
    let options = GeometryOptions { influences, morph_targets, ..GeometryOptions::default() };
    let geometry = Geometry::new(positions.to_vec(), Vec::new(), options).expect("an offset a vertex");
    Model::new(vec![geometry], vec![Instance::new(0, None)]).expect("one geometry")
}

fn pose_of(palette: Vec<Matrix3x4>, weights: Vec<f32>) -> Pose {
    Pose::new(vec![InstancePose::new(palette, weights).expect("all is finite")])
}

/// Weights of any sign and sum, vertices without joints, morph targets of any weight.
#[test]
fn boxes_hold_random_poses() {
    let seeds = 8101..if is_long() { 8401 } else { 8121 };
    println!("seeds {seeds:?}");
    for seed in seeds {
        let mut random = Random::new(seed);
        let model = random_model(&mut random, [60, 4, 256, 31][seed as usize % 4]);
        for _ in 0..5 {
            let pose = random_pose(&mut random, &model);
            let mut boxes = check_pose(&model, &pose).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            let positions = cpu::deform(&model, &pose, 0.0, None, Threads::ONE).expect("it fits");
            // Negative control: a box that ends before the last vertex.
            let of_tube = &positions[..model.geometries()[3].positions().len()];
            let last = of_tube.iter().fold(f32::MIN, |last, position| last.max(position[1]));
            boxes[0].as_mut().expect("a box")[1][1] = last.next_down();
            assert!(within_boxes(&model, &boxes, &positions).is_err(), "seed {seed}: a box without a vertex holds all");
        }
    }
}

/// Few vertices far from where matrices take them: what a sum loses to rounding is more than a unit of the result.
#[test]
fn boxes_hold_what_is_lost_to_cancellation() {
    let seeds = 8501..if is_long() { 28501 } else { 10501 };
    println!("seeds {seeds:?}");
    let mut outside = 0;
    for seed in seeds {
        let mut random = Random::new(seed);
        let far = 10.0_f32.powi(random.below(7) as i32);
        let position = random.direction().map(|c| far * c);
        let count = 1 + random.below(4);
        let mut palette: Vec<Matrix3x4> = (0..count).map(|_| random_matrix(&mut random)).collect();
        for row in palette.iter_mut().flatten() {
            let [x, y, z, _] = *row;
            row[3] = random.between(-1.0, 1.0) - (x * position[0] + y * position[1] + z * position[2]);
        }
        let influences: Vec<(u32, f32)> = (0..count as u32).map(|joint| (joint, random.between(-0.5, 1.5))).collect();
        let model = skinned(&[position], &[&influences], vec![vec![random.direction()]; 2]);
        let pose = pose_of(palette, vec![random.between(-2.0, 2.0), 0.0]);
        check_pose(&model, &pose).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let exact = poser::of_model(&model, &pose)[0].position;
        let found = cpu::deform(&model, &pose, 0.0, None, Threads::ONE).expect("it fits")[0];
        let is_off = |axis: usize| {
            let nearest = exact[axis] as f32;
            found[axis] < nearest.next_down().next_down() || found[axis] > nearest.next_up().next_up()
        };
        outside += usize::from((0..3).any(is_off));
    }
    assert!(outside > 500, "rounding matters in {outside} cases only");
}

/// A tube that bends leaves the box of its rest pose, at any transform. Its own boxes hold it, and are not much larger.
#[test]
fn the_box_at_rest_does_not_hold_a_pose() {
    let (model, pose) = bending_tube();
    let joints = model.geometries()[0].joints_needed();
    let rest = pose_of(vec![IDENTITY; joints], Vec::new());
    let [at_rest] = check_pose(&model, &rest).expect("held")[..] else { panic!("one instance") };
    let (mut left, mut sizes) = (0, Vec::new());
    for step in 0..40 {
        let pose = pose(step as f32 * 0.3);
        let boxes = check_pose(&model, &pose).unwrap_or_else(|error| panic!("step {step}: {error}"));
        let positions = cpu::deform(&model, &pose, 0.0, None, Threads::ONE).expect("it fits");
        left += usize::from(within_boxes(&model, &[at_rest], &positions).is_err());
        let [low, high] = boxes[0].expect("a box");
        let extent = |axis: usize| {
            let of = |pick: fn(f32, f32) -> f32, from| positions.iter().fold(from, |c, p| pick(c, p[axis]));
            of(f32::max, f32::MIN) - of(f32::min, f32::MAX)
        };
        sizes.extend((0..3).map(|axis| (high[axis] - low[axis]) / extent(axis)));
    }
    assert_eq!(left, 40, "poses that leave the box at rest");
    let largest = sizes.iter().copied().fold(0.0, f32::max);
    assert!(largest < 2.0, "a box is {largest} times as long as the tube");
}

/// Weights that do not sum to one scale about the origin of the world, and negative ones reach beyond all joints.
#[test]
fn weights_of_any_sum_are_heeded() {
    let far = |x: f32| [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let points = [[0.0; 3]; 2];
    let of = |weights: &[&[(u32, f32)]], palette: &[f32]| {
        let model = skinned(&points, weights, Vec::new());
        let pose = pose_of(palette.iter().map(|&x| far(x)).collect(), Vec::new());
        check_pose(&model, &pose).expect("held")[0].expect("a box")
    };
    let near = |found: Box3, low: f32, high: f32| {
        let [found_low, found_high] = found.map(|[x, _, _]| x);
        assert!((found_low - low).abs() < 1e-3 && (found_high - high).abs() < 1e-3, "{found:?}, not {low} to {high}");
    };
    near(of(&[&[(0, 1.0)], &[(0, 0.5), (1, 0.5)]], &[100.0, 104.0]), 100.0, 104.0);
    near(of(&[&[(0, 1.0)], &[(0, 0.25)]], &[100.0]), 25.0, 100.0);
    near(of(&[&[(0, 1.5)], &[]], &[100.0]), 0.0, 150.0);
    // 2 · 100 − 104.
    near(of(&[&[(0, 2.0), (1, -1.0)], &[(0, 1.0)]], &[100.0, 104.0]), 96.0, 108.0);
    near(of(&[&[(0, -1.0)], &[(0, 1.0)]], &[100.0]), -100.0, 100.0);
    near(of(&[&[(0, 0.0)], &[]], &[100.0]), 0.0, 0.0);
    // A joint with no weight does not matter, wherever it is.
    near(of(&[&[(0, 1.0), (1, 0.0)], &[(0, 1.0)]], &[100.0, 1e6]), 100.0, 100.0);
}

#[test]
fn morph_targets_and_displacements_widen() {
    let morph_targets = vec![vec![[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[f32::NAN; 3]; 2]];
    let model = skinned(&[[0.0; 3]; 2], &[&[(0, 1.0)], &[(0, 1.0)]], morph_targets);
    let bounds = ModelBounds::new(&model);
    let of = |weights: Vec<f32>, by: f32| bounds.boxes(&pose_of(vec![IDENTITY], weights), by).expect("it fits")[0];
    let [low, high] = of(vec![-3.0, 0.0], 0.0).expect("a box");
    assert!(
        low[0] <= -3.0 && low[0] > -3.001 && low[1] <= -6.0 && low[1] > -6.001 && high[0] < 1e-3,
        "{low:?} {high:?}"
    );
    let [low, high] = of(vec![0.0, 0.0], 0.5).expect("a box");
    assert!(low.iter().all(|c| (-0.501..=-0.5).contains(c)) && high.iter().all(|c| (0.5..=0.501).contains(c)));
    // A NaN target with a weight other than 0 gives no box, and neither does an invalid displacement.
    assert_eq!(of(vec![0.0, 1e-30], 0.0), None);
    for by in [f32::INFINITY, f32::NAN, -1.0] {
        assert_eq!(of(vec![0.0, 0.0], by), None, "{by}");
    }
}

#[test]
fn what_may_overflow_or_is_not_finite_has_no_box() {
    let scale = |x: f32| [[x, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let of = |x: f32, factor: f32, weight: f32| {
        let model = skinned(&[[x, 0.0, 0.0]], &[&[(0, weight), (1, 0.0)]], Vec::new());
        ModelBounds::new(&model).boxes(&pose_of(vec![scale(factor), IDENTITY], Vec::new()), 0.0).expect("it fits")[0]
    };
    assert!(of(1e9, 1e9, 1.0).is_some());
    for (x, factor, weight) in [(1e20, 1e20, 1.0), (1e9, 1e9, 1e22), (f32::NAN, 1.0, 1.0), (f32::INFINITY, 1.0, 0.0)] {
        assert_eq!(of(x, factor, weight), None, "{x} {factor} {weight}");
    }
    // Joints that move nothing may overflow, too, and zero times infinity is no number.
    let model = skinned(&[[1e20, 0.0, 0.0]], &[&[(0, 1.0), (1, 0.0)]], Vec::new());
    let boxes = ModelBounds::new(&model).boxes(&pose_of(vec![IDENTITY, scale(1e20)], Vec::new()), 0.0);
    assert_eq!(boxes, Ok(vec![None]));
    let none = Model::new(vec![Geometry::default()], vec![Instance::new(0, None)]).expect("one geometry");
    assert_eq!(ModelBounds::new(&none).boxes(&pose_of(vec![IDENTITY], Vec::new()), 0.0), Ok(vec![None]));
}

#[test]
fn poses_that_do_not_fit_are_refused() {
    let model = skinned(&[[0.0; 3]], &[&[(2, 1.0)]], vec![vec![[0.0; 3]]; 2]);
    let of = |pose: &Pose| ModelBounds::new(&model).boxes(pose, 0.0).err();
    let few = ModelError::PosePalette { instance: 0, given: 2, needed: 3 };
    let other = ModelError::PoseMorphWeights { instance: 0, given: 3, needed: 2 };
    assert_eq!(of(&Pose::new(Vec::new())), Some(ModelError::PoseInstances { given: 0, needed: 1 }));
    assert_eq!(of(&pose_of(vec![IDENTITY; 2], vec![0.0; 2])), Some(few));
    assert_eq!(of(&pose_of(vec![IDENTITY; 3], vec![0.0; 3])), Some(other));
    assert_eq!(of(&pose_of(vec![IDENTITY; 3], vec![0.0; 2])), None);
}
