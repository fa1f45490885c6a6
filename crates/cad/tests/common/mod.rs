//! Helpers that the tests of drawings share.

pub(crate) mod python;
