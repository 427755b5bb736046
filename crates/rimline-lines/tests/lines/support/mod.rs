//! Parts that the tests share.

pub(crate) mod oracle;
pub(crate) mod shapes;
