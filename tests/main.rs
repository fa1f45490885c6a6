//! Mechanisms, from a model to its motion: one module for each subject.

mod constraints;
mod contacts;
mod elements;
mod examples;
mod integration;
#[path = "../crates/cad/tests/common/python.rs"]
mod python;
mod signals;
mod space;
mod support;
