//! Faces hidden by faces, without a device.

mod cones;
mod hidden_faces;
mod least_cut;
mod oracle;
mod outlines;
mod polygons;
mod static_scenes;
