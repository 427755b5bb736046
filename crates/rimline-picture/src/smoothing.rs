//! Shading normals that the device computes, from the positions that are there.

use std::collections::HashMap;

use crate::bindings::{READ_ONLY, WRITTEN, group, layout};
use crate::factory::{COMMON, PipelineFactory};
use crate::normals::Neighbours;

/// Corners that share a normal, in groups. The normal of a group is the sum over its faces by area.
#[derive(Clone, Debug, Default)]
pub struct Smoothing {
    /// Where the faces and the corners of each group begin, and at last where they end.
    starts: Vec<[u32; 2]>,
    faces: Vec<u32>,
    corners: Vec<u32>,
}

/// Faces of all groups that there may be in any mesh. At the tip of a cone each face has neighbours of its own, a third of all.
const MOST_MEMBERS: usize = 1 << 24;
/// The most faces, and corners, of a group that one invocation takes, as in `normals.wgsl`.
const PIECE: u32 = 4096;
/// Words of a piece of a larger group there. Three of those behind the sixth are its sum, which the device computes.
const PIECE_WORDS: usize = 12;

impl Smoothing {
    /// Smooths a mesh by the angles of its faces at these positions. Vertices at one position are one. Where groups would take
    /// far more memory than the mesh, faces stay flat.
    pub fn of(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Self {
        Self::within(positions, faces, MOST_MEMBERS.max(4 * 3 * faces.len()))
    }

    /// The same with so many faces of all groups, and a few more.
    fn within(positions: &[[f32; 3]], faces: &[[u32; 3]], most: usize) -> Self {
        let mut first_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
        let same: Vec<u32> = (0..)
            .zip(positions)
            .map(|(vertex, position)| *first_at.entry(position.map(|c| (c + 0.0).to_bits())).or_insert(vertex))
            .collect();
        let near = Neighbours::new(positions, faces, Some(&same));
        // The faces of each group, and where they begin; the groups of each vertex, which are few; the group of each corner.
        let (mut members, mut starts) = (Vec::new(), vec![0]);
        let mut known: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
        let mut groups: Vec<u32> = Vec::with_capacity(3 * faces.len());
        // Groups at vertices of many faces, by rounded normals.
        let mut shared: HashMap<(u32, [i8; 3]), u32> = HashMap::new();
        for (corner, &vertex) in faces.as_flattened().iter().enumerate() {
            let (face, vertex, first) = (corner / 3, same[vertex as usize], members.len());
            let key = near.rounded(face, vertex).map(|rounded| (vertex, rounded));
            if let Some(&group) = key.and_then(|key| shared.get(&key)) {
                groups.push(group);
                continue;
            }
            let is_within = first < most;
            if is_within {
                members.extend(near.of(face, vertex).map(|other| other as u32));
            }
            if members.len() == first {
                members.push(face as u32);
            }
            let of = |group: u32| starts[group as usize]..starts[group as usize + 1];
            let is_same = |group: &u32| members[of(*group)] == members[first..];
            // Behind the bound each face is alone, and a vertex may have as many groups as faces.
            let found = if is_within { known[vertex as usize].iter().copied().find(is_same) } else { None };
            if found.is_some() {
                members.truncate(first);
            } else {
                known[vertex as usize].push(starts.len() as u32 - 1);
                starts.push(members.len());
            }
            let group = found.unwrap_or(starts.len() as u32 - 2);
            groups.push(group);
            shared.extend(key.map(|key| (key, group)));
        }
        Self::of_groups(members, &starts, &groups)
    }

    /// `starts`: where the faces of each group begin, and at last where they end. `groups`: the group of each corner.
    fn of_groups(faces: Vec<u32>, starts: &[usize], groups: &[u32]) -> Self {
        let mut corners: Vec<u32> = (0..groups.len() as u32).collect();
        corners.sort_by_key(|&corner| groups[corner as usize]);
        let mut ends = vec![0; starts.len()];
        for &group in groups {
            ends[group as usize + 1] += 1;
        }
        let mut end = 0;
        let starts = starts.iter().zip(ends).map(|(&face, corners)| {
            end += corners;
            [face as u32, end]
        });
        Self { starts: starts.collect(), faces, corners }
    }

    /// Keeps every face flat.
    pub fn flat(faces: &[[u32; 3]]) -> Self {
        let faces = 0..faces.len() as u32;
        let starts = faces.clone().chain([faces.end]).map(|face| [face, 3 * face]).collect();
        Self { starts, corners: (0..3 * faces.end).collect(), faces: faces.collect() }
    }

    /// Adds another mesh behind, whose faces have the last two corners swapped if they are turned.
    pub fn append(&mut self, other: &Self, is_turned: bool) {
        if self.starts.is_empty() {
            self.starts.push([0; 2]);
        }
        let (faces, corners) = (self.faces.len() as u32, self.corners.len() as u32);
        let (first_face, first_corner) = (corners / 3, corners);
        let swapped = |corner: u32| match corner % 3 {
            1 if is_turned => corner + 1,
            2 if is_turned => corner - 1,
            _ => corner,
        };
        self.faces.extend(other.faces.iter().map(|face| face + first_face));
        self.corners.extend(other.corners.iter().map(|&corner| swapped(corner) + first_corner));
        self.starts.extend(other.starts.iter().skip(1).map(|[face, corner]| [face + faces, corner + corners]));
    }

    /// The pieces of groups that are too large for one invocation.
    fn pieces(&self) -> Vec<[u32; PIECE_WORDS]> {
        let mut pieces = Vec::new();
        for (begin, end) in self.starts.iter().zip(self.starts.iter().skip(1)) {
            let [faces, corners] = [0, 1].map(|kind: usize| end[kind] - begin[kind]);
            let (count, first) = (faces.max(corners).div_ceil(PIECE), pieces.len() as u32);
            for number in 0..if count > 1 { count } else { 0 } {
                let at = |kind: usize, number: u32| end[kind].min(begin[kind] + PIECE * number);
                let mut words = [0; PIECE_WORDS];
                words[..4].copy_from_slice(&[at(0, number), at(0, number + 1), at(1, number), at(1, number + 1)]);
                words[4..6].copy_from_slice(&[first, first + count]);
                pieces.push(words);
            }
        }
        pieces
    }
}

/// Computes normals on the device, from the positions that are there.
#[derive(Debug)]
pub struct NormalPipeline {
    layout: wgpu::BindGroupLayout,
    of_groups: wgpu::ComputePipeline,
    of_pieces: [wgpu::ComputePipeline; 2],
}

/// The normals of a mesh on the device.
#[derive(Debug)]
pub struct Normals {
    /// One a corner, as [`crate::corner_normals`] has them.
    pub buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
    groups: u32,
    pieces: u32,
}

impl NormalPipeline {
    /// On a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let types = [READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY, WRITTEN, WRITTEN];
        let layout = layout(device, wgpu::ShaderStages::COMPUTE, &types);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("normals"),
            source: wgpu::ShaderSource::Wgsl(format!("{COMMON}\n{}", include_str!("normals.wgsl")).into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("normals"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let of_pieces = ["sums_of_pieces", "normals_of_pieces"].map(pipeline);
        Self { layout, of_groups: pipeline("normals_of_groups"), of_pieces }
    }

    /// Normals of a mesh with these buffers of positions and faces. `smoothing` is of at least one mesh, not the default.
    pub fn normals(
        &self,
        factory: &PipelineFactory,
        smoothing: &Smoothing,
        [positions, faces]: [&wgpu::Buffer; 2],
    ) -> Normals {
        let stored = |label, words: &[u32]| factory.buffer(label, bytemuck::cast_slice(words));
        let starts = stored("starts", smoothing.starts.as_flattened());
        let (members, corners) = (stored("members", &smoothing.faces), stored("corners", &smoothing.corners));
        let buffer = stored("normals", &vec![0; smoothing.corners.len()]);
        let mut pieces = smoothing.pieces();
        let count = pieces.len() as u32;
        // Bindings are never empty.
        pieces.resize(pieces.len().max(1), [0; PIECE_WORDS]);
        let pieces = stored("pieces", pieces.as_flattened());
        let bound = [positions, faces, &starts, &members, &corners, &buffer, &pieces];
        let group = group(&factory.device, &self.layout, &bound.map(wgpu::Buffer::as_entire_binding));
        Normals { buffer, group, groups: smoothing.starts.len() as u32 - 1, pieces: count }
    }

    /// Records the computation.
    pub fn encode<'n>(&self, encoder: &mut wgpu::CommandEncoder, normals: impl IntoIterator<Item = &'n Normals>) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("normals"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        for &Normals { ref group, groups, pieces, .. } in normals {
            pass.set_bind_group(0, group, &[]);
            let of_pieces = self.of_pieces.iter().map(|pipeline| (pipeline, pieces));
            for (pipeline, invocations) in [(&self.of_groups, groups)].into_iter().chain(of_pieces) {
                let workgroups = invocations.div_ceil(64);
                let across = workgroups.min(65_535);
                if workgroups > 0 {
                    pass.set_pipeline(pipeline);
                    pass.dispatch_workgroups(across, workgroups.div_ceil(across), 1);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normals::tests::fan;

    #[test]
    fn the_tip_of_a_cone_takes_no_more_memory_than_there_may_be() {
        const SIDES: u32 = 60;
        let (positions, faces) = fan(SIDES, 10.0);
        // A third of the sides for each of them at the tip; below, corners of a ring vertex share two.
        let whole = Smoothing::of(&positions, &faces);
        assert!(whole.faces.len() > (SIDES * SIDES / 4) as usize, "{}", whole.faces.len());
        let bounded = Smoothing::within(&positions, &faces, 300);
        assert!(bounded.faces.len() < 300 + 3 * SIDES as usize, "{}", bounded.faces.len());
        let mut corners = bounded.corners.clone();
        corners.sort_unstable();
        assert_eq!(corners, (0..3 * SIDES).collect::<Vec<_>>());
        assert_eq!(bounded.starts.last(), Some(&[bounded.faces.len() as u32, 3 * SIDES]));
    }

    #[test]
    fn a_large_fan_has_few_groups_at_its_tip() {
        const SIDES: u32 = 200_000;
        let (positions, faces) = fan(SIDES, 0.0);
        let fan = Smoothing::of(&positions, &faces);
        // All share one at the tip, and two each at the ring.
        assert_eq!(fan.faces.len(), 3 * SIDES as usize);
        assert_eq!(fan.corners.len(), 3 * SIDES as usize);
        // The one at the tip is in pieces, one after the other.
        let pieces = fan.pieces();
        let count = SIDES.div_ceil(PIECE);
        assert_eq!(pieces.len(), count as usize);
        for at in [0, 2] {
            let ends: Vec<_> = pieces.iter().map(|piece| [piece[at], piece[at + 1]]).collect();
            assert!(ends.windows(2).all(|pair| pair[0][1] == pair[1][0]), "{ends:?}");
            assert!(ends.iter().all(|[begin, end]| end - begin <= PIECE), "{ends:?}");
            assert_eq!(ends[ends.len() - 1][1] - ends[0][0], SIDES, "{ends:?}");
        }
        assert!(pieces.iter().all(|piece| piece[4..6] == [0, count]));
        assert!(Smoothing::flat(&faces).pieces().is_empty());
    }

    #[test]
    fn corners_share_normals_up_to_creases() {
        let groups = |height: f32, is_turned: bool| {
            let positions = [[0.0; 3], [0.0, 0.0, 1.0], [-1.0, height, 0.0], [1.0, height, 0.0]];
            let one = Smoothing::of(&positions, &[[0, 2, 1], [0, 1, 3]]);
            let mut both = Smoothing::default();
            both.append(&one, false);
            both.append(&one, is_turned);
            let each = both.starts.windows(2).map(|of| {
                let [from, to] = [of[0], of[1]].map(|at| at.map(|word| word as usize));
                (both.faces[from[0]..to[0]].to_vec(), both.corners[from[1]..to[1]].to_vec())
            });
            each.collect::<Vec<_>>()
        };
        let gentle = groups(0.1, true);
        // The first vertex has both faces, and so have its corners; the second mesh is behind, with its faces turned.
        assert!(gentle.contains(&(vec![0, 1], vec![0, 3])) && gentle.contains(&(vec![0, 1], vec![2, 4])));
        assert!(gentle.contains(&(vec![2, 3], vec![6, 9])) && gentle.contains(&(vec![2, 3], vec![7, 11])));
        let sharp = groups(2.0, false);
        assert!(sharp.contains(&(vec![0], vec![0])) && sharp.contains(&(vec![1], vec![3])));
        assert_eq!(sharp.iter().map(|(_, corners)| corners.len()).sum::<usize>(), 12);
    }
}
