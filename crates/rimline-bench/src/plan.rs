//! Selection and order of the measurements.

use std::rc::Rc;
use std::time::Duration;

use crate::casters::CasterMesh;
use crate::engine::Rounds;
use crate::extraction::subject::{Model, Subject};
use crate::shadows::Frames;
use crate::shadows::scene::{MODELS, PATHS, Path, fitted};
use crate::shapes::Shape;
use crate::skipping::scenes::SkipScene;
use crate::stress;
use crate::text::grouped;

/// The measurements to plan. An empty list selects none, `None` the usual ones.
#[derive(Clone, Debug, Default)]
pub struct Options {
    pub quick: bool,
    pub meshes: Option<Vec<usize>>,
    pub scenes: Option<Vec<String>>,
    pub casters: Option<Vec<usize>>,
    /// The approximate number of faces of each stress scene.
    pub scene_faces: Option<usize>,
    pub lights: Option<Vec<usize>>,
    /// The largest number of measured rounds. Runs that warm up do not count.
    pub rounds: Option<usize>,
    /// Frames of each camera path for shadows. 0: no shadows.
    pub frames: Option<usize>,
    /// Only extraction is measured, on the CPU: shadows and scenes of casters need a GPU.
    pub cpu_only: bool,
    /// The user's model. It replaces the usual meshes and scenes, and the casters of shadows.
    pub model: Option<Model>,
}

#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error(
        "there is nothing to measure; give numbers to --meshes, or stress scenes to --scenes; on a GPU also scenes of casters, or \
         a number to --frames"
    )]
    Nothing,
    #[error("there is no scene `{wanted}`; there are {there}, `all` and `none`")]
    Scene { wanted: String, there: String },
    #[error(
        "--casters is for the scenes `casters`, `still`, `city`, `crowd`, `moving` and `house`, and none of them is measured; \
         name some in --scenes, or leave --casters out"
    )]
    CastersWithoutScene,
    #[error("{what} needs a GPU; leave it out, or measure on a GPU")]
    NeedsGpu { what: String },
}

#[derive(Clone, Debug)]
pub struct Plan {
    /// Extractions first: on Mesa's software device nothing may be drawn before stages are timed by timestamps, see
    /// [`crate::gpu::Stopwatch`].
    pub(crate) jobs: Vec<Job>,
    pub(crate) rounds: Rounds,
    pub(crate) frames: Frames,
}

/// Something to measure, for one row; extraction has several.
#[derive(Clone, Debug)]
pub(crate) enum Job {
    /// A row for each number of lights.
    Extraction(Subject, Vec<usize>),
    /// The name of a caster, the caster, and the path of the camera.
    Shadows(String, Rc<Shape>, Path),
    Casters(CasterMesh, usize),
    /// The approximate number of faces of a single caster. Its scene is compared with an extractor.
    OneMesh(usize),
    Skipping(SkipScene, usize),
}

impl Job {
    pub(crate) fn title(&self) -> String {
        match self {
            Self::Extraction(Subject::Torus(faces), _) => format!("torus of {} faces", grouped(*faces)),
            Self::Extraction(Subject::Scene(name, _), _) => (*name).to_owned(),
            Self::Extraction(Subject::OfUser(model), _) => model.name.clone(),
            Self::Shadows(name, _, path) => format!("shadows of {name}: {}", path.name),
            Self::Casters(mesh, count) => format!("scene of {}", mesh.counted(*count)),
            Self::OneMesh(faces) => format!("scene of one mesh of {} faces", grouped(*faces)),
            Self::Skipping(scene, count) => scene.title(*count),
        }
    }
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
/// The name that selects the scenes of many casters and the scenes of one mesh.
const CASTERS: &str = "casters";
/// The names of scenes that measure skipping.
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
        let wanted = each_once(wanted(&options)?);
        if cpu_only {
            check_on_cpu(&options)?;
        }
        let of_skipping: Vec<&str> = wanted.iter().filter(|name| SKIPPING.contains(name)).copied().collect();
        let has_casters = wanted.contains(&CASTERS);
        let casters = options.casters.clone().map(each_once);
        let takes_casters =
            |name: &&str| *name == CASTERS || SkipScene::named(name, quick).iter().any(|scene| !scene.is_one_mesh());
        if casters.as_ref().is_some_and(|all| !all.is_empty()) && !wanted.iter().any(takes_casters) {
            return Err(PlanError::CastersWithoutScene);
        }
        let usual_meshes = usual(&MESHES, &QUICK_MESHES);
        let meshes = options.meshes.map(each_once);
        let meshes = meshes.unwrap_or(if options.model.is_some() { Vec::new() } else { usual_meshes });
        let scene_faces = options.scene_faces.unwrap_or(if quick { QUICK_SCENE_FACES } else { SCENE_FACES });
        let lights = options.lights.map(each_once);
        let lights_of_meshes = lights.clone().unwrap_or_else(|| LIGHTS.into());
        let lights_of_scenes = lights.unwrap_or_else(|| vec![8]);
        let (most, seconds) = if quick { (9, 0.4) } else { (21, 5.0) };
        let most = options.rounds.unwrap_or(most);
        let rounds =
            Rounds { least: most.min(if quick { 3 } else { 5 }), most, time: Duration::from_secs_f64(seconds) };
        let (models, usual_frames, size) = if quick { (1, 6, 256) } else { (3, 16, 512) };
        // A round draws every frame of a path, so fewer rounds are needed.
        let count = options.frames.unwrap_or(usual_frames);
        let frames = Frames { count, size, rounds: Rounds { least: most.min(3), ..rounds } };

        let mut jobs = Vec::new();
        if let Some(model) = &options.model {
            let lights = if model.lights.is_empty() { lights_of_meshes.clone() } else { vec![model.lights.len()] };
            jobs.push(Job::Extraction(Subject::OfUser(Box::new(model.clone())), lights));
        }
        jobs.extend(meshes.into_iter().map(|faces| Job::Extraction(Subject::Torus(faces), lights_of_meshes.clone())));
        let stress = wanted.iter().filter(|name| stress::names().any(|known| known == **name));
        let of_stress =
            |name: &&'static str| Job::Extraction(Subject::Scene(name, scene_faces), lights_of_scenes.clone());
        jobs.extend(stress.map(of_stress));
        if !cpu_only {
            if count > 0 {
                jobs.extend(of_shadows(options.model.as_ref(), models));
            }
            if has_casters {
                let numbers = casters.clone().unwrap_or_else(|| usual(&NUMBERS_OF_CASTERS, &QUICK_NUMBERS_OF_CASTERS));
                jobs.extend(of_casters(&numbers, &usual(&ONE_CASTER, &QUICK_ONE_CASTER)));
            }
            for scene in of_skipping.iter().flat_map(|name| SkipScene::named(name, quick)) {
                let given = casters.as_deref().filter(|_| !scene.is_one_mesh());
                let numbers = given.map_or_else(|| vec![scene.usual[usize::from(quick)]], <[usize]>::to_vec);
                let numbers = numbers.into_iter().filter(|number| *number <= scene.most);
                jobs.extend(numbers.map(|number| Job::Skipping(scene, number)));
            }
        }
        let plan = Self { jobs, rounds, frames };
        if plan.rows() == 0 { Err(PlanError::Nothing) } else { Ok(plan) }
    }

    pub fn rows(&self) -> usize {
        let rows = |job: &Job| if let Job::Extraction(_, lights) = job { lights.len() } else { 1 };
        self.jobs.iter().map(rows).sum()
    }
}

/// The user's model, or the first `models` of `MODELS`, seen along each path.
fn of_shadows(model: Option<&Model>, models: usize) -> Vec<Job> {
    let bodies: Vec<(String, Rc<Shape>)> = match model {
        Some(model) => vec![(model.name.clone(), Rc::new(fitted(&model.positions, model.mesh.faces())))],
        None => MODELS.iter().take(models).map(|(name, make)| ((*name).to_owned(), Rc::new(make()))).collect(),
    };
    let on_paths =
        |(name, shape): (String, Rc<Shape>)| PATHS.map(|path| Job::Shadows(name.clone(), Rc::clone(&shape), path));
    bodies.into_iter().flat_map(on_paths).collect()
}

/// Scenes with these numbers of casters and, unless `numbers` is empty, scenes of one mesh.
fn of_casters(numbers: &[usize], one_mesh: &[usize]) -> Vec<Job> {
    let cubes = numbers.iter().map(|&number| Job::Casters(CasterMesh::Cube, number));
    let characters = numbers.iter().filter(|&&number| number <= MOST_CHARACTERS);
    let characters = characters.map(|&number| Job::Casters(CasterMesh::Character, number));
    let one_mesh = one_mesh.iter().filter(|_| !numbers.is_empty()).map(|&faces| Job::OneMesh(faces));
    cubes.chain(characters).chain(one_mesh).collect()
}

/// The values without repetitions, in the order in which they first occur.
fn each_once<T: PartialEq>(values: Vec<T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}

fn names() -> impl Iterator<Item = &'static str> {
    stress::names().chain([CASTERS]).chain(SKIPPING)
}

/// The names of the scenes that the options name, or else of the usual ones.
fn wanted(options: &Options) -> Result<Vec<&'static str>, PlanError> {
    let wanted = match options.scenes.as_deref() {
        None if options.model.is_some() => return Ok(Vec::new()),
        None if options.quick => return Ok(QUICK_SCENES.into_iter().chain([CASTERS]).chain(SKIPPING).collect()),
        None => return Ok(names().collect()),
        Some(wanted) => wanted,
    };
    let known = |wanted: &String| {
        let found: Vec<_> = names().filter(|name| wanted == "all" || name == wanted).collect();
        if found.is_empty() && wanted != "none" {
            return Err(PlanError::Scene { wanted: wanted.clone(), there: names().collect::<Vec<_>>().join(", ") });
        }
        Ok(found)
    };
    Ok(wanted.iter().map(known).collect::<Result<Vec<_>, _>>()?.concat())
}

/// Refuses what the options name and only a GPU measures.
fn check_on_cpu(options: &Options) -> Result<(), PlanError> {
    let mut scenes = options.scenes.iter().flatten().map(String::as_str);
    let what = match scenes.find(|name| *name == CASTERS || SKIPPING.contains(name)) {
        Some(scene) => format!("the scene `{scene}`"),
        None if options.casters.as_ref().is_some_and(|all| !all.is_empty()) => "--casters".to_owned(),
        None if options.frames.is_some_and(|frames| frames > 0) => "--frames".to_owned(),
        None => return Ok(()),
    };
    Err(PlanError::NeedsGpu { what })
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

    #[test]
    fn everything_is_measured_once() {
        let plan = |scenes: &[&str], number: usize| {
            let scenes = Some(scenes.iter().map(|&scene| scene.to_owned()).collect());
            let [meshes, casters, lights] = [64, 3, 8].map(|value| Some(vec![value; number]));
            let plan = Plan::new(Options { scenes, meshes, casters, lights, frames: Some(0), ..Options::default() });
            let plan = plan.expect("there is something to measure");
            (plan.jobs.iter().map(Job::title).collect::<Vec<_>>(), plan.rows())
        };
        assert_eq!(plan(&["city", "plate-third", "city", "plate-third"], 2), plan(&["city", "plate-third"], 1));
        assert_eq!(plan(&["city", "none"], 1), plan(&["city"], 1));
        let (all, city_first) = (plan(&["all"], 1), plan(&["city", "all"], 1));
        assert_eq!(all.1, city_first.1);
        assert!(all.0.iter().all(|job| city_first.0.contains(job)));
    }

    #[test]
    fn numbers_of_casters_need_a_scene_that_takes_them() {
        let plan = |scene: &str| {
            let (scenes, casters) = (Some(vec![scene.to_owned()]), Some(vec![3]));
            Plan::new(Options { scenes, casters, meshes: Some(Vec::new()), frames: Some(0), ..Options::default() })
        };
        for scene in ["big", "none"] {
            assert!(matches!(plan(scene), Err(PlanError::CastersWithoutScene)), "{scene}");
        }
        assert!(plan("city").is_ok() && plan("casters").is_ok());
    }
}
