//! Compiling shaders while something else is done.

use std::thread::{Builder, JoinHandle};

/// A thread that makes pipelines. Dropping it waits for it: a process must not end while a driver compiles.
#[derive(Default)]
pub(crate) struct Compiling(Option<JoinHandle<()>>);

impl Compiling {
    /// Begins. Where no thread can be started nothing is made, and whoever needs a pipeline makes it.
    pub(crate) fn begin(make: impl FnOnce() + Send + 'static) -> Self {
        Self(Builder::new().name("compiling".into()).spawn(make).ok())
    }
}

impl Drop for Compiling {
    fn drop(&mut self) {
        if let Some(thread) = self.0.take() {
            // Pipelines that it could not make are made where they are needed.
            let _ = thread.join();
        }
    }
}
