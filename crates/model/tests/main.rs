//! Reading of models: values, faults and solids.

mod faults;
mod reading;
mod solids;
