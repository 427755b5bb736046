//! Faces occluded by faces, without a device.

mod cones;
mod occluded_faces;
mod oracle;
mod outlines;
mod polygons;
mod static_scenes;
