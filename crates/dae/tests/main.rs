//! Integrators: orders, events, resuming, sensitivities, and published problems.

mod behaviour;
mod common;
mod events;
mod explicit;
mod mechanisms;
mod order;
mod resume;
mod sensitivity;
