//! Mechanisms: from bodies, joints and loads to the equations of motion.

pub mod assemble;
mod closing;
pub mod codes;
pub mod compile;
pub mod diagnostic;
mod elimination;
pub mod equations;
mod evaluator;
pub mod fault;
pub mod file;
mod force;
pub mod formulate;
mod intermediate;
pub mod joint;
pub mod kinematics;
mod lagrange;
mod linear;
pub mod mobility;
pub mod model;
mod multiplier;
pub mod reaction;
pub mod run;
pub mod sensitivity;
mod spatial;
pub mod start;
pub mod switch;
pub mod tree;
