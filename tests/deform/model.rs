//! Models, poses and their parts are checked when they are made, and each refusal names the part.

use rimline::internals::cpu::{self, Threads};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{Geometry, GeometryOptions, Influences, Instance, InstancePose, Model, ModelError, Pose};

const POSITIONS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
const MIRRORED: [[f32; 4]; 3] = [[-1.0, 0.0, 0.0, 5.0], IDENTITY[1], IDENTITY[2]];

fn geometry(faces: &[[u32; 3]], options: GeometryOptions) -> Result<Geometry, ModelError> {
    Geometry::new(POSITIONS.to_vec(), faces.to_vec(), options)
}

/// So many instances of one triangle.
fn triangles(count: usize) -> Model {
    let triangle = geometry(&[[0, 1, 2]], GeometryOptions::default()).expect("a triangle");
    Model::new(vec![triangle], vec![Instance::new(0, None); count]).expect("one geometry")
}

fn posed(palette: &[[[f32; 4]; 3]]) -> InstancePose {
    InstancePose::new(palette.to_vec(), Vec::new()).expect("finite")
}

/// The error is this one, and its message holds all of `words`. NaN equals itself.
#[track_caller]
fn refused<T: std::fmt::Debug>(made: Result<T, ModelError>, expected: ModelError, words: &[&str]) {
    let error = made.expect_err("refused");
    assert_eq!(format!("{error:?}"), format!("{expected:?}"));
    let message = error.to_string();
    assert!(words.iter().all(|word| message.contains(word)), "{message:?} lacks one of {words:?}");
}

#[test]
fn each_part_names_what_is_wrong() {
    let plain = GeometryOptions::default;
    refused(
        geometry(&[[0, 1, 2], [2, 3, 0]], plain()),
        ModelError::FaceIndex { face: 1, corner: 1, index: 3, vertices: 3 },
        &["face 1", "vertex 3", "corner 1", "3 vertices"],
    );
    let morph_targets = vec![vec![[0.0; 3]; 3], vec![[0.0; 3]; 2]];
    refused(
        geometry(&[], GeometryOptions { morph_targets, ..plain() }),
        ModelError::MorphTarget { target: 1, given: 2, vertices: 3 },
        &["target 1", "2 offsets"],
    );
    refused(
        geometry(&[], GeometryOptions { source_vertices: Some(vec![0; 4]), ..plain() }),
        ModelError::SourceVertices { given: 4, vertices: 3 },
        &["4 source vertices"],
    );
    let influences = Some(Influences::new(vec![0, 1, 1], vec![0], vec![1.0]).expect("two vertices"));
    refused(
        geometry(&[], GeometryOptions { influences, ..plain() }),
        ModelError::InfluencedVertices { given: 2, vertices: 3 },
        &["2 vertices"],
    );
    let influences = |offsets: &[u32], joints: &[u32], weights: &[f32]| {
        Influences::new(offsets.to_vec(), joints.to_vec(), weights.to_vec())
    };
    refused(influences(&[], &[], &[]), ModelError::FirstOffset { found: None }, &["begin with 0"]);
    refused(influences(&[1, 1], &[0], &[1.0]), ModelError::FirstOffset { found: Some(1) }, &["Some(1)"]);
    refused(
        influences(&[0, 2, 1], &[0], &[1.0]),
        ModelError::FallingOffset { vertex: 1, begin: 2, end: 1 },
        &["vertex 1", "2", "1"],
    );
    refused(
        influences(&[0, 1], &[0, 1], &[1.0, 0.0]),
        ModelError::LastOffset { found: 1, joints: 2 },
        &["is 1", "2 joints"],
    );
    refused(
        influences(&[0, 1], &[0], &[]),
        ModelError::InfluenceWeights { joints: 1, weights: 0 },
        &["1 joints", "0 weights"],
    );
    for weight in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        refused(
            influences(&[0, 2, 2, 3], &[5, 6, 7], &[1.0, 0.0, weight]),
            ModelError::InfluenceWeight { vertex: 2, joint: 7, weight },
            &["vertex 2", "joint 7", "finite"],
        );
    }
    refused(
        Model::new(vec![Geometry::default()], vec![Instance::new(0, None), Instance::new(1, Some("b".to_owned()))]),
        ModelError::InstanceGeometry { instance: 1, geometry: 1, geometries: 1 },
        &["instance 1", "geometry 1", "has 1"],
    );
    // More vertices than indices can name, without the memory for them: many instances of one geometry.
    let large = Geometry::new(vec![[0.0; 3]; 1 << 17], Vec::new(), plain()).expect("positions alone");
    let many = |count| Model::new(vec![large.clone()], vec![Instance::new(0, None); count]);
    refused(many(1 << 15), ModelError::TooManyVertices { vertices: 1 << 32 }, &["4294967296", "split"]);
    assert!(many((1 << 15) - 1).is_ok());
    for (row, column, value) in [(0, 0, f32::NAN), (2, 3, f32::INFINITY), (1, 2, f32::NEG_INFINITY)] {
        let mut palette = vec![IDENTITY; 3];
        palette[1][row][column] = value;
        let error = ModelError::Matrix { joint: 1, row, column, value };
        let words = [&format!("row {row}")[..], &format!("column {column}"), "matrix 1"];
        refused(InstancePose::new(palette, Vec::new()), error, &words);
    }
    let error = ModelError::MorphWeight { target: 2, weight: f32::NAN };
    refused(InstancePose::new(vec![IDENTITY], vec![1e30, -2.0, f32::NAN]), error, &["target 2", "NaN"]);
}

#[test]
fn what_is_given_is_what_is_there() {
    let influences = Influences::new(vec![0, 2, 2, 3], vec![4, 0, 1], vec![0.5, -0.5, 2.0]).expect("they go together");
    let ranges = [0, 1, 2, 3, usize::MAX].map(|vertex| influences.range(vertex));
    assert_eq!((ranges, influences.most_per_vertex()), ([0..2, 2..2, 2..3, 0..0, 0..0], 2));
    let options = GeometryOptions {
        name: Some("a".to_owned()),
        morph_targets: vec![vec![[f32::NAN; 3]; 3]],
        influences: Some(influences.clone()),
        source_vertices: Some(vec![7, 7, 9]),
    };
    let made = geometry(&[[0, 1, 2], [1, 1, 0]], options).expect("one entry a vertex");
    assert_eq!((made.name(), made.positions(), made.faces().len()), (Some("a"), &POSITIONS[..], 2));
    assert_eq!((made.morph_targets().len(), made.influences(), made.joints_needed()), (1, Some(&influences), 5));
    assert_eq!(made.source_vertices(), [7, 7, 9]);
    let model = triangles(2);
    assert_eq!((model.geometries()[0].source_vertices(), model.geometries()[0].joints_needed()), (&[0, 1, 2][..], 1));
    assert_eq!((model.vertex_count(), model.placed_geometries().len()), (6, 2));
    // Positions may be anything; their faces never face a light.
    let infinite = vec![[f32::INFINITY; 3], [f32::NAN; 3], [0.0; 3]];
    assert!(Geometry::new(infinite, vec![[0, 1, 2]], GeometryOptions::default()).is_ok());
}

#[test]
fn mirroring_matrices_turn_the_faces() {
    let flat = [[0.0; 4], IDENTITY[1], IDENTITY[2]];
    for (palette, is_turned) in [
        (&[IDENTITY][..], false),
        (&[MIRRORED], true),
        (&[flat], false),
        (&[], false),
        (&[MIRRORED, flat, MIRRORED, IDENTITY], true),
        (&[MIRRORED, IDENTITY], false),
    ] {
        assert_eq!(posed(palette).faces_turned(), is_turned, "{palette:?}");
    }
    let faces = |pose: InstancePose| triangles(1).mesh(&Pose::new(vec![pose])).expect("a mesh").faces().to_vec();
    assert_eq!(faces(posed(&[MIRRORED])), [[0, 2, 1]]);
    assert_eq!(faces(posed(&[MIRRORED]).with_faces_turned(false)), [[0, 1, 2]]);
}

#[test]
fn a_placed_pose_is_moved_as_a_whole() {
    let model = triangles(2);
    let rows = [[0.5, 0.0, 0.25, 1.0], [0.0, 2.0, 0.0, -3.0], [0.0, 1.0, 1.5, 0.0]];
    let pose = Pose::new([false, true].map(|turned| posed(&[rows]).with_faces_turned(turned)).to_vec());
    let positions = |pose: &Pose| cpu::deform(&model, pose, 0.0, None, Threads::ONE).expect("it fits");
    // Products and sums of these are exact.
    let at = glam::Affine3A::from_mat3_translation(
        glam::mat3(glam::vec3(-1.0, 0.5, 0.0), glam::vec3(0.0, 2.0, 0.0), glam::vec3(0.25, 0.0, 4.0)),
        glam::vec3(8.0, -4.0, 0.5),
    );
    let placed = pose.placed(at).expect("finite");
    let moved: Vec<_> = positions(&pose).into_iter().map(|p| at.transform_point3(p.into()).to_array()).collect();
    assert_eq!(positions(&placed), moved);
    assert_eq!(placed.instances().iter().map(InstancePose::faces_turned).collect::<Vec<_>>(), [true, false]);
    assert_eq!(pose.placed(glam::Affine3A::IDENTITY).expect("finite"), pose);
    let large = [[f32::MAX, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [f32::MAX, 0.0, 0.0]];
    let error = ModelError::Matrix { joint: 0, row: 0, column: 3, value: f32::INFINITY };
    refused(pose.placed(large), error, &["matrix 0", "inf"]);
}

#[test]
fn meshes_of_poses_that_mirror_otherwise_are_typed_errors() {
    let model = triangles(3);
    let pose = |bits: u32| {
        let of = |bit: u32| posed(&[if bits >> bit & 1 == 1 { MIRRORED } else { IDENTITY }]);
        Pose::new((0..3).map(of).collect())
    };
    for made in 0..8 {
        let mesh = model.mesh(&pose(made)).expect("a mesh");
        for shown in 0..8_u32 {
            let expected = match (made ^ shown).trailing_zeros() {
                instance @ 0..3 => Err(ModelError::Turned { instance: instance as usize }),
                _ => Ok(()),
            };
            assert_eq!(model.check_mesh(&mesh, &pose(shown)), expected, "{made}, {shown}");
            // The check is exact: meshes are equal where it finds nothing.
            let other = model.mesh(&pose(shown)).expect("a mesh");
            assert_eq!(mesh.faces() == other.faces(), expected.is_ok());
        }
    }
    let one = triangles(1).mesh(&Pose::new(vec![posed(&[IDENTITY])])).expect("a mesh");
    let other = rimline::Mesh::from_faces(9, vec![[1, 0, 2], [3, 4, 5], [6, 7, 8]]).expect("a mesh");
    // Polygons that walk all their edges both ways have no triangles.
    let (polygon_loops, loop_sizes) = (&[1; 3][..], &[4; 3][..]);
    let polygons = PolygonLoops { polygon_loops, loop_sizes, loop_corners: &[0, 1, 2, 1].repeat(3) };
    let polygons = rimline::Mesh::from_polygons_by_loop(&[[0.0; 3]; 9], polygons, Weld::Keep).expect("a mesh");
    for mesh in [one, other, polygons] {
        assert_eq!(model.check_mesh(&mesh, &pose(0)), Err(ModelError::OtherMesh));
    }
}

/// A joint of the highest number is no overflow. `stage.rs` has poses of other models.
#[test]
fn a_pose_may_have_joints_that_no_vertex_follows() {
    let made = |joint: u32| {
        let influences = Influences::new(vec![0, 1, 1, 1], vec![joint], vec![1.0]).expect("any joint");
        let options = GeometryOptions { influences: Some(influences), ..GeometryOptions::default() };
        let geometry = geometry(&[[0, 1, 2]], options).expect("a triangle");
        let model = Model::new(vec![geometry], vec![Instance::new(0, None)]).expect("one geometry");
        model.mesh(&Pose::new(vec![posed(&[IDENTITY; 4])])).map(drop)
    };
    assert_eq!(made(2), Ok(()));
    let error = made(u32::MAX).expect_err("too few matrices");
    assert!(matches!(error, ModelError::PosePalette { given: 4, .. }), "{error:?}");
}
