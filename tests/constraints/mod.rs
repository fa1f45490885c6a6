//! Constraints: starts that meet them, joints that are redundant, and reactions.

mod assemblies;
mod reactions;
mod redundancy;
mod redundant;
mod starts;
mod warnings;
