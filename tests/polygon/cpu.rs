//! Polygons without a device: how lights see outlines, and the extraction of polygon meshes.

mod depths;
mod extraction;
mod lights;
mod outlines;
mod query;
