//! Zero of anything: every constructor of the library that needs no device takes it, or refuses it by a typed error.

use std::ops::ControlFlow;

use rimline::cpu::{self, OccludedFaces, OcclusionCaster, OcclusionOptions, OcclusionStatistics, Threads};
use rimline::internals::clusters::Clusters;
use rimline::mesh::{MeshDiagnostics, MeshError, PolygonLoops, Weld, WeldDistance};
use rimline::model::ModelBounds;
use rimline::{
    AreaLight, AreaShape, Cone, Displacement, Geometry, GeometryOptions, Influences, Instance, InstancePose, Light,
    Mesh, Model, Pose, Predicate, falloff,
};
use rimline_testkit::cases::{CORNERS, without_extent};

#[test]
fn no_vertices_and_no_faces() {
    for weld in [Weld::Data, Weld::Position, Weld::Keep, Weld::Distance(WeldDistance::new(0.0).expect("as equal ones"))]
    {
        let none = PolygonLoops::default();
        assert_eq!(Mesh::new(&[], &[], weld), Err(MeshError::NoFaces));
        assert_eq!(Mesh::from_polygons(&CORNERS, none, weld), Err(MeshError::NoFaces));
        assert_eq!(Mesh::from_polygons_by_loop(&[], none, weld), Err(MeshError::NoFaces));
        assert_eq!(none.triangulate(&[], weld), Err(MeshError::NoFaces));
        assert!(matches!(Mesh::new(&[], &[[0; 3]], weld), Err(MeshError::IndexOutOfRange { vertices: 0, .. })));
        let one = PolygonLoops { polygon_loops: &[1], loop_sizes: &[3], loop_corners: &[0; 3] };
        let refused = Mesh::from_polygons(&[], one, weld);
        assert!(matches!(refused, Err(MeshError::CornerOutOfRange { vertices: 0, .. })), "{refused:?}");
        let loops = PolygonLoops { polygon_loops: &[0], ..none };
        let refused = Mesh::from_polygons_by_loop(&CORNERS, loops, weld);
        assert_eq!(refused, Err(MeshError::PolygonWithoutLoops { polygon: 0 }));
        let corners = PolygonLoops { polygon_loops: &[1], loop_sizes: &[0], loop_corners: &[] };
        let refused = Mesh::from_polygons(&CORNERS, corners, weld);
        assert!(matches!(refused, Err(MeshError::LoopTooSmall { corners: 0, .. })), "{refused:?}");
    }
    assert_eq!(Mesh::from_faces(0, Vec::new()), Err(MeshError::NoFaces));
}

#[test]
fn faces_without_extent_are_a_mesh_of_which_nothing_is_found() {
    let lights = [Light::point([0.0, 0.0, 2.0]), Light::directional([0.0, 0.0, 1.0])];
    for mesh in without_extent() {
        assert_eq!((mesh.face_count(), mesh.degenerate_faces(), mesh.edges().len()), (1, 1, 0), "{mesh:?}");
        assert!(mesh.is_closed() && mesh.edges().is_empty() && mesh.edges().get(0).is_none());
        let found = MeshDiagnostics::of(&mesh, 0);
        assert_eq!((found.components, found.duplicate_faces, found.flipped_faces), (0, 0, 0));
        assert!(mesh.polygons().is_some() || Clusters::new(&mesh, &CORNERS, Threads::ONE).bounds().len() <= 1);
        for predicate in [Predicate::Exact, Predicate::Fast, Predicate::Plane] {
            for lights in [&lights[..], &[]] {
                let found = cpu::extract(&CORNERS, &mesh, lights, predicate, Threads::ONE).expect("lights");
                assert!(found.facing.iter().chain(&found.twisted).all(|&mask| mask == 0) && found.masks.is_empty());
            }
        }
        for points in [&[[0.2, 0.2, -1.0]][..], &[]] {
            for lights in [&lights[..], &[]] {
                let depths = cpu::shadow_depth(&CORNERS, &mesh, points, lights, Threads::ONE).expect("lights");
                assert_eq!(depths, vec![0; points.len() * lights.len()]);
            }
        }
    }
}

#[test]
fn models_of_nothing() {
    let empty = Geometry::new(Vec::new(), Vec::new(), GeometryOptions::default()).expect("nothing is wrong with it");
    for weld in [Weld::Data, Weld::Position, Weld::Keep] {
        assert!(empty.welded(weld).0.positions().is_empty());
    }
    let influences = Influences::new(vec![0], Vec::new(), Vec::new()).expect("no vertices");
    assert!(Influences::new(Vec::new(), Vec::new(), Vec::new()).is_err());
    let options =
        GeometryOptions { influences: Some(influences), morph_targets: vec![Vec::new()], ..Default::default() };
    let skinned = Geometry::new(Vec::new(), Vec::new(), options).expect("no vertices to move");
    let instance = || Instance::new(0, None);
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let posed = |palette: Vec<[[f32; 4]; 3]>, weights| InstancePose::new(palette, weights).expect("finite");
    for (geometries, instances, poses) in [
        (vec![], vec![], vec![]),
        (vec![empty.clone()], vec![], vec![]),
        (vec![empty], vec![instance()], vec![posed(vec![identity], Vec::new())]),
        (vec![skinned.clone()], vec![instance()], vec![posed(Vec::new(), vec![0.0])]),
        (vec![skinned], vec![instance()], vec![posed(vec![identity], vec![1.0])]),
    ] {
        let model = Model::new(geometries, instances).expect("instances of what is there");
        let pose = Pose::new(poses);
        model.check(&pose).expect("a pose of this model");
        assert!(model.mesh(&pose).is_err(), "no faces");
        assert_eq!(cpu::deform(&model, &pose, 0.0, None, Threads::ONE).expect("its pose"), Vec::<[f32; 3]>::new());
        let boxes = ModelBounds::new(&model).boxes(&pose, 0.0).expect("its pose");
        assert!(boxes.iter().all(Option::is_none), "{boxes:?}");
    }
    assert!(Model::new(Vec::new(), vec![instance()]).is_err(), "an instance of nothing");
    assert!(Displacement::new("").is_err());
}

#[test]
fn lights_of_nothing() {
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).expect("a face");
    let dark = [Light::homogeneous([0.0; 4])];
    assert!(cpu::extract(&CORNERS, &mesh, &dark, Predicate::Exact, Threads::ONE).is_err());
    assert!(cpu::shadow_depth(&CORNERS, &mesh, &[[0.0; 3]], &dark, Threads::ONE).is_err());
    let shape = AreaShape::Sphere { radius: 0.0 };
    let lamp = AreaLight { light: Light::point([0.0, 1.0, 0.0]), shape, normal: [0.0; 3] };
    assert!(lamp.samples(0).is_empty() && lamp.pattern_samples(0, 0, 0).is_empty());
    // A cone without an angle is its axis.
    let ray = Light::point([0.0, 0.0, 2.0]).with_cone(Cone::new([0.0, 0.0, -1.0], 0.0));
    assert!(cpu::extract(&CORNERS, &mesh, &[ray], Predicate::Exact, Threads::new(0)).is_ok());
    for (distance, begin, end, exponent, share) in [
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 1.0, 0.0, 1.0),
        (0.5, 0.0, 1.0, 0.0, 1.0),
        (1.0, 0.0, 1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 1.0, 0.0),
    ] {
        assert_eq!(falloff(distance, begin, end, exponent), share, "{distance}, {begin}, {end}, {exponent}");
    }
}

#[test]
fn nothing_hides_behind_nothing() {
    let go_on = |_, _| ControlFlow::Continue(());
    let light = Light::point([0.0, 0.0, 2.0]);
    let meshes = without_extent();
    let none: Vec<OcclusionCaster<'_>> = Vec::new();
    let casters = meshes.iter().map(|mesh| OcclusionCaster { mesh, positions: &CORNERS, version: None });
    for casters in [none, casters.collect()] {
        for leave_out_all in [false, true] {
            let options = OcclusionOptions { leave_out_all, threads: Threads::new(0), ..OcclusionOptions::default() };
            let found = OccludedFaces::find(light, &casters, options, go_on).expect("found");
            assert_eq!(found.statistics(), OcclusionStatistics::default());
            assert!((0..=casters.len()).all(|caster| found.faces(caster).is_empty()));
        }
    }
    // Without nodes nothing hides, and without steps nothing is decided.
    let wall = [[-9.0, -9.0, 1.0], [9.0, -9.0, 1.0], [0.0, 9.0, 1.0]];
    let face = Mesh::from_faces(3, vec![[0, 1, 2]]).expect("a face");
    let behind = CORNERS.map(|[x, y, z]| [x / 8.0, y / 8.0, z - 1.0]);
    let casters = [&wall, &behind].map(|positions| OcclusionCaster { mesh: &face, positions, version: None });
    let occluded = |max_nodes, max_steps| {
        let options = OcclusionOptions { max_nodes, max_steps, ..OcclusionOptions::default() };
        OccludedFaces::find(light, &casters, options, go_on).expect("found").statistics().occluded
    };
    assert_eq!([occluded(0, 0), occluded(0, 4096), occluded(1 << 21, 0), occluded(1 << 21, 4096)], [0, 0, 0, 1]);
}
