//! Opening files that were read.

use rimline::Origin;
use rimline_files::{File, FileError, settle};

use super::body::{Body, BodyError};
use super::event::Event;
use super::viewer::Viewer;

impl Viewer {
    /// Shows a file that was read, beside those that are shown already and relative to their origin, or says why it
    /// cannot be shown. `path` is what the command calls it.
    pub fn open(&mut self, name: &str, path: String, file: Result<File, FileError>) {
        let origin = self.opened_origin();
        match file.map_err(BodyError::from).and_then(|file| body(name, path, file, origin)) {
            Ok((body, origin)) => {
                self.handle(Event::Opened(Ok(Box::new(body))));
                self.origin = origin;
            }
            Err(error) => self.handle(Event::Opened(Err((name.to_owned(), error.to_string())))),
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
