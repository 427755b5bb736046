//! What is measured, in which order.

use std::time::Duration;

use rimline::stress;

use super::args::{BenchArgs, Faces};
use super::measure::Rounds;
use super::subject::Subject;
use crate::failure::UsageError;

/// Rows to come.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Each with its numbers of lights.
    pub(crate) subjects: Vec<(Subject, Vec<usize>)>,
    pub(crate) rounds: Rounds,
}

const MESHES: [usize; 7] = [1 << 10, 1 << 12, 1 << 14, 1 << 16, 1 << 18, 1 << 20, 1 << 22];
const QUICK_MESHES: [usize; 3] = [1 << 10, 1 << 13, 1 << 16];
const SCENE_FACES: usize = 1 << 16;
const QUICK_SCENE_FACES: usize = 1 << 13;
const LIGHTS: [usize; 3] = [1, 8, 32];

impl Plan {
    pub(crate) fn new(args: &BenchArgs) -> Result<Self, UsageError> {
        let meshes: Vec<usize> = match &args.meshes {
            None if args.quick => QUICK_MESHES.into(),
            None => MESHES.into(),
            Some(faces) => faces
                .iter()
                .filter_map(|faces| match faces {
                    Faces::None => None,
                    Faces::Count(count) => Some(*count),
                })
                .collect(),
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
            meshes.into_iter().map(|faces| (Subject::Torus(faces), lights_of_meshes.clone())).collect();
        for name in scenes(args)? {
            subjects.push((Subject::Scene(name, scene_faces), lights_of_scenes.clone()));
        }
        if subjects.is_empty() {
            return Err(UsageError::NothingToMeasure);
        }
        let (most, seconds) = if args.quick { (7, 0.25) } else { (15, 2.5) };
        let most = args.rounds.map_or(most, usize::from);
        let rounds = Rounds { least: most.min(3), most, time: Duration::from_secs_f64(seconds) };
        Ok(Self { subjects, rounds })
    }

    /// How many rows that makes.
    pub(crate) fn rows(&self) -> usize {
        self.subjects.iter().map(|(_, lights)| lights.len()).sum()
    }
}

fn scenes(args: &BenchArgs) -> Result<Vec<&'static str>, UsageError> {
    let Some(wanted) = &args.scenes else {
        return Ok(if args.quick { last_of_classes() } else { stress::names().collect() });
    };
    match wanted.as_slice() {
        [one] if one == "all" => Ok(stress::names().collect()),
        [one] if one == "none" => Ok(Vec::new()),
        wanted => {
            let known = |wanted: &String| stress::names().find(|name| name == wanted);
            let unknown = |wanted: &String| UsageError::Scene {
                wanted: wanted.clone(),
                there: stress::names().collect::<Vec<_>>().join(", "),
            };
            wanted.iter().map(|wanted| known(wanted).ok_or_else(|| unknown(wanted))).collect()
        }
    }
}

/// Of each class the scene that is listed last, which is its hardest.
fn last_of_classes() -> Vec<&'static str> {
    let mut chosen: Vec<(&str, &'static str)> = Vec::new();
    // Their least size is enough to tell the class.
    for scene in stress::scenes(1) {
        match chosen.last_mut() {
            Some((class, name)) if *class == scene.class => *name = scene.name,
            _ => chosen.push((scene.class, scene.name)),
        }
    }
    chosen.into_iter().map(|(_, name)| name).collect()
}
