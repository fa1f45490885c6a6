//! Polynomial equations in complex numbers: all solutions, each proved, and bounds of their number.
//!
//! ```text
//! path     H(x(s), s) = 0 from s = 0, where all solutions are known, to s = 1, where they are asked for
//! ball     Newton's iteration converges from a point, and to one solution only
//! bound    how many solutions there can be, from ranks alone: of points on two linear spaces, of quadratic equations
//! ```
//!
//! As many different balls as the bound allows are all solutions. Nothing has to be proved of the paths for this: a path that
//! is lost or jumps to another one is missed in the count.

mod ball;
mod bilinear;
mod count;
mod double;
mod path;
mod quadrics;
mod quotient;

pub use ball::{Ball, Enclosed, Quadratic};
pub use bilinear::solutions;
pub use count::n_inverse_pairs;
pub use path::{At, End, Family, track};
pub use quadrics::Between;
pub use quotient::most_zeros;

/// A complex number.
pub type C = nalgebra::Complex<f64>;
