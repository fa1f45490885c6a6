//! The problems: published mechanisms with end values to 18 digits and more, each as a model file
//! for us and as a C file for the others.

use serde_json::Value;

use crate::error::BenchError;

/// A problem with its inputs for all solvers.
#[derive(Clone, Copy)]
pub(crate) struct Definition {
    /// Name in files and the report.
    pub(crate) name: &'static str,
    /// Title of diagrams.
    pub(crate) title: &'static str,
    /// Our model.
    pub(crate) model: &'static str,
    /// The equations in C, in `native/precision`.
    pub(crate) source: &'static str,
    /// Start and reference values, with their source.
    data: &'static str,
    /// Our names of the coordinates, in the order of the data.
    pub(crate) coordinates: &'static [&'static str],
    /// Index of our multiplier and the factor that gives λ of the data, in the order of the data.
    pub(crate) multipliers: &'static [(usize, f64)],
    /// Sign of λ of the data relative to M a = f − Gᵀλ.
    sign: f64,
}

impl std::fmt::Debug for Definition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// All problems, in the order of the report.
pub(crate) const PROBLEMS: [Definition; 4] = [
    Definition {
        name: "pendulum",
        title: "Pendulum, 10 s",
        model: include_str!("../../models/pendulum.toml"),
        source: "pendulum.c",
        data: include_str!("../../../dae/tests/data/pendulum.json"),
        coordinates: &["x", "y"],
        multipliers: &[(0, 1.0)],
        sign: 1.0,
    },
    Definition {
        name: "caraxis",
        title: "Car axis, 3 s",
        model: include_str!("../../models/caraxis.toml"),
        source: "caraxis.c",
        data: include_str!("../../../dae/tests/data/caraxis.json"),
        coordinates: &["xl", "yl", "xr", "yr"],
        multipliers: &[(1, 1.0), (0, 0.5)],
        sign: -1.0,
    },
    Definition {
        name: "andrews",
        title: "Andrews' squeezer, 0.03 s",
        model: include_str!("../../models/andrews.toml"),
        source: "andrews.c",
        data: include_str!("../../../dae/tests/data/andrews.json"),
        coordinates: &["beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon"],
        multipliers: &[(0, -1.0), (1, -1.0), (2, -1.0), (3, -1.0), (4, -1.0), (5, -1.0)],
        sign: 1.0,
    },
    Definition {
        name: "slidercrank",
        title: "Slider-crank, 1 s",
        model: include_str!("../../models/slidercrank.toml"),
        source: "slidercrank.c",
        data: include_str!("../../../dae/tests/data/slidercrank.json"),
        coordinates: &["x1", "y1", "phi1", "x2", "y2", "phi2", "x3"],
        multipliers: &[(0, -1.0), (1, -1.0), (2, -1.0), (3, -1.0), (4, -1.0), (5, 1.0)],
        sign: 1.0,
    },
];

/// Numbers of one instant: q, v, a, λ.
#[derive(Clone, Debug)]
pub(crate) struct Instant {
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) a: Vec<f64>,
    pub(crate) lambda: Vec<f64>,
}

/// A problem with its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) definition: Definition,
    /// End time, s; all start at 0.
    pub(crate) t_end: f64,
    pub(crate) start: Instant,
    pub(crate) reference: Instant,
}

impl Problem {
    /// Reads the numbers of a definition.
    pub(crate) fn load(definition: Definition) -> Result<Self, BenchError> {
        let data: Value = serde_json::from_str(definition.data)
            .map_err(|_| BenchError::Data("a problem is not JSON"))?;
        let t_end = number(&data["tend"])?;
        let reference = instant(&data["reference"], definition.sign)?;
        let initial = &data["initial"];
        let is_complete = initial["crank_angle"].is_null();
        let start = if is_complete { instant(initial, definition.sign)? } else { cranked(&data)? };
        Ok(Self { definition, t_end, start, reference })
    }
}

/// A number of the data, which are text with all digits.
fn number(value: &Value) -> Result<f64, BenchError> {
    let parsed = value.as_str().and_then(|text| text.parse().ok());
    parsed.ok_or(BenchError::Data("a number of a problem is missing"))
}

fn vector(value: &Value) -> Result<Vec<f64>, BenchError> {
    let entries = value.as_array().ok_or(BenchError::Data("a vector of a problem is missing"))?;
    entries.iter().map(number).collect()
}

fn instant(value: &Value, sign: f64) -> Result<Instant, BenchError> {
    let lambda = vector(&value["lam"])?.into_iter().map(|x| sign * x).collect();
    Ok(Instant {
        q: vector(&value["q"])?,
        v: vector(&value["v"])?,
        a: vector(&value["a"])?,
        lambda,
    })
}

/// The start of the slider-crank, from the crank's angle and rate in the data.
fn cranked(data: &Value) -> Result<Instant, BenchError> {
    let initial = &data["initial"];
    let (p1, w1) = (number(&initial["crank_angle"])?, number(&initial["crank_rate"])?);
    let (l1, l2) = (number(&data["parameters"]["L1"])?, number(&data["parameters"]["L2"])?);
    let p2 = (-l1 * p1.sin() / l2).asin();
    let w2 = -l1 * p1.cos() * w1 / (l2 * p2.cos());
    // Half the links as vectors, and their rates.
    let [(c1, s1), (c2, s2)] =
        [(l1, p1), (l2, p2)].map(|(l, p)| (l / 2.0 * p.cos(), l / 2.0 * p.sin()));
    Ok(Instant {
        q: vec![c1, s1, p1, 2.0 * c1 + c2, 2.0 * s1 + s2, p2, 2.0 * c1 + 2.0 * c2],
        v: vec![
            -s1 * w1,
            c1 * w1,
            w1,
            -2.0 * s1 * w1 - s2 * w2,
            2.0 * c1 * w1 + c2 * w2,
            w2,
            -2.0 * s1 * w1 - 2.0 * s2 * w2,
        ],
        a: vector(&initial["a"])?,
        lambda: vector(&initial["lam"])?,
    })
}
