//! Signals: controllers, clocks and relays, tables, functions of the motion, and the parts that are made of them.

mod clocks;
mod controllers;
mod grids;
mod inputs;
mod jerks;
mod library;
mod relays;
mod tables;
