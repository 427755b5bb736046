//! Shadow volumes without a device: the twins against `f64`.

mod choice;
mod vertices;
