//! Models, poses and their parts are checked when they are made, and each refusal names the part.

use rimline::internals::cpu::{self, Threads};
use rimline::internals::model::{influence_range, most_per_vertex};
use rimline::{
    Geometry, GeometryOptions, Influences, Instance, InstancePose, Mesh, MeshError, Model, ModelError, Pose,
};

const POSITIONS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn geometry(faces: &[[u32; 3]], options: GeometryOptions) -> Result<Geometry, ModelError> {
    Geometry::new(POSITIONS.to_vec(), faces.to_vec(), options)
}

fn triangle() -> Geometry {
    geometry(&[[0, 1, 2]], GeometryOptions::default()).expect("a triangle")
}

/// The error, whose message must hold all of `words`.
fn refused<T: std::fmt::Debug>(made: Result<T, ModelError>, words: &[&str]) -> ModelError {
    let error = made.expect_err("refused");
    let message = error.to_string();
    assert!(words.iter().all(|word| message.contains(word)), "{message:?} lacks one of {words:?}");
    error
}

#[test]
fn a_geometry_names_its_face_target_or_list() {
    let plain = GeometryOptions::default;
    let error = refused(geometry(&[[0, 1, 2], [2, 3, 0]], plain()), &["face 1", "vertex 3", "corner 1", "3 vertices"]);
    assert_eq!(error, ModelError::FaceIndex { face: 1, corner: 1, index: 3, vertices: 3 });
    refused(geometry(&[[0, 1, u32::MAX]], plain()), &["face 0", "4294967295", "corner 2"]);
    refused(Geometry::new(Vec::new(), vec![[0, 0, 0]], plain()), &["face 0", "0 vertices"]);
    let morph_targets = vec![vec![[0.0; 3]; 3], vec![[0.0; 3]; 2]];
    let error = refused(geometry(&[], GeometryOptions { morph_targets, ..plain() }), &["target 1", "2 offsets"]);
    assert_eq!(error, ModelError::MorphTarget { target: 1, given: 2, vertices: 3 });
    let source_vertices = Some(vec![0; 4]);
    let error = refused(geometry(&[], GeometryOptions { source_vertices, ..plain() }), &["4 source vertices"]);
    assert_eq!(error, ModelError::SourceVertices { given: 4, vertices: 3 });
    let influences = Some(Influences::new(vec![0, 1, 1], vec![0], vec![1.0]).expect("two vertices"));
    let error = refused(geometry(&[], GeometryOptions { influences, ..plain() }), &["2 vertices"]);
    assert_eq!(error, ModelError::InfluencedVertices { given: 2, vertices: 3 });
}

#[test]
fn what_is_given_is_what_is_there() {
    let influences = Influences::new(vec![0, 2, 2, 3], vec![4, 0, 1], vec![0.5, -0.5, 2.0]).expect("they go together");
    assert_eq!(
        (influence_range(&influences, 0), influence_range(&influences, 1), influence_range(&influences, 2)),
        (0..2, 2..2, 2..3)
    );
    assert_eq!((influence_range(&influences, 3), influence_range(&influences, usize::MAX)), (0..0, 0..0));
    assert_eq!(most_per_vertex(&influences), 2);
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
    assert_eq!((triangle().source_vertices(), triangle().joints_needed()), (&[0, 1, 2][..], 1));
    // Positions may be anything; their faces never face a light.
    let infinite = vec![[f32::INFINITY; 3], [f32::NAN; 3], [0.0; 3]];
    assert!(Geometry::new(infinite, vec![[0, 1, 2]], GeometryOptions::default()).is_ok());
}

#[test]
fn influences_name_their_vertex_and_joint() {
    let made = |offsets: &[u32], joints: &[u32], weights: &[f32]| {
        Influences::new(offsets.to_vec(), joints.to_vec(), weights.to_vec())
    };
    assert!(made(&[0], &[], &[]).is_ok(), "influences of no vertex");
    assert_eq!(refused(made(&[], &[], &[]), &["begin with 0"]), ModelError::FirstOffset { found: None });
    assert_eq!(refused(made(&[1, 1], &[0], &[1.0]), &["Some(1)"]), ModelError::FirstOffset { found: Some(1) });
    let error = refused(made(&[0, 2, 1], &[0], &[1.0]), &["vertex 1", "2", "1"]);
    assert_eq!(error, ModelError::FallingOffset { vertex: 1, begin: 2, end: 1 });
    let error = refused(made(&[0, 1], &[0, 1], &[1.0, 0.0]), &["is 1", "2 joints"]);
    assert_eq!(error, ModelError::LastOffset { found: 1, joints: 2 });
    let error = refused(made(&[0, 1], &[0], &[]), &["1 joints", "0 weights"]);
    assert_eq!(error, ModelError::InfluenceWeights { joints: 1, weights: 0 });
    for weight in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let error = made(&[0, 2, 2, 3], &[5, 6, 7], &[1.0, 0.0, weight]);
        let error = refused(error, &["vertex 2", "joint 7", "finite"]);
        assert!(matches!(error, ModelError::InfluenceWeight { vertex: 2, joint: 7, .. }), "{error:?}");
    }
}

#[test]
fn a_model_names_its_instance() {
    let instances = vec![Instance::new(0, None), Instance::new(1, Some("b".to_owned()))];
    assert_eq!(instances[1].name(), Some("b"));
    let error = refused(Model::new(vec![triangle()], instances.clone()), &["instance 1", "geometry 1", "has 1"]);
    assert_eq!(error, ModelError::InstanceGeometry { instance: 1, geometry: 1, geometries: 1 });
    let model = Model::new(vec![triangle(), Geometry::default()], instances).expect("two geometries");
    assert_eq!((model.vertex_count(), model.placed_geometries().len()), (3, 2));
    // More vertices than indices can name, without the memory for them: many instances of one geometry.
    let large =
        Geometry::new(vec![[0.0; 3]; 1 << 17], Vec::new(), GeometryOptions::default()).expect("positions alone");
    let error = Model::new(vec![large.clone()], vec![Instance::new(0, None); 1 << 15]);
    assert_eq!(refused(error, &["4294967296", "split"]), ModelError::TooManyVertices { vertices: 1 << 32 });
    assert!(Model::new(vec![large], vec![Instance::new(0, None); (1 << 15) - 1]).is_ok());
}

#[test]
fn a_pose_names_its_joint_or_target() {
    for (row, column, value) in [(0, 0, f32::NAN), (2, 3, f32::INFINITY), (1, 2, f32::NEG_INFINITY)] {
        let mut palette = vec![IDENTITY; 3];
        palette[1][row][column] = value;
        let words = ["matrix 1".to_owned(), format!("row {row}"), format!("column {column}")];
        let words = words.each_ref().map(String::as_str);
        let error = refused(InstancePose::new(palette, Vec::new()), &words);
        let expected = (1, row, column);
        assert!(matches!(error, ModelError::Matrix { joint, row, column, .. } if (joint, row, column) == expected));
    }
    let error = refused(InstancePose::new(vec![IDENTITY], vec![1e30, -2.0, f32::NAN]), &["target 2", "NaN"]);
    assert!(matches!(error, ModelError::MorphWeight { target: 2, .. }));
}

#[test]
fn mirroring_matrices_turn_the_faces() {
    let mirrored = [[-1.0, 0.0, 0.0, 5.0], IDENTITY[1], IDENTITY[2]];
    let flat = [[0.0; 4], IDENTITY[1], IDENTITY[2]];
    let turned =
        |palette: &[[[f32; 4]; 3]]| InstancePose::new(palette.to_vec(), Vec::new()).expect("finite").faces_turned();
    assert_eq!([turned(&[IDENTITY]), turned(&[mirrored]), turned(&[flat]), turned(&[])], [false, true, false, false]);
    assert!(turned(&[mirrored, flat, mirrored, IDENTITY]));
    assert!(!turned(&[mirrored, IDENTITY]));
    let model = Model::new(vec![triangle()], vec![Instance::new(0, None)]).expect("one geometry");
    let faces = |pose: InstancePose| model.mesh(&Pose::new(vec![pose])).expect("a mesh").faces().to_vec();
    let pose = InstancePose::new(vec![mirrored], Vec::new()).expect("finite");
    assert_eq!(faces(pose.clone()), [[0, 2, 1]]);
    assert_eq!(faces(pose.with_faces_turned(false)), [[0, 1, 2]]);
}

#[test]
fn a_placed_pose_is_moved_as_a_whole() {
    let instances = vec![Instance::new(0, None); 2];
    let model = Model::new(vec![triangle()], instances).expect("one geometry");
    let rows = [[0.5, 0.0, 0.25, 1.0], [0.0, 2.0, 0.0, -3.0], [0.0, 1.0, 1.5, 0.0]];
    let of = |turned| InstancePose::new([rows], Vec::new()).expect("finite").with_faces_turned(turned);
    let pose = Pose::new(vec![of(false), of(true)]);
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
    refused(pose.placed(large), &["matrix 0", "inf", "row 0", "column 3"]);
}

#[test]
fn meshes_of_poses_that_mirror_otherwise_are_typed_errors() {
    let mirrored = [[-1.0, 0.0, 0.0, 5.0], IDENTITY[1], IDENTITY[2]];
    let instances = (0..3).map(|_| Instance::new(0, None)).collect();
    let model = Model::new(vec![triangle()], instances).expect("one geometry");
    let pose = |bits: u32| {
        let of = |bit: u32| {
            let matrix = if bits >> bit & 1 == 1 { mirrored } else { IDENTITY };
            InstancePose::new(vec![matrix], Vec::new()).expect("finite")
        };
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
    let one = Model::new(vec![triangle()], vec![Instance::new(0, None)]).expect("one geometry");
    let other = one.mesh(&Pose::new(vec![InstancePose::new(vec![IDENTITY], Vec::new()).expect("finite")]));
    assert_eq!(model.check_mesh(&other.expect("a mesh"), &pose(0)), Err(ModelError::OtherMesh));
    let faces = [[1, 0, 2], [3, 4, 5], [6, 7, 8]].to_vec();
    let other = rimline::Mesh::from_faces(9, faces).expect("a mesh");
    assert_eq!(model.check_mesh(&other, &pose(0)), Err(ModelError::OtherMesh));
}

/// All functions with a pose refuse that of another model; nothing is left out or read as zero.
#[test]
fn a_pose_of_another_model_is_refused() {
    let influences = Some(Influences::new(vec![0, 1, 2, 3], vec![0, 2, 1], vec![1.0; 3]).expect("they go together"));
    let options = GeometryOptions { influences, morph_targets: vec![vec![[1.0; 3]; 3]], ..GeometryOptions::default() };
    let skinned = geometry(&[[0, 1, 2]], options).expect("a triangle");
    let model = Model::new(vec![triangle(), skinned], vec![Instance::new(0, None), Instance::new(1, None)]);
    let model = model.expect("two geometries");
    let pose = |rigid: usize, joints: usize, weights: usize| {
        let pose = |matrices, weights| InstancePose::new(vec![IDENTITY; matrices], vec![0.5; weights]).expect("finite");
        Pose::new(vec![pose(rigid, 0), pose(joints, weights)])
    };
    let all = |pose: &Pose| {
        let checked = model.check(pose).err();
        assert_eq!(model.mesh(pose).err(), checked);
        assert_eq!(cpu::deform(&model, pose, 0.0, None, Threads::ONE).err(), checked);
        checked
    };
    assert_eq!(all(&pose(1, 3, 1)), None);
    assert_eq!(all(&pose(1, 4, 1)), None, "joints that no vertex follows");
    assert_eq!(all(&Pose::default()), Some(ModelError::PoseInstances { given: 0, needed: 2 }));
    assert_eq!(all(&pose(0, 3, 1)), Some(ModelError::PosePalette { instance: 0, given: 0, needed: 1 }));
    assert_eq!(all(&pose(1, 2, 1)), Some(ModelError::PosePalette { instance: 1, given: 2, needed: 3 }));
    assert_eq!(all(&pose(1, 3, 0)), Some(ModelError::PoseMorphWeights { instance: 1, given: 0, needed: 1 }));
    assert_eq!(all(&pose(1, 3, 2)), Some(ModelError::PoseMorphWeights { instance: 1, given: 2, needed: 1 }));
}

#[test]
fn a_joint_of_the_highest_number_is_no_overflow() {
    let influences = Influences::new(vec![0, 1, 1, 1], vec![u32::MAX], vec![1.0]).expect("any joint");
    let options = GeometryOptions { influences: Some(influences), ..GeometryOptions::default() };
    let model = Model::new(vec![geometry(&[[0, 1, 2]], options).expect("a triangle")], vec![Instance::new(0, None)]);
    let pose = Pose::new(vec![InstancePose::new(vec![IDENTITY], Vec::new()).expect("finite")]);
    let refused = model.expect("one geometry").mesh(&pose).expect_err("too few matrices");
    assert!(matches!(refused, ModelError::PosePalette { given: 1, .. }), "{refused:?}");
    assert_eq!(Mesh::from_faces(0, Vec::new()).err(), Some(MeshError::NoFaces));
}
