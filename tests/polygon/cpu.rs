//! Polygons without a device: how lights see outlines, and the extraction of polygon meshes.

mod extraction;
mod lights;
mod outlines;
mod twisted;
