//! The CPU references against brute force written apart from them.

use rimline::internals::Method;
use rimline::internals::cpu::{self, CpuError, Threads};
use rimline::mesh::{EdgeKind, PolygonLoops, Weld};
use rimline::{Light, LightError, Mesh, Predicate};
use rimline_testkit::cases::{self, hard_positions, random_soup, topologies};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;
use rimline_testkit::{band, is_long, lights, must_fail, oracle, same};

type Outcome = Result<(), String>;

fn extracted(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light]) -> cpu::Extraction {
    cpu::extract(positions, mesh, lights, Predicate::Exact, Threads::ONE).expect("good lights")
}

#[test]
fn exact_signs_are_those_of_cases_worked_by_hand() {
    let sign = |corners: [[f32; 3]; 3], light| oracle::ExactFace::new(&corners, [0, 1, 2]).expect("a face").sign(light);
    let up = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(sign(up, Light::point([9.0, 9.0, f32::from_bits(1)])), 1);
    assert_eq!(sign(up, Light::point([9.0, 9.0, -f32::from_bits(1)])), -1);
    assert_eq!(sign(up, Light::point([9.0, 9.0, -0.0])), 0);
    assert_eq!(sign(up, Light::directional([f32::MAX, 0.0, 1e-45])), 1);
    assert_eq!(sign(up, Light::homogeneous([0.0, 0.0, 1.0, -1.0])), 1);
    let raised = up.map(|[x, y, _]| [x, y, 1.0]);
    assert_eq!(sign(raised, Light::homogeneous([0.0, 0.0, 0.999_999_94, 1.0])), -1);
    assert_eq!(sign(raised, Light::homogeneous([0.0, 0.0, -0.5, -1.0])), 1);
    assert_eq!(sign(raised, Light::homogeneous([0.0, 0.0, 3.0, 3.0])), 0);
    // One ulp of a coordinate of 2^24 decides, and products of the largest numbers do not overflow.
    let far = up.map(|c| c.map(|c| 2.0 * c + 16_777_216.0));
    assert_eq!(sign(far, Light::point([16_777_216.0, 16_777_216.0, 16_777_218.0])), 1);
    let huge = up.map(|c| c.map(|c| c * f32::MAX));
    assert_eq!(sign(huge, Light::point([0.0, 0.0, f32::MIN_POSITIVE])), 1);
    assert_eq!(sign([up[0], up[2], up[1]], Light::point([0.0, 0.0, 1.0])), -1);
}

/// They had their silhouettes from NaN instead: right bits of a wrong shape.
#[test]
fn missing_positions_and_bad_lights_are_refused() {
    let shape = shapes::torus(8, 6, 1.0, 0.4);
    let (needed, positions) = (shape.positions.len(), &shape.positions);
    let loops = PolygonLoops { polygon_loops: &[1], loop_sizes: &[4], loop_corners: &[0, 1, 2, 3] };
    let quad = Mesh::from_polygons_by_loop(&positions[..4], loops, Weld::Keep).expect("a polygon");
    let torus = Mesh::from_faces(needed, shape.faces.clone()).expect("a mesh");
    let good = [Light::point([2.0, 3.0, 4.0])];
    for (mesh, needed) in [(&torus, needed), (&quad, 4)] {
        for method in [Method::FaceMask, Method::PerEdge] {
            let mut kept =
                cpu::extract_by(positions, mesh, &good, method, Predicate::Exact, Threads::ONE).expect("good");
            let before = kept.clone();
            let mut refused = |positions: &[[f32; 3]], lights: &[Light]| {
                let error = kept.update_by(positions, mesh, lights, method, Predicate::Exact, Threads::ONE).err();
                assert_eq!(kept, before, "changed by what is refused");
                error
            };
            for given in [0, 1, needed - 1] {
                let few = CpuError::TooFewPositions { given, needed: needed as u32 };
                assert_eq!(refused(&positions[..given], &good), Some(few), "{method:?}");
                assert_eq!(refused(&positions[..given], &[]), Some(few), "{method:?}, without lights");
            }
            let zero = CpuError::Light(LightError::Zero { index: 1 });
            assert_eq!(refused(positions, &[good[0], Light::homogeneous([0.0; 4])]), Some(zero), "{method:?}");
            let more = [&positions[..], &[[f32::NAN; 3]]].concat();
            let found = cpu::extract_by(&more, mesh, &good, method, Predicate::Exact, Threads::ONE);
            assert_eq!(found.as_ref(), Ok(&before), "{method:?}: more than needed");
        }
    }
}

#[test]
fn facing_is_exact_outside_the_band_for_random_triangles() -> Outcome {
    let mut random = Random::new(12);
    let rounds = if is_long() { 4000 } else { 150 };
    let mut sum = band::Checked::default();
    for round in 0..rounds {
        // Nearly coplanar lights at random scales: sums of the corners, nudged by a few ulp.
        let exponent = random.between(-30.0, 30.0).exp2();
        let positions: Vec<_> = (0..30).map(|_| random.direction().map(|c| c * exponent)).collect();
        let faces: Vec<_> = (0..10).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let lights: Vec<_> = (0..12)
            .map(|_| {
                let [a, b, c] = faces[random.below(10)].map(|v| positions[v as usize]);
                let (s, t) = (random.between(-2.0, 2.0), random.between(-2.0, 2.0));
                let mut l: [f32; 3] = std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]));
                l[random.below(3)] *= 1.0 + random.between(-1e-5, 1e-5);
                match random.below(4) {
                    0 => Light::directional(std::array::from_fn(|i| s * (b[i] - a[i]) + t * (c[i] - a[i]))),
                    1 => Light::homogeneous([l[0] * 3.0, l[1] * 3.0, l[2] * 3.0, 3.0]),
                    _ => Light::point(l),
                }
            })
            .collect();
        let facing = cpu::facing(&positions, &faces, &lights, Predicate::Fast, Threads::ONE);
        let checked = band::check_facing(&format!("round {round}"), &facing, &positions, &faces, &lights)?;
        sum.outside += checked.outside;
        sum.inside += checked.inside;
        sum.wrong_inside += checked.wrong_inside;
    }
    println!("{sum:?}");
    assert!(sum.inside > 0 && sum.wrong_inside > 0, "hard enough to err: {sum:?}");
    Ok(())
}

#[test]
fn masks_agree_with_faces_alone() -> Outcome {
    let mut random = Random::new(13);
    let soups = if is_long() { 2000 } else { 150 };
    let soups: Vec<_> =
        (0..soups).map(|index| cases::case(format!("soup {index}"), random_soup(&mut random))).collect();
    for (name, positions, mesh) in topologies().into_iter().chain(soups) {
        let lights = lights(&mut random, 33);
        let found = extracted(&positions, &mesh, &lights);
        oracle::check_masks(&name, &mesh, &found.facing, &found.masks, lights.len())?;
    }
    Ok(())
}

#[test]
fn closure_and_silhouettes_notice_one_flipped_bit() -> Outcome {
    let mut random = Random::new(14);
    for (name, positions, mesh) in topologies() {
        let lights = lights(&mut random, 33);
        let mut found = extracted(&positions, &mesh, &lights);
        let at = random.below(found.masks.len());
        let light = if at < mesh.edges().len() { random.below(32) as u32 } else { 0 };
        found.masks[at].silhouette ^= 1 << light;
        if oracle::unclosed(&mesh, &found.masks, lights.len()) == 0 {
            return Err(format!("{name}: a flipped silhouette bit left everything closed"));
        }
        let outcome = oracle::check_masks(&name, &mesh, &found.facing, &found.masks, lights.len());
        must_fail("a flipped silhouette bit", &outcome)?;
        found.masks[at].silhouette ^= 1 << light;
        found.masks[at].winding ^= 1 << light;
        let outcome = oracle::check_masks(&name, &mesh, &found.facing, &found.masks, lights.len());
        must_fail("a flipped winding bit", &outcome)?;
        // A face's bit, flipped as only one of its edges sees it.
        found.masks[at].winding ^= 1 << light;
        let edge = at % mesh.edges().len();
        let mut facing = found.facing.clone();
        let first = at / mesh.edges().len() * mesh.faces().len();
        let record = mesh.edges().get(edge).ok_or("no record")?;
        facing[first + record.face_0 as usize] ^= 1 << light;
        found.masks[at] = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), lights.len(), Threads::ONE)[at];
        if oracle::unclosed(&mesh, &found.masks, lights.len()) == 0 {
            return Err(format!("{name}: a facing bit flipped at one edge left everything closed"));
        }
    }
    Ok(())
}

#[test]
fn records_partition_the_faces_of_each_edge() {
    let mut random = Random::new(15);
    let soups = (0..200).map(|_| random_soup(&mut random));
    let soups: Vec<_> = soups.chain([shapes::fan(300), shapes::moebius(9, 2)]).collect();
    for shape in soups {
        let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Keep).expect("a mesh");
        let mut from_records = oracle::EdgeFaces::new();
        for edge in mesh.edges().iter() {
            let [a, b] = edge.vertices;
            let faces = from_records.entry((a.min(b), a.max(b))).or_default();
            faces.push((edge.face_0, a < b));
            match (edge.kind, edge.face_1) {
                (EdgeKind::Consistent, Some(face)) => faces.push((face, a > b)),
                (EdgeKind::Inconsistent, Some(face)) => faces.push((face, a < b)),
                (EdgeKind::Boundary, None) => {}
                _ => panic!("{edge:?}"),
            }
            assert!(edge.face_1.is_none_or(|face| face > edge.face_0), "face 0 is the lower");
        }
        for faces in from_records.values_mut() {
            faces.sort_unstable();
        }
        assert_eq!(from_records, oracle::edge_faces(mesh.faces()));
    }
}

#[test]
fn threads_change_nothing() -> Outcome {
    let (_, positions, mesh) = cases::case("torus", shapes::torus(120, 70, 1.0, 0.4));
    let lights = lights(&mut Random::new(17), 33);
    let ways = [
        (Method::FaceMask, Predicate::Exact),
        (Method::FaceMask, Predicate::Fast),
        (Method::FaceMask, Predicate::Plane),
        (Method::PerEdge, Predicate::Fast),
        (Method::PerEdge, Predicate::Plane),
    ];
    for (method, predicate) in ways {
        let of =
            |threads| cpu::extract_by(&positions, &mesh, &lights, method, predicate, threads).expect("good lights");
        let one = of(Threads::ONE);
        for threads in [Threads::all(), Threads::new(0), Threads::new(3), Threads::new(1000)] {
            let other = of(threads);
            same("facing", &other.facing, &one.facing)?;
            same("masks", &other.masks, &one.masks)?;
        }
    }
    Ok(())
}

/// One light alone takes a way of its own; every bit is exact there too, beside faces that are lines, huge or not finite.
#[test]
fn one_light_alone_is_exact() -> Outcome {
    let mut random = Random::new(17);
    for (name, (_, mut positions, mesh), lights) in hard_positions(&mut random) {
        for (round, light) in lights.into_iter().enumerate() {
            let vertex = random.below(positions.len());
            match round {
                10 => positions[vertex] = positions[0],
                15 => positions[vertex][1] = 1e30,
                20 => positions[vertex][2] = f32::NAN,
                25 => positions[vertex][0] = f32::INFINITY,
                _ => {}
            }
            let light = [light];
            let right = oracle::facing(&positions, mesh.faces(), &light);
            let mut found = cpu::facing(&positions, mesh.faces(), &light, Predicate::Exact, Threads::ONE);
            same(&format!("{name}, light {round}"), &found, &right)?;
            found[vertex % right.len()] ^= 1;
            must_fail("a flipped facing bit", &same(&name, &found, &right))?;
        }
    }
    Ok(())
}
