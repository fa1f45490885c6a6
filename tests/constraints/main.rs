//! Constraints: starts that meet them, joints that are redundant, and reactions.

mod assemblies;
mod reactions;
mod redundancy;
mod redundant;
mod starts;
mod warnings;

#[path = "../support/mod.rs"]
mod support;
