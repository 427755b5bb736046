//! Polygons without a device: how lights see boundaries, and the extraction of polygon meshes.

mod boundaries;
mod depths;
mod extraction;
mod lights;
mod query;
