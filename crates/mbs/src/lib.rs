//! Mechanisms in symbols: from bodies, joints and loads to the equations of motion.

mod absolute_angles;
pub mod assemble;
pub mod constraint;
pub mod contact;
pub mod coordinate;
pub mod coupling;
pub mod equations;
pub mod force;
pub mod inertia;
pub mod joint;
pub mod kinematics;
mod lagrange;
pub mod levels;
mod measure;
pub mod modes;
mod norm;
pub mod pose;
pub mod quantity;
pub mod quaternion;
pub mod reaction;
mod recursion;
pub mod signal;
pub mod sparse;
pub mod spatial;
pub mod system;
pub mod transmission;
pub mod tree;
