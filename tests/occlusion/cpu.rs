//! Faces occluded by faces, without a device.

mod cones;
mod least_cut;
mod occluded_faces;
mod oracle;
mod outlines;
mod polygons;
mod static_scenes;
