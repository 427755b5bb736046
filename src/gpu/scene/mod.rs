//! Extraction of many casters: pools of topology, the scene table, work lists, and lists of silhouette edges for each
//! light of a group of casters.

pub(crate) mod buffers;
pub(crate) mod caster;
#[cfg(feature = "depth-map")]
pub(crate) mod depths;
mod encode;
pub(crate) mod frame;
pub(crate) mod handles;
pub(crate) mod layout;
pub(crate) mod lights;
pub(crate) mod mask;
mod model;
mod models;
mod needs;
pub(crate) mod occluded_faces;
pub(crate) mod occluders;
pub(crate) mod options;
pub(crate) mod outlined;
pub(crate) mod pages;
pub(crate) mod receivers;
pub(crate) mod scene;
pub(crate) mod sources;
pub(crate) mod stages;
pub(crate) mod structure;
pub(crate) mod table;
pub(crate) mod topology;
pub(crate) mod view;
pub(crate) mod volumes;
