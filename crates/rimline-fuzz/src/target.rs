//! The targets by name.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    Gltf,
    Npz,
    Obj,
    Ply,
    Stl,
    Wgsl,
    Arguments,
}

/// Each target's name for `--target`, and the file extension of its cases.
const TARGETS: [(Target, &str, &str); 7] = [
    (Target::Gltf, "gltf", "glb"),
    (Target::Npz, "npz", "npz"),
    (Target::Obj, "obj", "obj"),
    (Target::Ply, "ply", "ply"),
    (Target::Stl, "stl", "stl"),
    (Target::Wgsl, "wgsl", "wgsl"),
    (Target::Arguments, "args", "txt"),
];

impl Target {
    pub(crate) fn named(wanted: &str) -> Option<Self> {
        TARGETS.iter().find(|(_, name, _)| *name == wanted).map(|(target, ..)| *target)
    }

    pub(crate) fn name(self) -> &'static str {
        TARGETS.iter().find(|(target, ..)| *target == self).map_or("", |(_, name, _)| name)
    }

    /// File extension of its cases.
    pub(crate) fn ending(self) -> &'static str {
        TARGETS.iter().find(|(target, ..)| *target == self).map_or("", |(.., ending)| ending)
    }

    /// Whether each case is a process, which the target itself ends when it is slow. The supervisor then waits longer.
    pub(crate) fn watches_itself(self) -> bool {
        self == Self::Arguments
    }
}
