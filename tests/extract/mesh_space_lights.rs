//! Lights moved to mesh space give a rigid instance the bits it has in world space.

use glam::{DAffine3, DMat3, DVec3};
use rimline::Light;
use rimline_testkit::random::Random;
use rimline_testkit::shapes;
use rimline_testkit::{must_fail, oracle, same};

fn to_world(transform: &DAffine3, position: [f32; 3]) -> [f32; 3] {
    let placed = transform.transform_point3(DVec3::from(position.map(f64::from)));
    let rounded = placed.as_vec3();
    assert_eq!(rounded.as_dvec3(), placed, "the transform is exact in f32");
    rounded.to_array()
}

/// Positions and lights on a lattice, so that everything is exact in f32.
#[test]
fn bits_in_mesh_space_are_those_in_world_space() -> Result<(), String> {
    let mut random = Random::new(91);
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let turns = [
        DMat3::IDENTITY,
        DMat3::from_cols(y, -x, z),
        DMat3::from_cols(z, x, y),
        DMat3::from_cols(x, z, -y),
        // Mirrored.
        DMat3::from_cols(-x, y, z),
        DMat3::from_cols(y, x, z),
        -DMat3::IDENTITY,
    ];
    let shape = shapes::blob(3, 0.5, 2);
    let positions: Vec<_> = shape.positions.iter().map(|p| p.map(|c| (c * 64.0).round() / 64.0)).collect();
    for turn in turns {
        for scale in [DVec3::ONE, DVec3::splat(0.25), DVec3::new(2.0, 4.0, 0.5), DVec3::splat(-2.0)] {
            let transform = DAffine3 {
                matrix3: turn * DMat3::from_diagonal(scale),
                translation: DVec3::from([0; 3].map(|_| random.below(21) as f64 - 10.0)),
            };
            let mirrored = transform.matrix3.determinant() < 0.0;
            let world: Vec<_> = positions.iter().map(|&p| to_world(&transform, p)).collect();
            let turned = shape.faces.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] });
            let turned: Vec<_> = turned.collect();
            let lights = (0..24).map(|index| {
                let [x, y, z] = [0; 3].map(|_| random.below(129) as f32 / 16.0 - 4.0);
                Light::homogeneous([x, y, z, [0.0, 1.0, 0.5, 3.0, -1.0][index % 5]])
            });
            let lights: Vec<_> = lights.filter(|light| light.to_array() != [0.0; 4]).collect();
            let moved = lights.iter().map(|light| light.to_mesh_space(&transform.to_cols_array_2d()));
            let moved = moved.collect::<Option<Vec<_>>>().ok_or("a regular transform is no reason for None")?;
            let in_world = oracle::facing(&world, &turned, &lights);
            let in_mesh = oracle::facing(&positions, &shape.faces, &moved);
            same(&format!("{transform:?}"), &in_mesh, &in_world)?;
            let unmoved = oracle::facing(&positions, &shape.faces, &lights);
            if transform != DAffine3::IDENTITY {
                must_fail("lights left in world space", &same("bits", &unmoved, &in_world))?;
            }
        }
    }
    Ok(())
}

/// Singular, not finite, or so small that the light leaves the range of `f32`.
#[test]
fn some_transforms_have_no_mesh_space() {
    let diagonal = |x, y, z| DAffine3::from_scale(DVec3::new(x, y, z));
    for transform in [
        diagonal(0.0, 0.0, 0.0),
        diagonal(1.0, 0.0, 1.0),
        DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z)),
        diagonal(f64::NAN, 1.0, 1.0),
        diagonal(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        DAffine3::from_translation(DVec3::new(f64::NAN, 0.0, 0.0)),
        DAffine3::from_translation(DVec3::new(f64::INFINITY, 0.0, 0.0)),
        diagonal(1e-60, 1e-60, 1e-60),
    ] {
        let light = Light::point([1.0, 2.0, 3.0]);
        assert_eq!(light.to_mesh_space(&transform.to_cols_array_2d()), None, "{transform:?}");
    }
}
