//! Hidden-line drawings of meshes, on the CPU: silhouettes, boundaries, creases, intersections and other lines, cut where
//! the number of faces in front of them changes. And outlines, the parts of the page that meshes cover.
//!
//! ```
//! use std::ops::ControlFlow;
//! use rimline::{Mesh, mesh::Weld};
//! use rimline_lines::{LineOptions, Object, View, draw};
//!
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
//! let mesh = Mesh::new(&positions, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], Weld::Position)?;
//! let view = View::orthographic([3.0, 2.0, 1.0], [0.0, 0.0, 1.0])?;
//! let drawing = draw(&[Object::new(&mesh, &positions)], &view, &LineOptions::default(), |_, _| ControlFlow::Continue(()))?;
//! let visible = drawing.spans.iter().filter(|span| span.faces_in_front == 0);
//! assert_eq!(visible.count(), 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The number of faces in front of each span is exact. Signs of determinants decide it: `f64` where a bound allows it,
//! else integers. Cuts are rounded; docs/numerics/lines.md in the repository has the bounds and their proofs.

#![forbid(unsafe_code)]

mod chains;
mod coincide;
mod count;
mod cover;
mod crease;
mod draw;
mod drawing;
mod edges;
mod error;
mod exact;
mod fold;
mod frame;
mod hiders;
mod meet;
mod object;
mod options;
mod outlines;
mod parallel;
mod touching;
mod tree;
mod view;
mod world;

pub use draw::draw;
pub use drawing::{Chain, Drawing, FaceId, Span};
pub use error::{Fault, LeftOut, LinesError};
pub use object::{Object, objects_of_model};
pub use options::{Classes, LineClass, LineOptions, PageBox};
pub use outlines::{Outline, OutlinePolygon, Outlines, outlines};
pub use view::View;
