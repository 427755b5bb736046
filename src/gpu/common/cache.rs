//! Values made once a key, from any thread.

use std::borrow::Borrow;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::memory::any_error;

/// A value or the room for it. Whoever makes it holds its lock, so that others wait instead of making it again, and other
/// values are made meanwhile.
type Room<V> = Arc<Mutex<Option<V>>>;

/// What was made so far.
#[derive(Debug)]
pub(crate) struct Cache<K, V>(Mutex<HashMap<K, Room<V>>>);

impl<K, V> Default for Cache<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Eq + Hash, V: Clone> Cache<K, V> {
    /// The value of `key`, by `make` unless it is there. What the device reports an error for is not kept, and made again
    /// so that the error goes where the caller has it go; error scopes are the calling thread's.
    pub(crate) fn get<Q>(&self, device: &wgpu::Device, key: &Q, make: impl Fn() -> V) -> V
    where
        K: Borrow<Q>,
        Q: ToOwned<Owned = K> + Eq + Hash + ?Sized,
    {
        let room = self.room(key);
        let mut held = lock(&room);
        if let Some(value) = &*held {
            return value.clone();
        }
        if let Some(value) = without_error(device, &make) {
            return held.insert(value).clone();
        }
        // A handler of errors may ask for what is behind the lock.
        drop(held);
        make()
    }

    fn room<Q>(&self, key: &Q) -> Room<V>
    where
        K: Borrow<Q>,
        Q: ToOwned<Owned = K> + Eq + Hash + ?Sized,
    {
        let mut rooms = lock(&self.0);
        match rooms.get(key) {
            Some(room) => Arc::clone(room),
            None => Arc::clone(rooms.entry(key.to_owned()).or_default()),
        }
    }

    /// How many values there are; waits for those that are being made.
    pub(crate) fn len(&self) -> usize {
        let rooms: Vec<_> = lock(&self.0).values().cloned().collect();
        rooms.iter().filter(|room| lock(room).is_some()).count()
    }
}

/// A panic elsewhere leaves values whole: each is put in its room in one step.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What `make` makes, unless the device reports an error of any kind.
fn without_error<V>(device: &wgpu::Device, make: impl FnOnce() -> V) -> Option<V> {
    any_error(device, make).ok()
}
