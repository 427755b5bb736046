//! Opening files that were read.

use rimline::Origin;
use rimline_files::{File, FileError, settle};

use super::body::{Body, BodyError};
use super::event::Event;
use super::lamp::MAX_LAMPS;
use super::viewer::Viewer;

impl Viewer {
    /// Shows a file that was read, beside those that are shown already and relative to their origin, or says why it
    /// cannot be shown, and returns that. `path` is what the command calls it.
    pub fn open(&mut self, name: &str, path: String, file: Result<File, FileError>) -> Option<String> {
        let origin = self.opened_origin();
        match file.map_err(BodyError::from).and_then(|file| body(name, path, file, origin)) {
            Ok((body, origin)) => {
                self.handle(Event::Opened(Ok(Box::new(body))));
                self.origin = origin;
                None
            }
            Err(error) => {
                let why = error.to_string();
                let said = format!("{name}: {why}");
                self.handle(Event::Opened(Err((name.to_owned(), why))));
                Some(said)
            }
        }
    }

    /// Says which lights of a model that is to be added are left out, if some are.
    pub(super) fn lights_left_out(&self, body: &Body) -> Option<String> {
        let (name, count, is_first) = (&body.name, body.lights().len(), self.bodies.is_empty());
        if is_first && count > MAX_LAMPS {
            Some(format!("{name}: only the first {MAX_LAMPS} of its {count} lights are shown"))
        } else if !is_first && count > 0 {
            Some(format!("{name}: its lights ({count}) are left out, since only those of the first model are shown"))
        } else {
            None
        }
    }
}

/// A model of a file, relative to an origin, or else to one that it needs. Returns the origin, too.
fn body(name: &str, path: String, mut file: File, origin: Option<Origin>) -> Result<(Body, Origin), BodyError> {
    match origin {
        Some(origin) => file.move_to(origin)?,
        None => _ = settle(&mut [(&mut file, &[])], 0.0).map_err(|(_, error)| error)?,
    }
    let origin = file.origin();
    Ok((Body::new(name, Some(path), file)?, origin))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rimline::Light;
    use rimline::gltf::{SceneLight, SceneLightKind};
    use rimline_files::{File, ReadOptions, read_bytes};

    use crate::state::body::{Body, BodyError, Source};
    use crate::state::event::Event;
    use crate::state::keys::Action;
    use crate::state::viewer::{Tone, Viewer};

    #[test]
    fn one_dialog_is_open_at_a_time() {
        let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
        let mut asked = |event: Option<Event>| {
            viewer.handle(Event::Acted(Action::OpenFile));
            if let Some(event) = event {
                viewer.handle(event);
            }
            std::mem::take(&mut viewer.requests).len()
        };
        assert_eq!([asked(None), asked(None)], [1, 0]);
        // Files that are dropped meanwhile close no dialog.
        assert_eq!([asked(Some(Event::Opening)), asked(Some(Event::Answered)), asked(None)], [0, 0, 1]);
        assert!(viewer.requests.is_empty());
    }

    #[test]
    fn far_models_have_a_finite_camera_or_are_refused() {
        for (far, is_shown) in [(9e33_f32, true), (3e38, false)] {
            let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
            for x in [far, -far] {
                let side = 0.3 * far;
                let text = format!("v {x:e} 0 0\nv {x:e} {side:e} 0\nv {x:e} 0 {side:e}\nf 1 2 3\n");
                let file = read_bytes(text.as_bytes(), Some(Path::new("far.obj")), &ReadOptions::default());
                let error = viewer.open("far.obj", "far.obj".to_owned(), file);
                assert_eq!(error.is_none(), is_shown, "{x:e}: {error:?}");
                assert!(error.is_none_or(|error| error.contains("beyond 1e34")), "{x:e}");
            }
            assert_eq!(viewer.bodies.len() == 2, is_shown);
            for _ in 0..100 {
                let view = viewer.camera().view;
                assert!(view.eye.is_finite() && view.forward.is_finite() && view.near.is_finite(), "{view:?}");
                viewer.handle(Event::Acted(Action::Farther));
            }
        }
    }

    /// A triangle with so many lights.
    struct Lit(File, usize);

    impl Source for Lit {
        fn model(&self) -> &rimline::Model {
            self.0.model()
        }

        fn pose(&self, _: Option<usize>, seconds: f32) -> Result<rimline::Pose, BodyError> {
            Ok(self.0.pose(&[], seconds)?)
        }

        fn lights(&self) -> Vec<SceneLight> {
            let (light, kind) = (Light::point([0.0, 2.0, 0.0]), SceneLightKind::Point);
            let (color, intensity) = ([1.0; 3], 1.0);
            vec![SceneLight { name: None, light, kind, color, intensity, range: None, cone: None }; self.1]
        }
    }

    #[test]
    fn lights_that_are_left_out_are_named() {
        let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
        let mut open = |name: &str, lights: usize| {
            let content = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
            let file = read_bytes(content, Some(Path::new("a.obj")), &ReadOptions::default()).expect("a triangle");
            let body = Body::new(name, Some(name.to_owned()), Lit(file, lights)).expect("a triangle");
            viewer.handle(Event::Opened(Ok(Box::new(body))));
            let message = viewer.message.clone().expect("a file was opened");
            (viewer.lamps.len(), message.tone, message.text)
        };
        let of_nine = "a.glb: only the first 8 of its 9 lights are shown";
        let of_two = "b.glb: its lights (2) are left out, since only those of the first model are shown";
        assert_eq!(open("a.glb", 9), (8, Tone::Error, of_nine.to_owned()));
        assert_eq!(open("b.glb", 2), (8, Tone::Error, format!("{of_nine}\n{of_two}")));
        assert_eq!(open("c.glb", 0), (8, Tone::Error, format!("{of_nine}\n{of_two}")));
        viewer.handle(Event::Opening);
        (0..3).for_each(|_| viewer.remove_body(0));
        let body = crate::scenes::moebius().expect("a band").remove(0);
        viewer.handle(Event::Opened(Ok(Box::new(body))));
        assert!(viewer.message.as_ref().is_some_and(|message| message.tone == Tone::Note) && viewer.lamps.len() == 3);
    }

    #[test]
    fn files_are_all_seen_again_in_a_picture_of_another_size() {
        for is_turned in [false, true] {
            let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
            let content = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
            let file = read_bytes(content, Some(Path::new("a.obj")), &ReadOptions::default());
            assert_eq!(viewer.open("a.obj", "a.obj".to_owned(), file), None);
            if is_turned {
                viewer.handle(Event::Acted(Action::TurnLeft));
            }
            let before = viewer.orbit;
            viewer.handle(Event::Acted(Action::NextScene));
            viewer.handle(Event::Resized([130, 900]));
            (0..crate::scenes::ALL.len()).for_each(|_| viewer.handle(Event::Acted(Action::NextScene)));
            assert!(!viewer.is_built_in());
            let after = viewer.orbit;
            viewer.handle(Event::Acted(Action::ResetCamera));
            assert_eq!((after == before, after == viewer.orbit), (is_turned, !is_turned));
        }
    }

    #[test]
    fn errors_of_files_stay_until_others_are_opened() {
        let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
        let mut open = |names: &[&str]| {
            viewer.handle(Event::Opening);
            for name in names {
                let is_good = Path::new(name).extension().is_some_and(|ending| ending == "obj");
                let content: &[u8] =
                    if is_good { b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" } else { b"this is no model" };
                let file = read_bytes(content, Some(Path::new(name)), &ReadOptions::default());
                assert_eq!(viewer.open(name, (*name).to_owned(), file).is_none(), is_good, "{name}");
            }
            viewer.message.clone().expect("files were opened")
        };
        let failed = open(&["a.glb", "b.obj", "c.glb", "d.obj"]);
        assert_eq!(failed.tone, Tone::Error);
        let names: Vec<_> = failed.text.lines().map(|line| line.split(':').next().unwrap_or_default()).collect();
        assert_eq!(names, ["a.glb", "c.glb"]);
        let many = open(&["a.glb"; 9]);
        assert_eq!((many.text.lines().count(), many.details.lines().count()), (7, 3));
        assert_eq!(open(&["e.obj"]).tone, Tone::Note);
    }
}
