//! Reading of models: values, faults and solids.

mod faults;
mod overrides;
mod reading;
mod solids;
mod units;
