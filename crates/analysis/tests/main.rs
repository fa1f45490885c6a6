//! Questions about positions and about forces, against closed forms and other programs.

mod forces;
mod positions;
mod support;
