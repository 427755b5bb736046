//! Selection and order of the measurements.

use std::time::Duration;

use rimline_bench::stress;

use super::args::{BenchArgs, Number};
use super::bench_mesh::BenchMesh;
use super::casters::CastersPlan;
use super::measure::Rounds;
use super::shadows::ShadowPlan;
use super::skip::SkipPlan;
use super::skip::scenes::SkipScene;
use crate::device::Wanted;
use crate::failure::UsageError;

/// Rows to come.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Each with its numbers of lights.
    pub(crate) subjects: Vec<(BenchMesh, Vec<usize>)>,
    pub(crate) rounds: Rounds,
    pub(crate) shadows: ShadowPlan,
    pub(crate) casters: CastersPlan,
    pub(crate) skipping: SkipPlan,
}

const MESHES: [usize; 7] = [1 << 10, 1 << 12, 1 << 14, 1 << 16, 1 << 18, 1 << 20, 1 << 22];
const QUICK_MESHES: [usize; 3] = [1 << 10, 1 << 14, 1 << 18];
const SCENE_FACES: usize = 1 << 16;
const QUICK_SCENE_FACES: usize = 1 << 14;
/// One scene of each class.
const QUICK_SCENES: [&str; 10] = [
    "translation-1e6",
    "scale-1e-20",
    "subnormal-thickness",
    "slivers-1e6",
    "plate-third",
    "lights-on-faces",
    "afar-1e6",
    "bent-179",
    "noise-1e-6",
    "touching-boxes",
];
const LIGHTS: [usize; 3] = [1, 8, 32];
/// Beside the names of stress scenes: the scenes of many casters, and those that measure skipping.
const CASTERS: &str = "casters";
const SKIPPING: [&str; 5] = ["still", "city", "crowd", "moving", "big"];
const NUMBERS_OF_CASTERS: [usize; 6] = [1, 10, 100, 200, 1000, 10_000];
const QUICK_NUMBERS_OF_CASTERS: [usize; 3] = [1, 10, 100];
/// Faces of a single caster.
const ONE_CASTER: [usize; 3] = [1 << 10, 1 << 14, 1 << 20];
const QUICK_ONE_CASTER: [usize; 2] = [1 << 10, 1 << 14];

impl Plan {
    pub(crate) fn new(args: &BenchArgs) -> Result<Self, UsageError> {
        let meshes: Vec<usize> = match &args.meshes {
            None if args.quick => QUICK_MESHES.into(),
            None => MESHES.into(),
            Some(faces) => Number::counts(faces),
        };
        let scene_faces = match args.scene_faces {
            Some(faces) => faces as usize,
            None if args.quick => QUICK_SCENE_FACES,
            None => SCENE_FACES,
        };
        let given: Option<Vec<usize>> =
            args.lights.as_ref().map(|lights| lights.iter().copied().map(usize::from).collect());
        let lights_of_meshes = given.clone().unwrap_or_else(|| LIGHTS.into());
        let lights_of_scenes = given.unwrap_or_else(|| vec![8]);
        let mut subjects: Vec<_> =
            meshes.into_iter().map(|faces| (BenchMesh::Torus(faces), lights_of_meshes.clone())).collect();
        let Scenes { stress, casters, skipping } = Scenes::new(args)?;
        for name in stress {
            subjects.push((BenchMesh::Scene(name, scene_faces), lights_of_scenes.clone()));
        }
        let (most, seconds) = if args.quick { (9, 0.4) } else { (21, 5.0) };
        let most = args.rounds.map_or(most, usize::from);
        let rounds =
            Rounds { least: most.min(if args.quick { 3 } else { 5 }), most, time: Duration::from_secs_f64(seconds) };
        let (models, usual_frames, size) = if args.quick { (1, 6, 256) } else { (3, 16, 512) };
        // The CPU draws nothing.
        let draws = Wanted::parse(&args.device.device) != Wanted::Cpu;
        let frames = if draws { args.frames.map_or(usual_frames, usize::from) } else { 0 };
        // A round draws whole paths.
        let rounds_of_paths = Rounds { least: most.min(3), ..rounds };
        let shadows = ShadowPlan { models, frames, size, rounds: rounds_of_paths };
        // The CPU records no scenes either.
        let (numbers, scenes) = if draws { (casters, skipping) } else { (Vec::new(), Vec::new()) };
        let one_mesh = if args.quick { QUICK_ONE_CASTER.into() } else { ONE_CASTER.into() };
        let casters = CastersPlan { numbers, one_mesh, size, rounds };
        let skipping = SkipPlan { scenes, size, rounds };
        if args.depth_maps.is_none() && subjects.is_empty() && shadows.rows() + casters.rows() + skipping.rows() == 0 {
            return Err(UsageError::NothingToMeasure);
        }
        Ok(Self { subjects, rounds, shadows, casters, skipping })
    }

    /// How many rows of extraction that makes.
    pub(crate) fn rows(&self) -> usize {
        self.subjects.iter().map(|(_, lights)| lights.len()).sum()
    }
}

/// Scenes that `--scenes` and `--casters` ask for.
struct Scenes {
    /// Names of stress scenes.
    stress: Vec<&'static str>,
    /// Numbers of casters.
    casters: Vec<usize>,
    /// Scenes that measure skipping, with their numbers of casters.
    skipping: Vec<(SkipScene, usize)>,
}

/// The names of `--scenes`, by what they are of.
struct Names {
    stress: Vec<&'static str>,
    has_casters: bool,
    skipping: Vec<&'static str>,
}

impl Scenes {
    fn new(args: &BenchArgs) -> Result<Self, UsageError> {
        let Names { stress, has_casters, skipping } = Names::new(args)?;
        let given = args.casters.as_deref().map(Number::counts);
        let is_of_casters = has_casters || !skipping.is_empty();
        if !is_of_casters && given.as_ref().is_some_and(|numbers| !numbers.is_empty()) {
            return Err(UsageError::CastersWithoutScene);
        }
        let scenes = skipping.into_iter().filter_map(|name| SkipScene::named(name, args.quick)).flatten();
        let skipping = scenes.flat_map(|&scene| {
            let given = given.clone().filter(|_| !scene.is_one_mesh());
            let numbers = given.unwrap_or_else(|| vec![scene.usual(args.quick)]);
            numbers.into_iter().filter(move |number| *number <= scene.most()).map(move |number| (scene, number))
        });
        let skipping = skipping.collect();
        let usual = if args.quick { &QUICK_NUMBERS_OF_CASTERS[..] } else { &NUMBERS_OF_CASTERS };
        let casters = if has_casters { given.clone().unwrap_or_else(|| usual.into()) } else { Vec::new() };
        Ok(Self { stress, casters, skipping })
    }
}

impl Names {
    fn new(args: &BenchArgs) -> Result<Self, UsageError> {
        let all = |stress| Self { stress, has_casters: true, skipping: SKIPPING.into() };
        let Some(wanted) = &args.scenes else {
            return Ok(all(if args.quick { QUICK_SCENES.into() } else { stress::names().collect() }));
        };
        let mut names = Self { stress: Vec::new(), has_casters: false, skipping: Vec::new() };
        match wanted.as_slice() {
            [one] if one == "all" => return Ok(all(stress::names().collect())),
            [one] if one == "none" => return Ok(names),
            _ => {}
        }
        for wanted in wanted {
            if wanted == CASTERS {
                names.has_casters = true;
            } else if let Some(name) = SKIPPING.into_iter().find(|name| name == wanted) {
                names.skipping.push(name);
            } else if let Some(name) = stress::names().find(|name| name == wanted) {
                names.stress.push(name);
            } else {
                let there = stress::names().chain([CASTERS]).chain(SKIPPING).collect::<Vec<_>>().join(", ");
                return Err(UsageError::Scene { wanted: wanted.clone(), there });
            }
        }
        Ok(names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_scenes_are_one_of_each_class() {
        let class_of = |name: &&str| stress::scene(name, 1).map(|scene| scene.class);
        let classes: Vec<_> = QUICK_SCENES.iter().map(class_of).collect();
        let mut all: Vec<_> = stress::scenes(1).map(|scene| Some(scene.class)).collect();
        all.dedup();
        assert_eq!(classes, all);
    }
}
