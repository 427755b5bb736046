//! A cache that makes each value once for its key, from any thread.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::memory::any_error;

/// A value, or an empty cell for it. The thread that makes the value holds its lock, so other threads wait for it instead
/// of making it again. Other values can be made meanwhile.
type Room<V> = Arc<Mutex<Option<V>>>;

/// The values that were made so far.
#[derive(Debug)]
pub(crate) struct Cache<K, V>(Mutex<HashMap<K, Room<V>>>);

impl<K, V> Default for Cache<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Clone + Eq + Hash, V: Clone> Cache<K, V> {
    /// The value of `key`. `make` makes it unless it exists. If the device reports an error, the value is not cached. It
    /// is then made again outside the cache's error scopes, because error scopes belong to the calling thread: the
    /// error goes where the caller wants it. `make` must not ask for the same key, or it waits for itself.
    pub(crate) fn get(&self, device: &wgpu::Device, key: &K, make: impl Fn() -> V) -> V {
        let room = self.room(key);
        let mut held = lock(&room);
        if let Some(value) = &*held {
            return value.clone();
        }
        if let Ok(value) = any_error(device, &make) {
            return held.insert(value).clone();
        }
        // A caller's error handler may use the cache, so the lock must be free.
        drop(held);
        make()
    }

    /// Makes the value of `key` unless it exists. If the device reports an error, none is cached, and a caller that needs
    /// the value gets the error.
    pub(crate) fn fill(&self, device: &wgpu::Device, key: &K, make: impl FnOnce() -> V) {
        let room = self.room(key);
        let mut held = lock(&room);
        if held.is_none() {
            *held = any_error(device, make).ok();
        }
    }

    /// Whether there is a value of `key`. Waits for it if it is being made.
    pub(crate) fn has(&self, key: &K) -> bool {
        let room = lock(&self.0).get(key).cloned();
        room.is_some_and(|room| lock(&room).is_some())
    }

    fn room(&self, key: &K) -> Room<V> {
        let mut rooms = lock(&self.0);
        // Most keys are there already, and are long to copy.
        if let Some(room) = rooms.get(key) {
            return Arc::clone(room);
        }
        Arc::clone(rooms.entry(key.clone()).or_default())
    }

    /// The number of values. Waits for those that are being made.
    pub(crate) fn len(&self) -> usize {
        let rooms: Vec<_> = lock(&self.0).values().cloned().collect();
        rooms.iter().filter(|room| lock(room).is_some()).count()
    }
}

/// Locks despite a panic elsewhere. A panic leaves values whole, since each is stored in one step.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
