//! [`Context`]: the input of every suite.

use crate::peers::Peers;
use crate::timing::Effort;

/// The input of a suite: programs to compare with, and how long to measure.
#[derive(Debug)]
pub(crate) struct Context {
    pub(crate) peers: Peers,
    pub(crate) effort: Effort,
}
