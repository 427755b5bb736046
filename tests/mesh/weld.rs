//! Welding against a brute-force oracle that is written from its definition.

use rimline::mesh::{Weld, WeldCounts};
use rimline::{Geometry, GeometryOptions, Influences, Mesh};
use rimline_testkit::random::Random;

/// The definition, word for word and quadratic.
mod oracle {
    use super::{Geometry, Weld, WeldCounts};

    /// Equal, −0 like +0; a NaN equals itself if all its bits do.
    fn same_number(a: f32, b: f32) -> bool {
        a == b || (a.is_nan() && a.to_bits() == b.to_bits())
    }

    fn same_vector(a: [f32; 3], b: [f32; 3]) -> bool {
        (0..3).all(|c| same_number(a[c], b[c]))
    }

    /// A geometry's parts, which a test may spoil.
    #[derive(Clone, Debug, PartialEq)]
    pub(crate) struct Parts {
        pub(crate) positions: Vec<[f32; 3]>,
        pub(crate) faces: Vec<[u32; 3]>,
        pub(crate) morph_targets: Vec<Vec<[f32; 3]>>,
        /// Joints and weights of each vertex.
        pub(crate) entries: Vec<Vec<(u32, f32)>>,
        pub(crate) source_vertices: Vec<u32>,
    }

    impl From<&Geometry> for Parts {
        fn from(geometry: &Geometry) -> Self {
            let entries = |v: usize| {
                let Some(influences) = geometry.influences() else { return Vec::new() };
                let range = influences.offsets()[v] as usize..influences.offsets()[v + 1] as usize;
                range.map(|entry| (influences.joints()[entry], influences.weights()[entry])).collect()
            };
            Self {
                positions: geometry.positions().to_vec(),
                faces: geometry.faces().to_vec(),
                morph_targets: geometry.morph_targets().to_vec(),
                entries: (0..geometry.positions().len()).map(entries).collect(),
                source_vertices: geometry.source_vertices().to_vec(),
            }
        }
    }

    fn same(geometry: &Parts, a: usize, b: usize, weld: Weld) -> bool {
        let position = same_vector(geometry.positions[a], geometry.positions[b]);
        let data = || {
            geometry.morph_targets.iter().all(|target| same_vector(target[a], target[b]))
                && geometry.entries[a] == geometry.entries[b]
        };
        match weld {
            Weld::Keep => a == b,
            Weld::Position => position,
            Weld::Data => position && data(),
            Weld::Distance(_) => unreachable!("`near.rs` has an oracle for distances"),
        }
    }

    /// For every vertex the lowest one that it is the same as.
    pub(crate) fn groups(geometry: &Parts, weld: Weld) -> Vec<usize> {
        let count = geometry.positions.len();
        let lowest = |v: usize| (0..v).find(|&first| same(geometry, first, v, weld)).unwrap_or(v);
        (0..count).map(lowest).collect()
    }

    pub(crate) fn counts(geometry: &Parts, weld: Weld) -> WeldCounts {
        let after = |weld| groups(geometry, weld).iter().enumerate().filter(|&(v, &group)| v == group).count();
        let apart = if weld == Weld::Keep { 0 } else { after(weld) - after(Weld::Position) };
        let groups = groups(geometry, weld);
        let is_degenerate = |[a, b, c]: [usize; 3]| a == b || b == c || c == a;
        let faces = geometry.faces.iter().map(|face| face.map(|v| v as usize));
        let collapsed = faces.filter(|&face| !is_degenerate(face) && is_degenerate(face.map(|v| groups[v]))).count();
        WeldCounts { before: geometry.positions.len(), after: after(weld), apart, collapsed, wide: 0 }
    }

    /// The first part of a welded geometry that is wrong.
    pub(crate) fn difference(source: &Parts, welded: &Parts, weld: Weld) -> Option<String> {
        let groups = groups(source, weld);
        let kept: Vec<usize> = (0..groups.len()).filter(|&v| groups[v] == v).collect();
        let bits = |vectors: &[[f32; 3]], of: &[usize]| -> Vec<[u32; 3]> {
            of.iter().map(|&v| vectors[v].map(f32::to_bits)).collect()
        };
        let all: Vec<usize> = (0..welded.positions.len()).collect();
        if bits(&welded.positions, &all) != bits(&source.positions, &kept) {
            return Some("positions".to_owned());
        }
        if welded.source_vertices != kept.iter().map(|&v| v as u32).collect::<Vec<_>>() {
            return Some("source vertices".to_owned());
        }
        for (new, old) in welded.morph_targets.iter().zip(&source.morph_targets) {
            if bits(new, &all) != bits(old, &kept) {
                return Some("morph targets".to_owned());
            }
        }
        if all.iter().zip(&kept).any(|(&new, &old)| welded.entries[new] != source.entries[old]) {
            return Some("influences".to_owned());
        }
        let renamed =
            |v: u32| kept.iter().position(|&k| k == groups[v as usize]).expect("a group's lowest is kept") as u32;
        let faces: Vec<[u32; 3]> = source.faces.iter().map(|face| face.map(renamed)).collect();
        (welded.faces != faces).then(|| "faces".to_owned())
    }
}

/// Vertices of few positions, offsets, joints and weights, so that many are the same in all but one of these. Zeros have
/// both signs, and some components are no numbers.
fn geometry(seed: u64) -> Geometry {
    let mut random = Random::new(seed);
    let numbers = [0.0, -0.0, 0.0, -0.0, 1.0, -1.0, f32::MIN_POSITIVE, f32::NAN, f32::from_bits(0x7fc0_0001)];
    let few = if seed.is_multiple_of(2) { 4 } else { numbers.len() };
    let count = 2 + random.below(60);
    let vector = |random: &mut Random| [(); 3].map(|()| numbers[random.below(few)]);
    let targets = random.below(3);
    let list = |random: &mut Random| (0..count).map(|_| vector(random)).collect::<Vec<_>>();
    let positions = list(&mut random);
    let morph_targets = (0..targets).map(|_| list(&mut random)).collect();
    let skinned = random.below(3) > 0;
    let influences = skinned.then(|| {
        let (mut offsets, mut joints, mut all_weights) = (vec![0], Vec::new(), Vec::new());
        for _ in 0..count {
            // One joint or two, of weights that are the same in one case of four.
            let weights = [&[1.0][..], &[0.5, 0.5], &[0.25, 0.75], &[0.75, 0.25]][random.below(4)];
            for &weight in weights {
                joints.push(random.below(2) as u32);
                all_weights.push(weight);
            }
            offsets.push(joints.len() as u32);
        }
        Influences::new(offsets, joints, all_weights).expect("good influences")
    });
    let faces = (0..=random.below(20)).map(|_| [(); 3].map(|()| random.below(count) as u32)).collect();
    let options = GeometryOptions { morph_targets, influences, ..GeometryOptions::default() };
    Geometry::new(positions, faces, options).expect("a good geometry")
}

#[test]
fn geometries_weld_as_defined() {
    let (mut welded_away, mut apart) = (0, 0);
    for seed in 0..400 {
        let source = geometry(seed);
        for weld in [Weld::Data, Weld::Position, Weld::Keep] {
            let (welded, counts) = source.welded(weld);
            assert_eq!(oracle::difference(&(&source).into(), &(&welded).into(), weld), None, "seed {seed}, {weld:?}");
            assert_eq!(counts, oracle::counts(&(&source).into(), weld), "seed {seed}, {weld:?}");
            welded_away += counts.before - counts.after;
            apart += counts.apart;
        }
    }
    assert!(welded_away > 1000 && apart > 1000, "{welded_away} vertices welded, {apart} apart: too few to tell");
}

#[test]
fn meshes_weld_as_defined() {
    for seed in 0..400 {
        let source = geometry(seed);
        for weld in [Weld::Data, Weld::Position, Weld::Keep] {
            let mesh = Mesh::new(source.positions(), source.faces(), weld).expect("a mesh");
            // Positions are all that a mesh has.
            let by = if weld == Weld::Keep { weld } else { Weld::Position };
            let groups = oracle::groups(&(&source).into(), by);
            let faces: Vec<[u32; 3]> =
                source.faces().iter().map(|face| face.map(|v| groups[v as usize] as u32)).collect();
            assert_eq!(mesh.faces(), faces, "seed {seed}, {weld:?}");
            assert_eq!(mesh.weld_counts(), oracle::counts(&(&source).into(), by), "seed {seed}, {weld:?}");
        }
    }
}

#[test]
fn the_comparison_notices_one_change() {
    let mut noticed = [0; 5];
    for seed in 0..40 {
        let source = geometry(seed);
        let good = oracle::Parts::from(&source.welded(Weld::Data).0);
        let source = oracle::Parts::from(&source);
        let changes: [fn(&mut oracle::Parts); 5] = [
            |g| g.positions[0][1] = 9.0,
            |g| g.faces[0][0] ^= 1,
            |g| g.source_vertices[0] += 1,
            |g| g.morph_targets.iter_mut().for_each(|target| target[0][2] = 9.0),
            |g| g.entries.iter_mut().take(1).flatten().take(1).for_each(|entry| entry.1 += 0.125),
        ];
        for (change, noticed) in changes.iter().zip(&mut noticed) {
            let mut bad = good.clone();
            change(&mut bad);
            *noticed += usize::from(bad != good && oracle::difference(&source, &bad, Weld::Data).is_some());
        }
    }
    assert!(noticed.iter().all(|&times| times > 10), "{noticed:?}");
}

/// Positions whose hashes all met in one entry of the table while the hash was not keyed: multiply and rotate, low bits. The
/// third word is chosen so that the others' share of the low bits is undone.
fn colliding(count: usize) -> Vec<[f32; 3]> {
    const FACTOR: u64 = 0x517c_c1b7_2722_0a95;
    const BITS: u32 = 19;
    let mask = (1_u64 << BITS) - 1;
    // Last words whose product has low bits 0: what their upper half adds, and the word.
    let mut last = std::collections::HashMap::new();
    for top in 0..1_u64 << (32 - BITS) {
        let word = top << BITS;
        last.entry((word.wrapping_mul(FACTOR) >> 32) & mask).or_insert(word);
    }
    let mut positions = Vec::new();
    for (x, y) in (1..).flat_map(|x: u32| (0..4096).map(move |y| (x << 12, 0x3f80_0000 + y))) {
        let before = u64::from(x).wrapping_mul(FACTOR);
        let before = (before.rotate_left(5) ^ u64::from(y)).wrapping_mul(FACTOR).rotate_left(5);
        // The lower half of `before` is taken back by the last word; the upper half stays.
        let (upper, lower) = (before >> 32, before & 0xffff_ffff);
        let wanted = upper.wrapping_mul(FACTOR).wrapping_neg() & mask;
        if let Some(&word) = last.get(&wanted) {
            positions.push([x, y, (word ^ lower) as u32].map(f32::from_bits));
        }
        if positions.len() == count {
            break;
        }
    }
    positions
}

/// A reproduction: 1.6 MB of positions took half a minute with a hash that one could know beforehand, and these, twice
/// as many, two minutes.
#[test]
fn positions_chosen_to_collide_weld_in_time() {
    let positions = colliding(1 << 18);
    assert_eq!(positions.len(), 1 << 18);
    let mesh = Mesh::new(&positions, &[[0, 1, 2]], Weld::Position).expect("a mesh");
    assert_eq!(mesh.weld_counts().after, positions.len());
}
