//! Andrews' squeezing mechanism: seven bodies, seven angles, three closed loops.
//!
//! Equations and data: HW2 §VII.7 (multibody mechanisms); the coordinates are β, Θ, γ, Φ,
//! δ, Ω, ε.

use super::systems::{System, Texts};
use crate::error::BenchError;

const COORDINATES: &[(&str, f64)] = &[
    ("b", -0.0617),
    ("Th", 0.0),
    ("ga", 0.4553),
    ("Ph", 0.2227),
    ("de", 0.4874),
    ("Om", -0.2227),
    ("ep", 1.2305),
];

const PARAMETERS: &[(&str, f64)] = &[
    ("m1", 0.04325),
    ("m2", 0.00365),
    ("m3", 0.02373),
    ("m4", 0.00706),
    ("m5", 0.07050),
    ("m6", 0.00706),
    ("m7", 0.05498),
    ("xa", -0.06934),
    ("ya", -0.00227),
    ("xb", -0.03635),
    ("yb", 0.03273),
    ("xc", 0.014),
    ("yc", 0.072),
    ("c0", 4530.0),
    ("i1", 2.194e-6),
    ("i2", 4.410e-7),
    ("i3", 5.255e-6),
    ("i4", 5.667e-7),
    ("i5", 1.169e-5),
    ("i6", 5.667e-7),
    ("i7", 1.912e-5),
    ("d", 28e-3),
    ("da", 115e-4),
    ("e", 2e-2),
    ("ea", 1421e-5),
    ("rr", 7e-3),
    ("ra", 92e-5),
    ("l0", 7785e-5),
    ("ss", 35e-3),
    ("sa", 1874e-5),
    ("sb", 1043e-5),
    ("sc", 18e-3),
    ("sd", 2e-2),
    ("ta", 2308e-5),
    ("tb", 916e-5),
    ("u", 4e-2),
    ("ua", 1228e-5),
    ("ub", 449e-5),
    ("zf", 2e-2),
    ("zt", 4e-2),
    ("fa", 1421e-5),
    ("mom", 33e-3),
];

/// The spring between body 3 and the ground: the vector to its end, its length and its force.
const SPRING: &[(&str, &str)] = &[
    ("dx", "sd*cos(ga) + sc*sin(ga) + xb - xc"),
    ("dy", "sd*sin(ga) - sc*cos(ga) + yb - yc"),
    ("L", "sqrt(dx^2 + dy^2)"),
    ("F", "-c0*(L - l0)/L"),
    ("fx", "F*dx"),
    ("fy", "F*dy"),
];

const MASS: &[(usize, usize, &str)] = &[
    (0, 0, "m1*ra^2 + m2*(rr^2 - 2*da*rr*cos(Th) + da^2) + i1 + i2"),
    (1, 0, "m2*(da^2 - da*rr*cos(Th)) + i2"),
    (1, 1, "m2*da^2 + i2"),
    (2, 2, "m3*(sa^2 + sb^2) + i3"),
    (3, 3, "m4*(e - ea)^2 + i4"),
    (4, 3, "m4*((e - ea)^2 + zt*(e - ea)*sin(Ph)) + i4"),
    (4, 4, "m4*(zt^2 + 2*zt*(e - ea)*sin(Ph) + (e - ea)^2) + m5*(ta^2 + tb^2) + i4 + i5"),
    (5, 5, "m6*(zf - fa)^2 + i6"),
    (6, 5, "m6*((zf - fa)^2 - u*(zf - fa)*sin(Om)) + i6"),
    (6, 6, "m6*((zf - fa)^2 - 2*u*(zf - fa)*sin(Om) + u^2) + m7*(ua^2 + ub^2) + i6 + i7"),
];

const FORCE: &[&str] = &[
    "mom - m2*da*rr*Th_v*(Th_v + 2*b_v)*sin(Th)",
    "m2*da*rr*b_v^2*sin(Th)",
    "fx*(sc*cos(ga) - sd*sin(ga)) + fy*(sd*cos(ga) + sc*sin(ga))",
    "m4*zt*(e - ea)*de_v^2*cos(Ph)",
    "-m4*zt*(e - ea)*Ph_v*(Ph_v + 2*de_v)*cos(Ph)",
    "-m6*u*(zf - fa)*ep_v^2*cos(Om)",
    "m6*u*(zf - fa)*Om_v*(Om_v + 2*ep_v)*cos(Om)",
];

const CONSTRAINTS: &[&str] = &[
    "rr*cos(b) - d*cos(b + Th) - ss*sin(ga) - xb",
    "rr*sin(b) - d*sin(b + Th) + ss*cos(ga) - yb",
    "rr*cos(b) - d*cos(b + Th) - e*sin(Ph + de) - zt*cos(de) - xa",
    "rr*sin(b) - d*sin(b + Th) + e*cos(Ph + de) - zt*sin(de) - ya",
    "rr*cos(b) - d*cos(b + Th) - zf*cos(Om + ep) - u*sin(ep) - xa",
    "rr*sin(b) - d*sin(b + Th) - zf*sin(Om + ep) + u*cos(ep) - ya",
];

/// The mechanism's equations.
pub(crate) fn system() -> Result<System, BenchError> {
    System::parsed(
        "andrews",
        &Texts {
            coordinates: COORDINATES,
            parameters: PARAMETERS,
            abbreviations: SPRING,
            mass: MASS,
            force: FORCE,
            constraints: CONSTRAINTS,
        },
    )
}
