//! The occluded faces that are left out are those without which the fewest sides are drawn.

use rimline::cpu::{OccludedFaces, OcclusionOptions};
use rimline::mesh::EdgeKind;
use rimline_testkit::random::Random;

use crate::occluded_faces::{all_left_out, faces_light, find};
use crate::static_scenes::{Caster, StaticScene};

/// The sides of a caster of which some faces cast, by the definition: a face adds its direction to each of its records, and
/// the opposite direction if it faces the light.
fn sides(caster: &Caster, facing: &[bool], casts: impl Fn(u32) -> bool) -> u32 {
    let add = |face: u32, direction: i32| match (casts(face), facing[face as usize]) {
        (false, _) => 0,
        (true, true) => -direction,
        (true, false) => direction,
    };
    let of_record = |edge: rimline::mesh::Edge| {
        let along = if edge.kind == EdgeKind::Inconsistent { 1 } else { -1 };
        (add(edge.face_0, 1) + edge.face_1.map_or(0, |face| add(face, along))).unsigned_abs()
    };
    caster.mesh.edges().iter().map(of_record).sum()
}

/// Sides where back-facing faces of closed casters cast, and where every face does.
fn both_ways(caster: &Caster, facing: &[bool], left_out: &[u32]) -> [u32; 2] {
    let is_closed = caster.mesh.is_closed();
    [true, false].map(|back_facing| {
        sides(caster, facing, |face| !(left_out.contains(&face) || back_facing && is_closed && facing[face as usize]))
    })
}

/// Asks whether what is left out has no more sides than any other choice among the occluded faces. Says how many
/// choices it tried.
fn check(caster: &Caster, facing: &[bool], occluded: &[u32], left_out: &[u32]) -> Result<usize, String> {
    if let Some(face) = left_out.iter().find(|face| !occluded.contains(face)) {
        return Err(format!("face {face} is left out and not occluded"));
    }
    let found = both_ways(caster, facing, left_out);
    let no_more = |of: [u32; 2]| found.iter().zip(of).all(|(found, of)| *found <= of);
    let all = both_ways(caster, facing, &[]);
    if !no_more(all) || !no_more(both_ways(caster, facing, occluded)) {
        return Err(format!("{found:?} sides, and {all:?} with all faces"));
    }
    if occluded.len() > 10 {
        return Ok(0);
    }
    for choice in 0..1_u32 << occluded.len() {
        let other: Vec<u32> =
            (0..).zip(occluded).filter(|(bit, _)| choice >> bit & 1 != 0).map(|(_, &face)| face).collect();
        let of = both_ways(caster, facing, &other);
        if !no_more(of) || (of == found && other.len() > left_out.len()) {
            return Err(format!("{found:?} sides without {left_out:?}, and {of:?} without {other:?}"));
        }
    }
    Ok(1 << occluded.len())
}

#[test]
fn no_other_choice_has_fewer_sides() {
    let (mut tried, mut kept, mut grown, mut fewer, mut refuted) = (0, 0, 0, 0, 0);
    for seed in 5400..5900 {
        let scene = StaticScene::random(seed);
        let mut random = Random::new(seed);
        let all = find(&scene, all_left_out());
        let found = find(&scene, OcclusionOptions::default());
        let statistics = found.statistics();
        let [mut before, mut left] = [0, 0];
        for (number, caster) in scene.casters.iter().enumerate() {
            let facing: Vec<bool> =
                (0..caster.mesh.faces().len()).map(|face| faces_light(caster, face, scene.light)).collect();
            let of = |found: &OccludedFaces| found.faces(number).to_vec();
            let (occluded, left_out) = (of(&all), of(&found));
            tried +=
                check(caster, &facing, &occluded, &left_out).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            before += both_ways(caster, &facing, &[])[0] as usize;
            left += both_ways(caster, &facing, &left_out)[0] as usize;
            // One face more or less must be worse, as a rule.
            if !occluded.is_empty() {
                let face = occluded[random.below(occluded.len())];
                let mut wrong = left_out.clone();
                match wrong.iter().position(|left| *left == face) {
                    Some(at) => drop(wrong.remove(at)),
                    None => wrong.push(face),
                }
                refuted += usize::from(check(caster, &facing, &occluded, &wrong).is_err());
            }
        }
        assert_eq!([statistics.sides, statistics.sides_left], [before, left], "seed {seed}");
        assert_eq!(statistics.occluded, all.statistics().left_out, "seed {seed}");
        assert!(left <= before, "seed {seed}");
        fewer += usize::from(left < before);
        grown += usize::from(all.statistics().sides_left > before);
        kept += statistics.occluded - statistics.left_out;
    }
    println!(
        "{tried} choices tried; sides fall in {fewer} scenes; {kept} occluded faces cast; without all of them sides would grow in \
         {grown} scenes; {refuted} wrong choices refuted"
    );
    assert!(tried > 5000 && fewer > 200 && kept > 100 && grown > 20 && refuted > 100);
}
