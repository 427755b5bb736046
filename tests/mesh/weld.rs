//! Welding by positions and by data, against a brute-force oracle that is written from its definition.

use rimline::mesh::{Weld, WeldCounts};
use rimline::{Geometry, GeometryOptions, Influences, Mesh};
use rimline_testkit::random::Random;

/// A geometry's parts, floats as bits.
#[derive(Debug, PartialEq)]
struct Parts {
    positions: Vec<[u32; 3]>,
    faces: Vec<[u32; 3]>,
    morph_targets: Vec<Vec<[u32; 3]>>,
    /// The joints of each vertex, each with its weight.
    entries: Vec<Vec<[u32; 2]>>,
    source_vertices: Vec<u32>,
}

impl From<&Geometry> for Parts {
    fn from(geometry: &Geometry) -> Self {
        let bits = |vectors: &[[f32; 3]]| vectors.iter().map(|vector| vector.map(f32::to_bits)).collect();
        let entries = |v: usize| {
            let Some(influences) = geometry.influences() else { return Vec::new() };
            let range = influences.offsets()[v] as usize..influences.offsets()[v + 1] as usize;
            range.map(|entry| [influences.joints()[entry], influences.weights()[entry].to_bits()]).collect()
        };
        Self {
            positions: bits(geometry.positions()),
            faces: geometry.faces().to_vec(),
            morph_targets: geometry.morph_targets().iter().map(|target| bits(target)).collect(),
            entries: (0..geometry.positions().len()).map(entries).collect(),
            source_vertices: geometry.source_vertices().to_vec(),
        }
    }
}

/// The bits of a float, those of +0 for −0.
fn without_sign_of_zero(bits: u32) -> u32 {
    if bits == 1 << 31 { 0 } else { bits }
}

impl Parts {
    /// The definition, word for word and quadratic: for every vertex the lowest one that it is the same as. Floats are
    /// the same if their bits are, also those of NaN; −0 is the same as +0.
    fn groups(&self, weld: Weld) -> Vec<usize> {
        let same_vector = |a: [u32; 3], b: [u32; 3]| a.map(without_sign_of_zero) == b.map(without_sign_of_zero);
        let entries = |v: usize| self.entries[v].iter().map(|&[joint, weight]| [joint, without_sign_of_zero(weight)]);
        let same = |a: usize, b: usize| {
            let position = same_vector(self.positions[a], self.positions[b]);
            let data = || {
                self.morph_targets.iter().all(|target| same_vector(target[a], target[b])) && entries(a).eq(entries(b))
            };
            match weld {
                Weld::Keep => a == b,
                Weld::Position => position,
                Weld::Data => position && data(),
                Weld::Distance(_) => unreachable!("`near.rs` has an oracle for distances"),
            }
        };
        let lowest = |v: usize| (0..v).find(|&first| same(first, v)).unwrap_or(v);
        (0..self.positions.len()).map(lowest).collect()
    }

    fn kept(&self, weld: Weld) -> Vec<usize> {
        self.groups(weld).into_iter().enumerate().filter(|&(v, group)| v == group).map(|(v, _)| v).collect()
    }

    fn counts(&self, weld: Weld) -> WeldCounts {
        let [before, after, distinct] = [Weld::Keep, weld, Weld::Position].map(|weld| self.kept(weld).len());
        let groups = self.groups(weld);
        let is_degenerate = |[a, b, c]: [usize; 3]| a == b || b == c || c == a;
        let faces = self.faces.iter().map(|face| face.map(|v| v as usize));
        let collapsed = faces.filter(|&face| !is_degenerate(face) && is_degenerate(face.map(|v| groups[v]))).count();
        WeldCounts { before, after, apart: if weld == Weld::Keep { 0 } else { after - distinct }, collapsed, wide: 0 }
    }

    fn welded(&self, weld: Weld) -> Self {
        let (groups, kept) = (self.groups(weld), self.kept(weld));
        let pick = |list: &[[u32; 3]]| kept.iter().map(|&v| list[v]).collect::<Vec<_>>();
        let renamed = |v: u32| kept.iter().position(|&k| k == groups[v as usize]).expect("the lowest is kept") as u32;
        Self {
            positions: pick(&self.positions),
            faces: self.faces.iter().map(|face| face.map(renamed)).collect(),
            morph_targets: self.morph_targets.iter().map(|target| pick(target)).collect(),
            entries: kept.iter().map(|&v| self.entries[v].clone()).collect(),
            source_vertices: kept.iter().map(|&v| self.source_vertices[v]).collect(),
        }
    }
}

/// Vertices of few positions, offsets, joints and weights, so that many are the same in all but one of these. Zeros have
/// both signs. Vectors of odd seeds may have components that are infinite or NaN.
fn geometry(seed: u64) -> Geometry {
    let mut random = Random::new(seed);
    let [subnormal, nan] = [1, 0x7fc0_0001].map(f32::from_bits);
    let numbers = [0.0, -0.0, 0.0, -0.0, 1.0, -1.0, subnormal, f32::INFINITY, f32::NAN, nan];
    let few = if seed.is_multiple_of(2) { 5 } else { numbers.len() };
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
            // Up to two joints. Some weights are the same but for their order, or the sign of a zero.
            let choices = [&[1.0][..], &[], &[0.5, 0.5], &[0.25, 0.75], &[0.75, 0.25], &[0.0, 1.0], &[-0.0, 1.0]];
            for &weight in choices[random.below(choices.len())] {
                joints.push(random.below(2) as u32);
                all_weights.push(weight);
            }
            offsets.push(joints.len() as u32);
        }
        Influences::new(offsets, joints, all_weights).expect("good influences")
    });
    let faces = (0..=random.below(20)).map(|_| [(); 3].map(|()| random.below(count) as u32)).collect();
    let source_vertices = (random.below(2) == 0).then(|| (0..count).map(|_| random.below(100) as u32).collect());
    let options = GeometryOptions { morph_targets, influences, source_vertices, ..GeometryOptions::default() };
    Geometry::new(positions, faces, options).expect("a good geometry")
}

/// A mesh has no data but positions, so that [`Weld::Data`] is [`Weld::Position`] there.
#[test]
fn geometries_and_meshes_weld_as_defined() {
    let (mut welded_away, mut apart) = (0, 0);
    for seed in 0..400 {
        let source = geometry(seed);
        let parts = Parts::from(&source);
        for weld in [Weld::Data, Weld::Position, Weld::Keep] {
            let (welded, counts) = source.welded(weld);
            assert_eq!(Parts::from(&welded), parts.welded(weld), "seed {seed}, {weld:?}");
            assert_eq!(counts, parts.counts(weld), "seed {seed}, {weld:?}");
            welded_away += counts.before - counts.after;
            apart += counts.apart;
            let mesh = Mesh::new(source.positions(), source.faces(), weld).expect("a mesh");
            let by = if weld == Weld::Keep { weld } else { Weld::Position };
            let groups = parts.groups(by);
            let faces: Vec<[u32; 3]> = parts.faces.iter().map(|face| face.map(|v| groups[v as usize] as u32)).collect();
            assert_eq!(mesh.faces(), faces, "seed {seed}, {weld:?}");
            assert_eq!(mesh.weld_counts(), parts.counts(by), "seed {seed}, {weld:?}");
        }
    }
    assert!(welded_away > 1000 && apart > 1000, "{welded_away} vertices welded, {apart} apart: too few to tell");
}
