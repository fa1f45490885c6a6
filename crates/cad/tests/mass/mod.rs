//! Outlines and their mass properties: against textbook formulas, against independent quadrature,
//! under motion, and against whatever a damaged file may say.

mod closed_forms;
mod hostile;
mod invariance;
mod known;
mod loops;
mod positions;
mod shapes;
mod splines;
