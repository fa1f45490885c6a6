//! Mechanisms: from bodies, joints and loads to the equations of motion.

pub mod assemble;
mod closing;
pub mod codes;
pub mod compile;
mod crossing;
pub mod diagnostic;
pub mod equations;
pub mod fault;
pub mod file;
mod force;
pub mod formulate;
mod intermediate;
pub mod joint;
pub mod kinematics;
mod lagrange;
mod legs;
mod linear;
pub mod mobility;
pub mod model;
pub mod reaction;
mod recorder;
pub mod run;
mod side;
pub mod sparse;
mod spatial;
pub mod start;
pub mod tree;
