//! How many turns the loops of each entry point have.
pub(crate) const MOST_QUERY_GROUPS: u32 = 31;
