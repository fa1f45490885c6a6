//! Parts that machines are built of: loads and friction, belts and ropes, couplings, cylinders, and the balance of their energy.

mod balance;
mod beams;
mod belts;
mod contacts;
mod couplings;
mod cylinders;
mod energy;
mod exports;
mod friction;
mod hydraulics;
mod imports;
mod loads;
mod machines;
mod meshes;
mod piles;
mod plain_drawings;
mod reeving;
mod ropes;
mod teeth;
mod winding;
mod worms;
