//! [`Budget`]: the sizes of a page's parts.

/// Largest sizes of a page's parts, bytes. Parts that do not fit are thinned or cut, with a remark
/// on the page.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Budget {
    /// The motion; 900 kB unless given.
    pub motion: usize,
    /// The curves; 700 kB unless given.
    pub curves: usize,
    /// Formulas of one section of the equations; 120 kB unless given.
    pub equations: usize,
    /// Corners and faces of solids; 600 kB unless given.
    pub solids: usize,
}

impl Default for Budget {
    /// A page of less than 2 MB.
    fn default() -> Self {
        Self { motion: 900_000, curves: 700_000, equations: 120_000, solids: 600_000 }
    }
}

/// Count of numbers of `size` bytes that base64 writes in at most `bytes` bytes.
pub(crate) fn n_numbers(bytes: usize, size: usize) -> usize {
    bytes / 4 * 3 / size
}
