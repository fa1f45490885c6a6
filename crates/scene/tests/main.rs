//! Scenes: symbols, solids and sections, and any numbers.

mod cords;
mod gallery;
mod hostile;
mod section;
mod solids;
mod symbols;
