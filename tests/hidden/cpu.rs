//! Faces hidden by faces, without a device.

mod hidden_faces;
mod oracle;
mod static_scenes;
