//! The CPU references against brute force written apart from them.

use rimline::internals::Method;
use rimline::internals::cpu::{self, CpuError, EdgeMasks, Threads};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{Light, LightError, Mesh, Predicate};
use rimline_testkit::cases::{self, hard_positions, random_soup, topologies};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;
use rimline_testkit::{is_long, lights, must_fail, oracle, same};

type Outcome = Result<(), String>;

fn extracted(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light]) -> cpu::Extraction {
    cpu::extract(positions, mesh, lights, Predicate::Exact, Threads::ONE).expect("good lights")
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

/// Closure and silhouettes notice one flipped bit.
#[test]
fn masks_agree_with_faces_alone() -> Outcome {
    let mut random = Random::new(13);
    let soups = if is_long() { 2000 } else { 150 };
    let soups: Vec<_> =
        (0..soups).map(|index| cases::case(format!("soup {index}"), random_soup(&mut random))).collect();
    let with_controls = topologies().len();
    for (number, (name, positions, mesh)) in topologies().into_iter().chain(soups).enumerate() {
        let lights = lights(&mut random, 33);
        let cpu::Extraction { facing, masks, .. } = extracted(&positions, &mesh, &lights);
        oracle::check_masks(&name, &mesh, &facing, &masks, lights.len())?;
        if number >= with_controls {
            continue;
        }
        let edges = mesh.edges();
        let at = random.below(masks.len());
        let bit = 1 << if at < edges.len() { random.below(32) } else { 0 };
        let is_noticed = |what: &str, masks: &[EdgeMasks], is_open: bool| {
            must_fail(what, &oracle::check_masks(&name, &mesh, &facing, masks, lights.len()))?;
            let open = oracle::unclosed(&mesh, masks, lights.len());
            if is_open && open == 0 { Err(format!("{name}: {what} left everything closed")) } else { Ok(()) }
        };
        let mut wrong = masks.clone();
        wrong[at].silhouette ^= bit;
        is_noticed("a flipped silhouette bit", &wrong, true)?;
        wrong[at] = masks[at];
        wrong[at].winding ^= bit;
        is_noticed("a flipped winding bit", &wrong, false)?;
        // A face's bit, flipped as only one of its edges sees it.
        let mut flipped = facing.clone();
        let record = edges.get(at % edges.len()).ok_or("no record")?;
        flipped[at / edges.len() * mesh.faces().len() + record.face_0 as usize] ^= bit;
        wrong[at] = cpu::edges(edges, &flipped, mesh.faces().len(), lights.len(), Threads::ONE)[at];
        is_noticed("a facing bit flipped at one edge", &wrong, true)?;
    }
    Ok(())
}

#[test]
fn threads_change_nothing() {
    let (_, positions, mesh) = cases::case("torus", shapes::torus(120, 70, 1.0, 0.4));
    let lights = lights(&mut Random::new(17), 33);
    for (method, predicate) in [
        (Method::FaceMask, Predicate::Exact),
        (Method::FaceMask, Predicate::Fast),
        (Method::FaceMask, Predicate::Plane),
        (Method::PerEdge, Predicate::Fast),
        (Method::PerEdge, Predicate::Plane),
    ] {
        let of =
            |threads| cpu::extract_by(&positions, &mesh, &lights, method, predicate, threads).expect("good lights");
        let one = of(Threads::ONE);
        for threads in [Threads::all(), Threads::new(0), Threads::new(3), Threads::new(1000)] {
            assert!(of(threads) == one, "{method:?}, {predicate:?}, {threads:?}");
        }
    }
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
