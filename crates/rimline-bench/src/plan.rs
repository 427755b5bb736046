//! Selection and order of the measurements.

use std::time::Duration;

use crate::casters::CasterMesh;
use crate::engine::Rounds;
use crate::extraction::subject::{Model, Subject};
use crate::shadows::Frames;
use crate::skipping::scenes::SkipScene;
use crate::stress;

/// A choice of measurements. An empty list is nothing, `None` what is usual.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Less of everything.
    pub quick: bool,
    /// Face counts of the closed meshes.
    pub meshes: Option<Vec<usize>>,
    /// Names of scenes.
    pub scenes: Option<Vec<String>>,
    /// Numbers of casters.
    pub casters: Option<Vec<usize>>,
    /// The approximate number of faces of a stress scene.
    pub scene_faces: Option<usize>,
    /// Numbers of lights.
    pub lights: Option<Vec<usize>>,
    /// The largest number of counted runs.
    pub rounds: Option<usize>,
    /// Frames of each camera path for shadows.
    pub frames: Option<usize>,
    /// Only the CPU is measured, which draws nothing.
    pub cpu_only: bool,
    /// A model of the user, which is measured instead of meshes and scenes that are not asked for.
    pub model: Option<Model>,
}

/// Options that do not go together.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error("there is nothing to measure; give --meshes or --scenes a value other than `none`, or --frames on a GPU")]
    Nothing,
    #[error("there is no scene `{wanted}`; there are {there}, `all` and `none`")]
    Scene { wanted: String, there: String },
    #[error(
        "--casters is for the scenes `casters`, `still`, `city`, `crowd`, `moving` and `house`, which --scenes leaves out; add one of \
         them to --scenes"
    )]
    CastersWithoutScene,
}

/// Rows to come.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Each with its numbers of lights.
    pub(crate) subjects: Vec<(Subject, Vec<usize>)>,
    pub(crate) rounds: Rounds,
    pub(crate) shadows: Frames,
    /// How many of the models cast in `shadows`, from the first on; or the user's own.
    pub(crate) models: usize,
    pub(crate) user_model: Option<Model>,
    pub(crate) casters: Vec<(CasterMesh, usize)>,
    /// Approximate face counts of the single casters that are held against an extractor.
    pub(crate) one_mesh: Vec<usize>,
    /// Scenes with their numbers of casters.
    pub(crate) skipping: Vec<(SkipScene, usize)>,
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
const SKIPPING: [&str; 6] = ["still", "city", "crowd", "moving", "house", "big"];
const NUMBERS_OF_CASTERS: [usize; 6] = [1, 10, 100, 200, 1000, 10_000];
const QUICK_NUMBERS_OF_CASTERS: [usize; 3] = [1, 10, 100];
/// Faces of a single caster.
const ONE_CASTER: [usize; 3] = [1 << 10, 1 << 14, 1 << 20];
const QUICK_ONE_CASTER: [usize; 2] = [1 << 10, 1 << 14];
const MOST_CHARACTERS: usize = 1000;

impl Plan {
    pub fn new(options: Options) -> Result<Self, PlanError> {
        let Options { quick, cpu_only, .. } = options;
        let usual = |all: &[usize], few: &[usize]| if quick { few.to_vec() } else { all.to_vec() };
        let names = Names::new(&options)?;
        let casters = options.casters.clone();
        if !names.has_casters && names.skipping.is_empty() && casters.as_ref().is_some_and(|all| !all.is_empty()) {
            return Err(PlanError::CastersWithoutScene);
        }
        let has_user_model = options.model.is_some();
        let meshes =
            options.meshes.unwrap_or_else(|| if has_user_model { Vec::new() } else { usual(&MESHES, &QUICK_MESHES) });
        let scene_faces = options.scene_faces.unwrap_or(if quick { QUICK_SCENE_FACES } else { SCENE_FACES });
        let lights_of_meshes = options.lights.clone().unwrap_or_else(|| LIGHTS.into());
        let lights_of_scenes = options.lights.unwrap_or_else(|| vec![8]);
        let mut subjects = Vec::new();
        if let Some(model) = &options.model {
            let lights = if model.lights.is_empty() { lights_of_meshes.clone() } else { vec![model.lights.len()] };
            subjects.push((Subject::OfUser(Box::new(model.clone())), lights));
        }
        subjects.extend(meshes.into_iter().map(|faces| (Subject::Torus(faces), lights_of_meshes.clone())));
        subjects
            .extend(names.stress.into_iter().map(|name| (Subject::Scene(name, scene_faces), lights_of_scenes.clone())));
        let (most, seconds) = if quick { (9, 0.4) } else { (21, 5.0) };
        let most = options.rounds.unwrap_or(most);
        let rounds =
            Rounds { least: most.min(if quick { 3 } else { 5 }), most, time: Duration::from_secs_f64(seconds) };
        let (models, usual_frames, size) = if quick { (1, 6, 256) } else { (3, 16, 512) };
        let frames = if cpu_only { 0 } else { options.frames.unwrap_or(usual_frames) };
        // A round draws whole paths.
        let shadows = Frames { count: frames, size, rounds: Rounds { least: most.min(3), ..rounds } };
        let numbers = casters.clone().unwrap_or_else(|| usual(&NUMBERS_OF_CASTERS, &QUICK_NUMBERS_OF_CASTERS));
        let numbers = if names.has_casters && !cpu_only { numbers } else { Vec::new() };
        let one_mesh = if numbers.is_empty() { Vec::new() } else { usual(&ONE_CASTER, &QUICK_ONE_CASTER) };
        let characters = numbers.iter().filter(|&&number| number <= MOST_CHARACTERS);
        let of = |mesh: CasterMesh| move |&number: &usize| (mesh, number);
        let plan = Self {
            subjects,
            rounds,
            shadows,
            models,
            user_model: options.model,
            casters: numbers
                .iter()
                .map(of(CasterMesh::Cube))
                .chain(characters.map(of(CasterMesh::Character)))
                .collect(),
            one_mesh,
            skipping: if cpu_only { Vec::new() } else { skipping(&names.skipping, casters.as_deref(), quick) },
        };
        if plan.rows() == 0 { Err(PlanError::Nothing) } else { Ok(plan) }
    }

    /// How many rows there will be.
    pub fn rows(&self) -> usize {
        let extraction: usize = self.subjects.iter().map(|(_, lights)| lights.len()).sum();
        extraction + self.shadow_rows() + self.casters.len() + self.one_mesh.len() + self.skipping.len()
    }

    fn shadow_rows(&self) -> usize {
        use crate::shadows::scene::{MODELS, PATHS};
        let models = if self.user_model.is_some() { 1 } else { self.models.min(MODELS.len()) };
        if self.shadows.count == 0 { 0 } else { models * PATHS.len() }
    }
}

/// The scenes of these names, with their numbers of casters.
fn skipping(names: &[&str], given: Option<&[usize]>, quick: bool) -> Vec<(SkipScene, usize)> {
    let scenes = names.iter().filter_map(|name| SkipScene::named(name, quick)).flatten();
    let numbers = scenes.flat_map(|&scene| {
        let given = given.filter(|_| !scene.is_one_mesh());
        let numbers = given.map_or_else(|| vec![scene.usual(quick)], <[usize]>::to_vec);
        numbers.into_iter().filter(move |number| *number <= scene.most()).map(move |number| (scene, number))
    });
    numbers.collect()
}

/// The names of scenes, by what they are of.
struct Names {
    stress: Vec<&'static str>,
    has_casters: bool,
    skipping: Vec<&'static str>,
}

impl Names {
    fn new(options: &Options) -> Result<Self, PlanError> {
        let all = |stress| Self { stress, has_casters: true, skipping: SKIPPING.into() };
        let mut names = Self { stress: Vec::new(), has_casters: false, skipping: Vec::new() };
        let Some(wanted) = &options.scenes else {
            return Ok(match (options.model.is_some(), options.quick) {
                (true, _) => names,
                (false, true) => all(QUICK_SCENES.into()),
                (false, false) => all(stress::names().collect()),
            });
        };
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
                return Err(PlanError::Scene { wanted: wanted.clone(), there });
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
