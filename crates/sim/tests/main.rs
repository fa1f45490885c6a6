//! Runs: derivatives across events, gradients, methods, machine code and single steps.

mod both_ways;
mod derivatives_across_events;
mod explicit_methods;
mod gradients;
mod machine_code;
mod stepping;
