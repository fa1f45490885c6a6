//! Mechanisms in space: their joints in every way to write them, orientations, and coordinates that change nothing.

mod closed_forms;
mod coordinates;
mod joints;
mod orientation;
mod particles;
mod rates;
mod spatial;
mod three_ways;
mod tumbling;
