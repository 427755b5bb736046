//! The program that measures.

/// Hears what is going on, and may stop it. All methods are optional.
pub trait Host {
    /// Whether the work is to end now.
    fn is_stopped(&self) -> bool {
        false
    }

    /// Hears the name of the work that begins.
    fn step(&self, _what: &str) {}

    /// A row is done.
    fn done(&self, _what: &str) {}

    /// A remark for the user.
    fn note(&self, _text: &str) {}
}

/// Nobody.
impl Host for () {}
