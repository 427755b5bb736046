//! Rimline's two commands.
fn main() {}
