//! Expressions: their algebra, their values and derivatives, and their forms.

mod algebra;
mod common;
mod evaluation;
mod forms;
