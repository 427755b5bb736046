//! Clusters: orders, and decisions against exact signs in big integers.

use std::collections::BTreeMap;

use rimline::internals::clusters::{Arranged, CLUSTER_FACES, ClusterBound, Clusters};
use rimline::internals::cpu::Threads;
use rimline::internals::layout::CHUNK;
use rimline::mesh::{EdgeKind, INCONSISTENT_BIT, NO_FACE};
use rimline::{Light, Mesh};
use rimline_testkit::clusters::whole;
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail, same};

use rimline_testkit::cluster_meshes::{Case, case, marginal_lights};

type Outcome = Result<(), String>;

/// How a cluster is decided: whether its faces face the light, if all do or none does.
type Decide = fn(&ClusterBound, Light) -> Option<bool>;

/// Pairs of face and light: by clusters that are decided as facing, as back-facing, and of all clusters.
#[derive(Clone, Copy, Debug, Default)]
struct Decided {
    facing: usize,
    back_facing: usize,
    all: usize,
}

/// Every face of a decided cluster has the sign that the cluster was decided to have, not 0, or is finite and names a vertex
/// twice, in a cluster decided as back-facing.
fn check(shape: &Shape, lights: &[Light], decide: Decide, counts: &mut Decided) -> Outcome {
    let mesh = shape.mesh().map_err(|error| error.to_string())?;
    let found = Clusters::new(&mesh, &shape.positions, Threads::ONE);
    let exact: Vec<_> = shape.faces.iter().map(|&face| ExactFace::new(&shape.positions, face)).collect();
    for (slots, bound) in found.faces().chunks(CLUSTER_FACES).zip(found.bounds()) {
        for &light in lights {
            counts.all += slots.len();
            let wanted = match decide(bound, light) {
                None => continue,
                Some(true) => 1,
                Some(false) => -1,
            };
            *if wanted > 0 { &mut counts.facing } else { &mut counts.back_facing } += slots.len();
            for &face in slots {
                let corners = shape.faces[face as usize].map(|vertex| shape.positions[vertex as usize]);
                let sign = match &exact[face as usize] {
                    Some(exact) => exact.sign(light),
                    // It names a vertex twice, so it faces no light and is excluded for none.
                    None if corners.iter().flatten().all(|c| c.is_finite()) => -1,
                    None => 0,
                };
                if sign != wanted {
                    return Err(format!("{wanted} for {light:?}, but face {face} at {corners:?} has the sign {sign}"));
                }
            }
        }
    }
    Ok(())
}

/// Checks random cases, each with its lights and marginal ones, and sums by the names of the cases.
fn trials(seed: u64, count: usize, decide: Decide) -> Result<BTreeMap<&'static str, Decided>, String> {
    let mut random = Random::new(seed);
    let mut totals = BTreeMap::<_, Decided>::new();
    for index in 0..count {
        let mut case = case(&mut random, index);
        case.lights.extend(marginal_lights(&mut random, &case)?);
        let what = |error| format!("seed {seed}, case {index}, {}: {error}", case.name);
        check(&case.shape, &case.lights, decide, totals.entry(case.name).or_default()).map_err(what)?;
    }
    Ok(totals)
}

#[test]
fn decided_clusters_have_the_exact_signs() -> Outcome {
    let seed = 1401;
    println!("seed {seed}; pairs of face and light");
    for (name, counts) in trials(seed, if is_long() { 20_000 } else { 400 }, whole)? {
        println!("{name}: {counts:?}");
        // Faces thrown at random have no side in common.
        if name != "random faces" && counts.facing.min(counts.back_facing) * 50 < counts.all {
            return Err(format!("{name}: {counts:?}: too few are decided to show anything"));
        }
    }
    Ok(())
}

/// Negative control: the check notices a wrong decision by bounds that lack a part.
#[test]
fn bounds_without_a_part_are_noticed() -> Outcome {
    fn without(bound: &ClusterBound, light: Light, change: fn(&mut ClusterBound)) -> Option<bool> {
        let mut bound = *bound;
        change(&mut bound);
        whole(&bound, light)
    }
    let changed: [(&str, Decide); 8] = [
        ("the range of x", |bound, light| without(bound, light, |bound| bound.half[0] = 0.0)),
        ("the range of y", |bound, light| without(bound, light, |bound| bound.half[1] = 0.0)),
        ("the range of z", |bound, light| without(bound, light, |bound| bound.half[2] = 0.0)),
        ("the range of heights", |bound, light| without(bound, light, |bound| bound.half[3] = 0.0)),
        ("the middle height", |bound, light| without(bound, light, |bound| bound.middle[3] = 0.0)),
        ("the centre", |bound, light| without(bound, light, |bound| bound.centre = [0.0; 3])),
        ("what may not be facing", |bound, light| without(bound, light, |bound| bound.kind = bound.kind.min(1))),
        ("what has no bound", |bound, _| (bound.kind == 0).then_some(false)),
    ];
    for (what, decide) in changed {
        must_fail(what, &trials(1401, 400, decide))?;
    }
    Ok(())
}

/// The meshes are large enough for several threads to share each step.
#[test]
fn orders_do_not_depend_on_threads() -> Outcome {
    for shape in [shapes::blob(90, 0.4, 1), shapes::torus(300, 90, 1.0, 0.4).shuffled(3)] {
        let mesh = shape.mesh().map_err(|error| error.to_string())?;
        let one = Clusters::new(&mesh, &shape.positions, Threads::ONE);
        for threads in [1, 2, 3, 7] {
            let found = Clusters::new(&mesh, &shape.positions, Threads::new(threads));
            same("faces", found.faces(), one.faces())?;
            same("bounds", found.bounds(), one.bounds())?;
            same("edges", found.edges(), one.edges())?;
            let [many, few] = [threads, 1].map(|threads| Arranged::new(&mesh, &found, Threads::new(threads)));
            same("words", &many.words, &few.words)?;
            assert!(many == few, "{threads} threads: faces or edges differ");
        }
        must_fail("another order", &same("faces", one.faces(), &(0..one.faces().len() as u32).collect::<Vec<_>>()))?;
    }
    Ok(())
}

/// The number of a chunk's edge records that are silhouettes. `facing` is by face slots.
fn silhouettes(arranged: &Arranged, facing: &[bool], chunk: usize) -> usize {
    let records = arranged.edge_faces.chunks(CHUNK as usize).nth(chunk).unwrap_or_default();
    let is_silhouette = |[face_0, face_1]: &&[u32; 2]| {
        if *face_1 == NO_FACE {
            return true;
        }
        let [first, second] = [face_0 & !INCONSISTENT_BIT, *face_1].map(|slot| facing[slot as usize]);
        (first == second) == (face_0 & INCONSISTENT_BIT != 0)
    };
    records.iter().filter(is_silhouette).count()
}

/// The rule by which a chunk may be skipped, and its clusters, from the words.
fn named(arranged: &Arranged, clusters: usize, chunk: usize) -> (u32, &[u32]) {
    let [begin, end] = [0, 1].map(|next| arranged.words[12 * clusters + chunk + next]);
    (begin >> 30, &arranged.words[(begin & 0x3fff_ffff) as usize..(end & 0x3fff_ffff) as usize])
}

/// Slots hold each face and edge record of the mesh once, and a chunk that is skipped has no silhouette, however the faces
/// of undecided clusters face.
#[test]
fn arranged_meshes_are_the_mesh_and_skip_no_silhouette() -> Outcome {
    let mut random = Random::new(1405);
    let (mut skipped, mut tested, mut noticed) = (0, 0, 0);
    for index in 0..60 {
        let Case { name, shape, .. } = case(&mut random, index);
        let what = format!("{name}, case {index}");
        let mesh = shape.mesh().map_err(|error| error.to_string())?;
        let found = Clusters::new(&mesh, &shape.positions, Threads::ONE);
        let arranged = Arranged::new(&mesh, &found, Threads::ONE);
        for (order, count) in [(found.faces(), mesh.faces().len()), (found.edges(), mesh.edges().len())] {
            let mut sorted = order.to_vec();
            sorted.sort_unstable();
            same(&format!("{what}: each once"), &sorted, &(0..count as u32).collect::<Vec<_>>())?;
        }
        let faces: Vec<_> = found.faces().iter().map(|&face| mesh.faces()[face as usize]).collect();
        same(&format!("{what}: faces"), &arranged.faces, &faces)?;
        for (slot, &record) in found.edges().iter().enumerate() {
            let edge = mesh.edges().get(record as usize).ok_or("no such record")?;
            let [first, second] = arranged.edge_faces[slot];
            let of = |slot: u32| (slot != NO_FACE).then(|| found.faces()[(slot & !INCONSISTENT_BIT) as usize]);
            let (faces, vertices) = ([of(first), of(second)], arranged.edge_vertices[slot]);
            let is_inconsistent = (first & INCONSISTENT_BIT != 0, edge.kind == EdgeKind::Inconsistent);
            same(&format!("{what}: record {record}"), &[faces], &[[Some(edge.face_0), edge.face_1]])?;
            same(&format!("{what}: record {record}"), &[is_inconsistent.0], &[is_inconsistent.1])?;
            same(&format!("{what}: record {record}"), &[vertices], &[mesh.edges().vertices()[record as usize]])?;
        }
        let clusters = found.bounds().len();
        same(&format!("{what}: bounds"), &arranged.words[..12 * clusters], bytemuck::cast_slice(found.bounds()))?;
        for _ in 0..8 {
            // For each cluster 0: undecided, with faces of both kinds; 1, 2: all facing; 3, 4: all back-facing.
            let whole: Vec<u32> = (0..clusters).map(|_| random.below(5) as u32).collect();
            let facing = |slot: usize| match whole[slot / CLUSTER_FACES] {
                0 => random.below(2) == 0,
                side => side < 3,
            };
            let facing: Vec<bool> = (0..faces.len()).map(facing).collect();
            for chunk in 0..arranged.edge_faces.len().div_ceil(CHUNK as usize) {
                let (rule, names) = named(&arranged, clusters, chunk);
                let sides: Vec<u32> = names.iter().map(|&cluster| whole[cluster as usize]).collect();
                let is_decided = sides.iter().all(|&side| side != 0);
                let is_alike = sides.windows(2).all(|pair| (pair[0] < 3) == (pair[1] < 3));
                let count = silhouettes(&arranged, &facing, chunk);
                let is_skipped = match rule {
                    1 => is_decided,
                    2 => is_decided && is_alike,
                    _ => false,
                };
                if is_skipped && count > 0 {
                    return Err(format!("{what}: chunk {chunk} is skipped, and has {count} silhouettes"));
                }
                *(if is_skipped { &mut skipped } else { &mut tested }) += 1;
                // Negative control: clusters with edges between them must have the same facing.
                noticed += usize::from(rule == 2 && is_decided && count > 0);
            }
        }
    }
    println!("{skipped} chunks skipped, {tested} tested, {noticed} decided and not alike");
    if skipped == 0 || tested == 0 || noticed == 0 { Err("not as meant".to_owned()) } else { Ok(()) }
}

/// Clusters of bad faces are not decided, unless all are finite and name a vertex twice.
#[test]
fn bad_faces_have_no_bound() -> Outcome {
    let shape = shapes::sphere(8);
    let mesh = shape.mesh().map_err(|error| error.to_string())?;
    let light = Light::point([3.0, 4.0, 5.0]);
    let positions = &shape.positions[..shape.positions.len() / 2];
    let missing = Clusters::new(&mesh, positions, Threads::ONE);
    for (slots, bound) in missing.faces().chunks(CLUSTER_FACES).zip(missing.bounds()) {
        let is_bad = |&face: &u32| mesh.faces()[face as usize].iter().any(|&vertex| vertex as usize >= positions.len());
        assert_eq!(bound.kind == 0, slots.iter().any(is_bad), "a vertex that is missing counts as not finite");
    }
    let twice = Mesh::from_faces(3, vec![[0, 0, 1]; 300]).map_err(|error| error.to_string())?;
    let finite = Clusters::new(&twice, &[[0.0; 3], [1.0; 3], [2.0; 3]], Threads::ONE);
    assert!(finite.bounds().iter().all(|bound| whole(bound, light) == Some(false)));
    // Such a face is excluded for every light, so the cluster is not decided as back-facing.
    let infinite = Clusters::new(&twice, &[[0.0; 3], [f32::INFINITY; 3], [2.0; 3]], Threads::ONE);
    assert!(infinite.bounds().iter().all(|bound| whole(bound, light).is_none()));
    // Distinct vertices at one position: every light is in the plane.
    let collapsed = Clusters::new(&mesh, &vec![[1.0; 3]; shape.positions.len()], Threads::ONE);
    assert!(collapsed.bounds().iter().all(|bound| whole(bound, light).is_none()));
    Ok(())
}
