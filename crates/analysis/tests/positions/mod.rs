//! Positions: kinematics, coupler curves and polygons, limits, assemblies and freedoms.

mod assemblies;
mod coupler_curves;
mod doctor;
mod held_assembly;
mod interval_search;
mod kinematics;
mod limits;
mod platforms;
mod polygons;
mod regions;
mod trusses;
