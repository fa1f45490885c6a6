//! Forces: equilibria, efforts and reactions, and motions near a state.

mod angles;
mod bode;
mod branch_points;
mod continuation;
mod controllers;
mod families;
mod following;
mod gradient;
mod inverse;
mod letters;
mod levels;
mod linear;
mod matrices;
mod refused;
mod rest;
mod rubbing;
mod shares;
mod spatial_four_bar;
mod states;
mod statics;
mod steady;
mod stops;
mod verify;
