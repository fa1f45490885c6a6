//! `[tolerance]`: what the limits of parts do to a pose.
//!
//! ```text
//! linear worst case    Σ |Sₖ| tₖ           root of squares   √Σ (Sₖ tₖ)²       S = dh/dp, exact
//! exact                min, max of h over the box: at corners where every slope keeps its sign, which intervals
//!                      prove; else by search over (q, p) with Φ = 0 and |Φ_q| on one side
//! samples              each followed from the nominal pose; what does not assemble is counted
//! ```

use std::collections::BTreeMap;

use bksim::analysis::Drive;
use bksim::expr::Expr;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::base::{Quantity, Source, Watch};
use crate::codes;
use crate::error::DesignError;
use crate::formula::formula;
use crate::interval::{Interval, Steps, times};
use crate::poses::{Pose, Poses, Solver};
use crate::spec::{Written, located, section};
use crate::sqp::Problem;

/// What is asked, and the limits of the parts.
#[derive(Clone, Debug, Default)]
pub struct ToleranceWish {
    /// Formulas over the pose: `rocker.angle`, `slider.P.x - d`.
    pub of: Vec<String>,
    /// Parameters with limits and, if it is another than that of all, the distribution.
    pub limits: Vec<(String, String, Option<String>)>,
    /// Measures with the values, or ranges, at which poses are asked for; the start of the model without any.
    pub at: Vec<(String, String)>,
    /// `uniform`, `normal` (a third of the limit is the standard deviation) or `triangular`; normal unless given.
    pub distribution: Option<String>,
    /// Number of samples of each pose.
    pub samples: Option<u64>,
    /// Other samples for each seed.
    pub seed: Option<u64>,
}

/// A limit alone, or with its distribution.
#[derive(Deserialize, Debug)]
#[serde(untagged)]
enum Limit {
    Alone(String),
    With { limit: String, distribution: Option<String> },
}

/// One or several.
#[derive(Deserialize, Debug)]
#[serde(untagged)]
enum Texts {
    One(String),
    Many(Vec<String>),
}

/// The section `[tolerance]`.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct Section {
    of: Option<Texts>,
    #[serde(default)]
    limits: BTreeMap<String, Limit>,
    #[serde(default)]
    at: BTreeMap<String, Written>,
    distribution: Option<String>,
    samples: Option<u64>,
    seed: Option<u64>,
}

const EXAMPLE: &str =
    "write it as `of = \"rocker.angle\"` and `limits = { l1 = \"±0.1 mm\" }` below `[tolerance]`";

impl ToleranceWish {
    /// What the model asks in `[tolerance]`; nothing of a model without the section.
    ///
    /// # Errors
    /// [`codes::BAD_QUESTION`].
    pub fn of_model(text: &str) -> Result<Self, DesignError> {
        let Some(found) = section::<Section>(text, "tolerance", EXAMPLE)? else {
            return Ok(Self::default());
        };
        let limit = |(name, limit): (String, Limit)| match limit {
            Limit::Alone(text) => (name, text, None),
            Limit::With { limit, distribution } => (name, limit, distribution),
        };
        Ok(Self {
            of: match found.of {
                None => Vec::new(),
                Some(Texts::One(text)) => vec![text],
                Some(Texts::Many(texts)) => texts,
            },
            limits: found.limits.into_iter().map(limit).collect(),
            at: found.at.into_iter().map(|(name, value)| (name, value.text())).collect(),
            distribution: found.distribution,
            samples: found.samples,
            seed: found.seed,
        })
    }
}

/// How values lie between limits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Spread {
    Uniform,
    Normal,
    Triangular,
}

impl Spread {
    fn named(name: &str) -> Option<Self> {
        match name {
            "uniform" => Some(Self::Uniform),
            "normal" => Some(Self::Normal),
            "triangular" => Some(Self::Triangular),
            _ => None,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Normal => "normal",
            Self::Triangular => "triangular",
        }
    }

    /// Standard deviation in parts of the limit.
    fn sigma(self) -> f64 {
        match self {
            Self::Uniform => 1.0 / 3f64.sqrt(),
            Self::Normal => 1.0 / 3.0,
            Self::Triangular => 1.0 / 6f64.sqrt(),
        }
    }

    fn sample(self, rng: &mut Pcg64Mcg) -> f64 {
        match self {
            Self::Uniform => 2.0 * rng.random::<f64>() - 1.0,
            Self::Triangular => rng.random::<f64>() - rng.random::<f64>(),
            // Box and Muller.
            Self::Normal => {
                let u = 1.0 - rng.random::<f64>();
                let v: f64 = rng.random();
                (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos() / 3.0
            }
        }
    }
}

/// A parameter with its share of a band.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Contributor {
    /// The parameter.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Least and largest value less the nominal one, SI.
    pub limits: [f64; 2],
    /// Its distribution.
    pub distribution: &'static str,
    /// Derivative of the result by it, SI.
    pub sensitivity: f64,
    /// |S t|.
    pub linear: f64,
    /// Part of the linear worst case, per cent.
    pub percent_of_worst: f64,
    /// Part of the linear variance, per cent.
    pub percent_of_variance: f64,
}

/// What limits do to one result in one pose.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Band {
    /// The formula.
    pub of: String,
    /// SI unit; empty of a formula.
    pub unit: String,
    /// With nominal values.
    pub nominal: f64,
    /// Half of the linear worst case, Σ |S t|.
    pub linear_worst: f64,
    /// By slopes alone.
    pub linear_interval: [f64; 2],
    /// √Σ (S t)².
    pub rss: f64,
    /// Standard deviation by slopes.
    pub sigma_linear: f64,
    /// Least and largest value of all parts that assemble.
    pub exact_interval: [f64; 2],
    /// By parameter, on which limit the ends are: `-` or `+`; empty where they are none of the corners.
    pub exact_at: [Vec<&'static str>; 2],
    /// Whether intervals prove the ends.
    pub proved: bool,
    /// Whether slopes alone give less than nine tenths or more than eleven tenths of the exact band.
    pub linear_fails: bool,
    /// Mean of the samples that assemble, with its standard error.
    pub mean: [f64; 2],
    /// Standard deviation of the samples that assemble, with its standard error.
    pub sigma: [f64; 2],
    /// Skewness of the samples that assemble.
    pub skewness: f64,
    /// Least and largest sample.
    pub sampled: [f64; 2],
    /// The parameters, in the order of the question.
    pub contributors: Vec<Contributor>,
}

/// All results in one pose.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct PoseTolerance {
    /// Prescribed measures and their values, SI.
    pub at: BTreeMap<String, f64>,
    /// Whether all parts within the limits assemble; `None` where that is not proved.
    pub assembles: Option<bool>,
    /// Part of the samples that do not assemble, with its standard error.
    pub share_without_assembly: [f64; 2],
    /// By formula.
    pub bands: Vec<Band>,
}

/// The answer.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Tolerance {
    /// By pose.
    pub poses: Vec<PoseTolerance>,
    /// Samples of each pose.
    pub samples: u64,
    /// Whether it was stopped before the samples were done.
    pub stopped: bool,
}

/// A parameter with its limits.
struct Part {
    name: String,
    unit: String,
    /// Its place among the parameters of the model.
    place: usize,
    nominal: f64,
    limits: [f64; 2],
    spread: Spread,
}

impl Part {
    fn half(&self) -> f64 {
        0.5 * (self.limits[1] - self.limits[0])
    }

    fn middle(&self) -> f64 {
        self.nominal + 0.5 * (self.limits[0] + self.limits[1])
    }
}

/// Limits such as `±0.1 mm`, `+-0.1 mm`, `0.1 mm`, `+0.2/-0.1 mm`, `+0.02/+0.01 mm` or `0/-0.02 mm`.
fn limits_of(text: &str) -> Option<([f64; 2], Quantity)> {
    let text = text.trim();
    let symmetric = ["±", "+-", "+/-"].into_iter().find_map(|sign| text.strip_prefix(sign));
    if let Some(one) =
        symmetric.or((!text.starts_with(['+', '-']) && !text.contains('/')).then_some(text))
    {
        let limit = Quantity::read(one)?;
        return (limit.value > 0.0).then(|| ([-limit.value, limit.value], limit));
    }
    let (upper, lower) = text.split_once('/')?;
    let lower = Quantity::read(lower)?;
    let with_unit = if upper.trim().parse::<f64>().is_ok() {
        format!("{upper} {}", lower.unit)
    } else {
        upper.to_owned()
    };
    let upper = Quantity::read(&with_unit)?;
    (lower.value < upper.value).then(|| ([lower.value, upper.value], lower))
}

/// Finds what limits do to the results of a model.
///
/// # Errors
/// [`DesignError`] for what cannot be read, and poses that are not reached.
pub fn tolerance(
    source: &Source,
    wish: &ToleranceWish,
    watch: Watch<'_>,
) -> Result<Tolerance, DesignError> {
    if wish.of.is_empty() || wish.limits.is_empty() {
        let message =
            if wish.of.is_empty() { "no result is asked for" } else { "no part has limits" };
        return Err(DesignError::fault(codes::NOTHING_ASKED, message, EXAMPLE));
    }
    let names: Vec<String> = wish.limits.iter().map(|(name, ..)| name.clone()).collect();
    let stated = source.stated(&names, true)?;
    let study = source.study(&stated, &[], &["0".to_owned()], true)?;
    let mechanism = study.mechanism();
    let model = &mechanism.model;
    let common = wish.distribution.as_deref().unwrap_or("normal");
    let mut parts = Vec::new();
    for (stated, (name, text, own)) in stated.iter().zip(&wish.limits) {
        let read = limits_of(text).filter(|(_, one)| {
            one.fits(&stated.unit) && !(one.unit.is_empty() && !stated.unit.is_empty())
        });
        let (limits, _) = read.ok_or_else(|| {
            let message = format!("`{text}` is no limit of `{name}`");
            let help = format!(
                "write `±0.1 {0}` or `+0.2/-0.1 {0}`",
                if stated.unit == "m" { "mm" } else { &stated.unit }
            );
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, text)
        })?;
        let word = own.as_deref().unwrap_or(common);
        let spread = Spread::named(word).ok_or_else(|| {
            let message = format!("`{word}` is no distribution");
            let help = "write `uniform`, `normal` or `triangular`";
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, word)
        })?;
        let place = model.parameters.iter().position(|p| p.name == *name).ok_or_else(|| {
            let message = format!("`{name}` is an initial value, which has no limits");
            DesignError::fault(
                codes::UNKNOWN_QUANTITY,
                message,
                "give limits to parameters, and positions with `at`",
            )
        })?;
        parts.push(Part {
            name: name.clone(),
            unit: stated.unit.clone(),
            place,
            nominal: stated.value,
            limits,
            spread,
        });
    }

    // Results, and the poses at which they are asked for.
    let read = |text: &String| {
        let read = formula(text, model, Some(&mechanism.system), &[]);
        read.map_err(|fault| located(fault, &source.text, text))
    };
    let results = wish.of.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let drives = wish.at.iter().map(|(name, values)| Drive::parse(model, name, values));
    let drives = drives.collect::<Result<Vec<Drive>, _>>()?;
    let prescribed: Vec<_> =
        drives.iter().map(|drive| (drive.name.clone(), drive.measure)).collect();
    let outputs: Vec<Expr> = results.iter().map(|result| result.expr).collect();
    let poses = Poses::new(&mechanism, &prescribed, &outputs, &[])?;
    let n_at = drives.iter().map(|drive| drive.range.n).max().unwrap_or(1);
    let default = (100_000 / n_at as u64).max(2000);
    let n_samples = wish.samples.unwrap_or(default);

    let job = Job {
        poses: &poses,
        parts: &parts,
        steps: steps(&mechanism, &poses),
        parameters: &|point: &[f64]| study.parameters_at(point),
        n_outputs: outputs.len(),
        seed: wish.seed.unwrap_or(0),
        watch,
    };
    let mut solver = poses.solver();
    let mut pose = poses.start.clone();
    let mut found = Vec::new();
    for k in 0..n_at {
        let u: Vec<f64> =
            drives.iter().map(|drive| drive.range.values()[k.min(drive.range.n - 1)]).collect();
        let p = pose.p.clone();
        pose = solver.follow(&pose, &p, &u).map_err(|_| {
            let message = format!("the pose with {} is not reached from the start", told(&drives, &u));
            DesignError::fault(codes::NOT_ASSEMBLED, message, "choose values within the range of the mechanism: `bksim kinematics MODEL --limits`")
        })?;
        let at = drives.iter().map(|drive| drive.name.clone()).zip(u.iter().copied()).collect();
        let mut bands = job.pose(&pose, at, n_samples)?;
        for (band, (text, result)) in bands.bands.iter_mut().zip(wish.of.iter().zip(&results)) {
            band.of.clone_from(text);
            band.unit.clone_from(&result.unit);
        }
        found.push(bands);
        (watch.reached)("poses", (k + 1) as f64 / n_at as f64);
        if (watch.stop)() {
            break;
        }
    }
    Ok(Tolerance { poses: found, samples: n_samples, stopped: (watch.stop)() })
}

fn told(drives: &[Drive], u: &[f64]) -> String {
    let one = |(drive, u): (&Drive, &f64)| {
        format!("{} = {}", drive.name, bksim::model::message::short(*u))
    };
    drives.iter().zip(u).map(one).collect::<Vec<_>>().join(", ")
}

/// Rows, outputs and their slopes for intervals.
fn steps(mechanism: &bksim::Mechanism, poses: &Poses) -> Option<Steps> {
    let pool = &mechanism.model.pool;
    let slopes = pool.jacobian(&poses.expressions, &poses.symbols[1..]);
    let entries = slopes.entries.iter().map(|entry| entry.2);
    let all: Vec<Expr> = poses.expressions.iter().copied().chain(entries).collect();
    let names: Vec<String> = poses.symbols.iter().map(|&symbol| pool.symbol_name(symbol)).collect();
    Steps::of(pool, &all, &names)
}

/// All that a pose needs.
struct Job<'a> {
    poses: &'a Poses,
    parts: &'a [Part],
    steps: Option<Steps>,
    /// The parameters of the model at values of the parts.
    parameters: &'a (dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync),
    n_outputs: usize,
    seed: u64,
    watch: Watch<'a>,
}

/// Pieces into which the box is cut for a proof.
const MOST_PIECES: usize = 512;
/// Samples with generators of their own.
const CHUNK: u64 = 1000;

/// Sums over samples.
#[derive(Clone)]
struct Sums {
    n: u64,
    n_open: u64,
    /// By output: offsets from the nominal value to the powers 1, 2, 3; least and largest value.
    of: Vec<[f64; 5]>,
}

impl Job<'_> {
    fn pose(
        &self,
        pose: &Pose,
        at: BTreeMap<String, f64>,
        n_samples: u64,
    ) -> Result<PoseTolerance, DesignError> {
        let mut solver = self.poses.solver();
        let singular = || {
            let message = "the nominal pose is a dead centre, in which slopes have no bound";
            DesignError::fault(
                codes::NOT_ASSEMBLED,
                message,
                "ask at another pose, or change the nominal lengths",
            )
        };
        let here = solver.outputs(pose, &[]).ok_or_else(singular)?;
        let by_parts = &here.by_p * self.by_parts()?;
        let sums = self.samples(pose, n_samples, &here.values);
        let (n, n_open) = (sums.n as f64, sums.n_open as f64);
        let share = if n > 0.0 { n_open / n } else { f64::NAN };
        let mut assembles = if sums.n_open > 0 { Some(false) } else { None };
        let mut bands = Vec::new();
        for k in 0..self.n_outputs {
            let nominal = here.values[k];
            let slopes: Vec<f64> = by_parts.row(k).iter().copied().collect();
            let linear: Vec<f64> =
                self.parts.iter().zip(&slopes).map(|(p, s)| (s * p.half()).abs()).collect();
            let sigma_of = |part: &Part, linear: f64| linear * part.spread.sigma();
            let worst: f64 = linear.iter().sum();
            let variance: f64 =
                self.parts.iter().zip(&linear).map(|(p, l)| sigma_of(p, *l).powi(2)).sum();
            let shift: f64 =
                self.parts.iter().zip(&slopes).map(|(p, s)| s * (p.middle() - p.nominal)).sum();
            let linear_interval = [nominal + shift - worst, nominal + shift + worst];
            let ends = self.ends(&mut solver, pose, k);
            if ends.is_open {
                assembles = Some(false);
            } else if ends.proved && assembles.is_none() {
                assembles = Some(true);
            }
            let exact = ends.interval;
            let [s1, s2, s3, least, most] = sums.of[k];
            let m = n - n_open;
            let mean = s1 / m;
            let variance_found = (s2 / m - mean * mean).max(0.0) * m / (m - 1.0);
            let sigma = variance_found.sqrt();
            let skewness = (s3 / m - 3.0 * mean * s2 / m + 2.0 * mean.powi(3)) / sigma.powi(3);
            let ratio = (linear_interval[1] - linear_interval[0]) / (exact[1] - exact[0]);
            let contributors = self.parts.iter().enumerate().map(|(i, part)| Contributor {
                name: part.name.clone(),
                unit: part.unit.clone(),
                limits: part.limits,
                distribution: part.spread.word(),
                sensitivity: slopes[i],
                linear: linear[i],
                percent_of_worst: 100.0 * linear[i] / worst,
                percent_of_variance: 100.0 * sigma_of(part, linear[i]).powi(2) / variance,
            });
            bands.push(Band {
                of: String::new(),
                unit: String::new(),
                nominal,
                linear_worst: worst,
                linear_interval,
                rss: linear.iter().map(|l| l * l).sum::<f64>().sqrt(),
                sigma_linear: variance.sqrt(),
                exact_interval: exact,
                exact_at: ends.at,
                proved: ends.proved,
                linear_fails: ends.is_open || !(0.9..1.1).contains(&ratio),
                mean: [nominal + mean, sigma / m.sqrt()],
                sigma: [sigma, sigma / (2.0 * m).sqrt()],
                skewness,
                sampled: [least, most],
                contributors: contributors.collect(),
            });
        }
        let share_without_assembly = [share, (share * (1.0 - share) / n).sqrt()];
        Ok(PoseTolerance { at, assembles, share_without_assembly, bands })
    }

    fn nominal(&self) -> Vec<f64> {
        self.parts.iter().map(|part| part.nominal).collect()
    }

    /// Derivatives of all parameters by the parts.
    fn by_parts(&self) -> Result<DMatrix<f64>, DesignError> {
        let nominal = self.nominal();
        let refused = || {
            let message = "the model refuses values next to the nominal ones";
            DesignError::fault(
                codes::NO_START,
                message,
                "narrow the limits, or correct the nominal values",
            )
        };
        let n = self.poses.start.p.len();
        let mut by = DMatrix::zeros(n, self.parts.len());
        for (k, part) in self.parts.iter().enumerate() {
            let moved = |off: f64| {
                let mut point = nominal.clone();
                point[k] += off;
                (self.parameters)(&point).ok_or_else(refused)
            };
            let step = part.half();
            let (above, below) = (moved(step)?, moved(-step)?);
            for i in 0..n {
                by[(i, k)] =
                    if i == part.place { 1.0 } else { (above[i] - below[i]) / (2.0 * step) };
            }
        }
        Ok(by)
    }

    /// The corner with these ends of the limits.
    fn corner(&self, is_upper: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let end = |(k, part): (usize, &Part)| part.nominal + part.limits[usize::from(is_upper(k))];
        self.parts.iter().enumerate().map(end).collect()
    }

    fn value(
        &self,
        solver: &mut Solver<'_>,
        pose: &Pose,
        point: &[f64],
        k: usize,
    ) -> Result<f64, Option<Pose>> {
        let p = (self.parameters)(point).ok_or(None)?;
        let found = solver.follow(pose, &p, &pose.u).map_err(|(last, _)| Some(last))?;
        Ok(solver.raw(&found.q, &found.p, &found.u).2[k])
    }

    /// The ends of a result over the box.
    fn ends(&self, solver: &mut Solver<'_>, pose: &Pose, k: usize) -> Ends {
        // By the signs of all slopes, where they are proved.
        if let Some(signs) = self.signs(pose, k) {
            let of = |turn: bool| {
                let is_upper = |part: usize| (signs[part] > 0.0) != turn;
                let point = self.corner(&is_upper);
                let words = (0..self.parts.len())
                    .map(|part| if is_upper(part) { "+" } else { "-" })
                    .collect();
                (point, words)
            };
            let ((low, low_at), (high, high_at)) = (of(true), of(false));
            let low = self.value(solver, pose, &low, k);
            let high = self.value(solver, pose, &high, k);
            if let (Ok(low), Ok(high)) = (low, high) {
                return Ends {
                    interval: [low, high],
                    at: [low_at, high_at],
                    proved: true,
                    is_open: false,
                };
            }
        }
        self.searched(solver, pose, k)
    }

    /// Corners and poses where the assembly ends, then a search from the best of them.
    fn searched(&self, solver: &mut Solver<'_>, pose: &Pose, k: usize) -> Ends {
        let n = self.parts.len();
        let mut ends = [(f64::INFINITY, None), (f64::NEG_INFINITY, None)];
        let mut is_open = false;
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let n_corners = if n <= 10 { 1usize << n } else { 1024 };
        for tried in 0..n_corners + 64 {
            let point = if tried < n_corners && n <= 10 {
                self.corner(&|part| tried >> part & 1 == 1)
            } else {
                let random: Vec<bool> = (0..n).map(|_| rng.random()).collect();
                self.corner(&|part| random[part])
            };
            let Some(p) = (self.parameters)(&point) else { continue };
            let end = match solver.follow(pose, &p, &pose.u) {
                Ok(found) => found,
                Err((last, _)) => {
                    is_open = true;
                    last
                }
            };
            let value = solver.raw(&end.q, &end.p, &end.u).2[k];
            let words: Vec<&'static str> = if end.p == p {
                (0..n).map(|i| if point[i] > self.parts[i].middle() { "+" } else { "-" }).collect()
            } else {
                Vec::new()
            };
            let found = Some((end, point, words));
            if value < ends[0].0 {
                ends[0] = (value, found.clone());
            }
            if value > ends[1].0 {
                ends[1] = (value, found);
            }
        }
        let mut interval = [ends[0].0, ends[1].0];
        let mut at = [Vec::new(), Vec::new()];
        for (side, (value, from)) in ends.into_iter().enumerate() {
            let Some((from, point, words)) = from else { continue };
            let sign = if side == 0 { 1.0 } else { -1.0 };
            at[side] = words;
            if let Some(better) = self.refined(pose, &from, &point, k, sign)
                && sign * better < sign * value - 1e-12 * value.abs()
            {
                interval[side] = better;
                at[side] = Vec::new();
            }
        }
        Ends { interval, at, proved: false, is_open }
    }

    /// The least of `sign` h over coordinates and parts, on the side of the nominal pose.
    fn refined(
        &self,
        nominal: &Pose,
        from: &Pose,
        point: &[f64],
        k: usize,
        sign: f64,
    ) -> Option<f64> {
        let poses = self.poses;
        let n = poses.n();
        let side = poses.solver().side(nominal);
        let range = 0.5;
        let unscaled = |x: &[f64]| {
            let q: Vec<f64> = (0..n)
                .map(|i| from.q[i] + (x[i] - 0.5) * 2.0 * range * poses.unit_of_q(i))
                .collect();
            let parts = self.parts.iter().zip(&x[n..]);
            let parts: Vec<f64> = parts
                .map(|(part, x)| part.nominal + part.limits[0] + x * 2.0 * part.half())
                .collect();
            (q, parts)
        };
        let evaluate = |points: &[Vec<f64>]| -> Vec<Option<Vec<f64>>> {
            let mut solver = poses.solver();
            let one = |x: &Vec<f64>| {
                let (q, parts) = unscaled(x);
                let p = (self.parameters)(&parts)?;
                let (rows, determinant, outputs) = solver.raw(&q, &p, &nominal.u);
                Some([&[sign * outputs[k]][..], &rows, &[side * determinant]].concat())
            };
            points.iter().map(one).collect()
        };
        // Where the way to the corner ended, its parts are between nominal ones and the corner's.
        let reached = |(part, target): (&Part, &f64)| {
            let whole = target - part.nominal;
            let moved = from.p[part.place] - part.nominal;
            let share = if whole == 0.0 { 0.0 } else { (moved / whole).clamp(0.0, 1.0) };
            (part.nominal + share * whole - part.nominal - part.limits[0]) / (2.0 * part.half())
        };
        let start: Vec<f64> =
            vec![0.5; n].into_iter().chain(self.parts.iter().zip(point).map(reached)).collect();
        let problem = Problem {
            n: n + self.parts.len(),
            n_goals: 1,
            n_equal: n,
            evaluate: &evaluate,
            stop: &|| false,
            reached: &|_, _| (),
        };
        let found = problem.minimize(start)?;
        (found.violation < 1e-9).then(|| sign * found.values[0])
    }

    /// The signs of all slopes of a result, if they are the same throughout the box; pieces of it are looked at one by one.
    fn signs(&self, pose: &Pose, k: usize) -> Option<Vec<f64>> {
        let steps = self.steps.as_ref()?;
        // Parameters that follow from others are intervals of their own only if each is a part itself.
        let whole: Vec<Interval> = self
            .parts
            .iter()
            .map(|p| Interval::new(p.nominal + p.limits[0], p.nominal + p.limits[1]))
            .collect();
        let nominal = (self.parameters)(&self.nominal())?;
        let moved = (self.parameters)(&self.corner(&|_| true))?;
        let is_part = |i: usize| self.parts.iter().any(|part| part.place == i);
        if (0..nominal.len()).any(|i| !is_part(i) && moved[i] != nominal[i]) {
            return None;
        }
        let mut open = vec![whole];
        let mut signs: Option<Vec<f64>> = None;
        let mut n_seen = 0;
        while let Some(piece) = open.pop() {
            n_seen += 1;
            if n_seen > MOST_PIECES {
                return None;
            }
            let Some(found) = self.signs_in(steps, pose, k, &piece) else {
                // Halves along the part that is widest.
                let width = |i: &usize| piece[*i].radius() / self.parts[*i].half();
                let widest = (0..piece.len()).max_by(|a, b| width(a).total_cmp(&width(b)))?;
                let [mut low, mut high] = [piece.clone(), piece.clone()];
                let middle = piece[widest].middle();
                low[widest].hi = middle;
                high[widest].lo = middle;
                open.extend([low, high]);
                continue;
            };
            match &signs {
                Some(known) if known.iter().zip(&found).any(|(a, b)| a * b < 0.0) => return None,
                _ => signs = Some(found),
            }
        }
        signs
    }

    /// The signs of slopes in one piece, by Krawczyk's operator.
    fn signs_in(
        &self,
        steps: &Steps,
        pose: &Pose,
        k: usize,
        piece: &[Interval],
    ) -> Option<Vec<f64>> {
        let poses = self.poses;
        let n = poses.n();
        let mut solver = poses.solver();
        // The pose in the middle of the piece.
        let middle: Vec<f64> = piece.iter().map(|p| p.middle()).collect();
        let p = (self.parameters)(&middle)?;
        let m = solver.follow(pose, &p, &pose.u).ok()?;
        let mut p_box: Vec<Interval> = p.iter().map(|&p| Interval::point(p)).collect();
        for (part, bounds) in self.parts.iter().zip(piece) {
            p_box[part.place] = *bounds;
        }
        let inputs = |q: Vec<Interval>| [vec![Interval::point(0.0)], q, p_box.clone()].concat();
        let at_middle: Vec<Interval> = m.q.iter().map(|&q| Interval::point(q)).collect();
        let rows: Vec<Interval> = steps.over(&inputs(at_middle.clone()))[..n]
            .iter()
            .enumerate()
            .map(|(row, value)| {
                let (prescribed, is_angle) = poses.row(row);
                let value = prescribed.map_or(*value, |k| value.add(Interval::point(-pose.u[k])));
                let turns = (value.middle() / std::f64::consts::TAU).round();
                let off =
                    if is_angle && turns != 0.0 { -turns * std::f64::consts::TAU } else { 0.0 };
                if off == 0.0 {
                    value
                } else {
                    value.add(
                        Interval::point(off)
                            .add(Interval::new(-1e-15 * off.abs(), 1e-15 * off.abs())),
                    )
                }
            })
            .collect();
        let matrix = |values: &[Interval], from: usize, to: usize, first: usize, count: usize| {
            let mut all = vec![vec![Interval::point(0.0); count]; to - from];
            for (&(row, column), value) in poses.slopes().iter().zip(&values[n + self.n_outputs..])
            {
                if (from..to).contains(&row) && (first..first + count).contains(&column) {
                    all[row - from][column - first] = *value;
                }
            }
            all
        };
        let n_p = p.len();
        let here = steps.over(&inputs(at_middle));
        let slopes = matrix(&here, 0, n, 0, n);
        let y = DMatrix::from_fn(n, n, |i, j| slopes[i][j].middle()).try_inverse()?;
        let column = |v: &[Interval]| v.iter().map(|x| vec![*x]).collect::<Vec<_>>();
        let newton = times(&y, &column(&rows));
        // A box around the pose that the operator maps into itself.
        let mut radius: Vec<f64> = newton.iter().map(|x| 2.0 * x[0].size() + 1e-14).collect();
        for _ in 0..8 {
            let x_box: Vec<Interval> =
                m.q.iter().zip(&radius).map(|(q, r)| Interval::new(q - r, q + r)).collect();
            let values = steps.over(&inputs(x_box.clone()));
            let a = times(&y, &matrix(&values, 0, n, 0, n));
            let off = |i: usize, j: usize| {
                Interval::point(if i == j { 1.0 } else { 0.0 }).add(a[i][j].scaled(-1.0))
            };
            let image: Vec<Interval> = (0..n)
                .map(|i| {
                    let begin = Interval::point(m.q[i]).add(newton[i][0].scaled(-1.0));
                    let terms =
                        (0..n).map(|j| off(i, j).multiply(Interval::new(-radius[j], radius[j])));
                    terms.fold(begin, Interval::add)
                })
                .collect();
            if image.iter().any(|x| !x.size().is_finite()) {
                return None;
            }
            if image.iter().zip(&x_box).all(|(image, of)| image.is_within(*of)) {
                return self.signs_of(k, (&values, &matrix), &y, (&a, n_p));
            }
            for (radius, (image, q)) in radius.iter_mut().zip(image.iter().zip(&m.q)) {
                *radius = 1.2 * (image.hi - q).abs().max((image.lo - q).abs()) + 1e-15;
            }
        }
        None
    }

    /// The signs of dh/dp, from bounds of all slopes.
    fn signs_of(
        &self,
        k: usize,
        (values, matrix): (
            &[Interval],
            &dyn Fn(&[Interval], usize, usize, usize, usize) -> Vec<Vec<Interval>>,
        ),
        y: &DMatrix<f64>,
        (a, n_p): (&[Vec<Interval>], usize),
    ) -> Option<Vec<f64>> {
        let n = self.poses.n();
        // D = −(Y Φ_q)⁻¹ Y Φ_p, with I − Y Φ_q smaller than one.
        let row_sum = |i: usize| {
            (0..n)
                .map(|j| {
                    let one = Interval::point(if i == j { 1.0 } else { 0.0 });
                    one.add(a[i][j].scaled(-1.0)).size()
                })
                .sum::<f64>()
        };
        let e = (0..n).map(row_sum).fold(0.0, f64::max) * (1.0 + 1e-12);
        if !(e < 1.0) {
            return None;
        }
        let b = times(y, &matrix(values, 0, n, n, n_p));
        let h_q = matrix(values, n + k, n + k + 1, 0, n);
        let h_p = matrix(values, n + k, n + k + 1, n, n_p);
        let sign = |part: &Part| {
            let column: Vec<Interval> = b.iter().map(|row| row[part.place]).collect();
            let largest = column.iter().map(|x| x.size()).fold(0.0, f64::max);
            let spread = e / (1.0 - e) * largest * (1.0 + 1e-12);
            let terms = (0..n).map(|i| {
                let d = column[i].scaled(-1.0).add(Interval::new(-spread, spread));
                h_q[0][i].multiply(d)
            });
            let slope = terms.fold(h_p[0][part.place], Interval::add);
            match slope {
                Interval { lo, .. } if lo >= 0.0 => Some(1.0),
                Interval { hi, .. } if hi <= 0.0 => Some(-1.0),
                // Nothing depends on it, but for rounding.
                slope if slope.size() < 1e-13 => Some(1.0),
                _ => None,
            }
        };
        self.parts.iter().map(sign).collect()
    }

    /// Samples on all cores; the same for any number of them.
    fn samples(&self, pose: &Pose, n_samples: u64, nominal: &[f64]) -> Sums {
        let none = Sums {
            n: 0,
            n_open: 0,
            of: vec![[0.0, 0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY]; self.n_outputs],
        };
        let chunk = |number: u64| {
            let mut sums = none.clone();
            if (self.watch.stop)() {
                return sums;
            }
            let mut rng =
                Pcg64Mcg::seed_from_u64(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number);
            let mut solver = self.poses.solver();
            for _ in 0..CHUNK.min(n_samples - number * CHUNK) {
                let point: Vec<f64> = self
                    .parts
                    .iter()
                    .map(|part| part.middle() + part.half() * part.spread.sample(&mut rng))
                    .collect();
                sums.n += 1;
                let p = (self.parameters)(&point);
                let found = p.and_then(|p| solver.follow(pose, &p, &pose.u).ok());
                let Some(found) = found else {
                    sums.n_open += 1;
                    continue;
                };
                let values = solver.raw(&found.q, &found.p, &found.u).2;
                for ((sums, value), nominal) in sums.of.iter_mut().zip(&values).zip(nominal) {
                    let off = value - nominal;
                    sums[0] += off;
                    sums[1] += off * off;
                    sums[2] += off * off * off;
                    sums[3] = sums[3].min(*value);
                    sums[4] = sums[4].max(*value);
                }
            }
            sums
        };
        let chunks: Vec<Sums> = (0..n_samples.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        chunks.into_iter().fold(none.clone(), |mut all, chunk| {
            all.n += chunk.n;
            all.n_open += chunk.n_open;
            for (all, own) in all.of.iter_mut().zip(&chunk.of) {
                for power in 0..3 {
                    all[power] += own[power];
                }
                all[3] = all[3].min(own[3]);
                all[4] = all[4].max(own[4]);
            }
            all
        })
    }
}

/// The ends of a result over the box of limits.
struct Ends {
    interval: [f64; 2],
    at: [Vec<&'static str>; 2],
    proved: bool,
    /// Whether some parts do not assemble.
    is_open: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_in_all_their_forms() {
        let of = |text: &str| limits_of(text).map(|(limits, _)| limits.map(|x| (x * 1e6).round()));
        assert_eq!(of("±0.1 mm"), Some([-100.0, 100.0]));
        assert_eq!(of("+-0.1 mm"), Some([-100.0, 100.0]));
        assert_eq!(of("0.1 mm"), Some([-100.0, 100.0]));
        assert_eq!(of("+0.2/-0.1 mm"), Some([-100.0, 200.0]));
        assert_eq!(of("0/-20 um"), Some([-20.0, 0.0]));
        assert_eq!(of("-0.1/+0.1 mm"), None, "the upper one comes first");
        assert_eq!(of("much"), None);
    }
}
