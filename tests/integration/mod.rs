//! Integration: methods, orders and references, switching, long chains, singular poses, runs back and resumed,
//! sensitivities.

mod backwards;
mod methods;
mod order;
mod reference;
mod resume;
mod scale;
mod sensitivity;
mod singular;
mod switching;
