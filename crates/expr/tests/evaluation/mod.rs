//! Values and derivatives: every evaluator, generated code, and other programs.

mod accuracy;
mod codegen;
mod composition;
mod derivatives;
mod differential;
mod evaluators;
mod gradient;
mod ways;
