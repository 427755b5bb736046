//! Twins of the stages and vertex shaders of shadow volumes that no oracle proves on the GPU itself.

pub(crate) mod bounds;
pub(crate) mod cap_faces;
pub(crate) mod caps;
pub(crate) mod casting;
pub(crate) mod choose;
pub(crate) mod chosen;
pub(crate) mod piece_crossings;
pub(crate) mod pyramid;
pub(crate) mod seen;
pub(crate) mod shadow;
pub(crate) mod sides;
pub(crate) mod stencil_bound;
pub(crate) mod stencil_crossings;
pub(crate) mod stencil_pencil;
pub(crate) mod zp_plus_2005;
pub(crate) mod zp_plus_2005_cases;
