//! Four-bars that carry a body through poses, after Burmester.
//!
//! ```text
//! |pⱼ + Rⱼ w − c|² = |p₁ + R₁ w − c|²        j = 2 … n;  c centre, w pin in the body's frame
//! ```
//!
//! Each condition is linear in 1, w, c and the two parts of w̄ c. Of five poses four conditions give c by w and two
//! conics for w: at most four dyads. Of four poses the centres are a cubic, whose points have one pin each. Of three
//! poses every centre has one pin, and every pin one centre; of two poses the centres of a pin are a line. Source: McCarthy, Soh, Geometric Design of Linkages, ch. 5.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector2};
use serde::Deserialize;

use super::four_bar::{FourBar, distance, in_order, side};
use super::polynomial::{real_roots, roots, through};
use super::{DesignError, Point, Synthesis, all_si, none, si};
use crate::codes;
use crate::spec::Written;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// Place of the body's origin and its angle: `["0 m", "1 m", "30 deg"]`.
    poses: Vec<[Written; 3]>,
    /// Of four poses, and of two with pins: lines `y = …` on which centres are looked for.
    #[serde(default)]
    lines_y: Vec<Written>,
    /// Of three poses: the centres, two or more.
    #[serde(default)]
    centres: Vec<[Written; 2]>,
    /// Of two and three poses: pins, places in the body.
    #[serde(default)]
    pins: Vec<[Written; 2]>,
    /// Corners of a rectangle in which all centres have to be.
    region: Option<[[Written; 2]; 2]>,
}

/// A pose: place and angle.
#[derive(Clone, Copy, Debug)]
struct Pose {
    p: Point,
    angle: f64,
}

/// A bar between a centre and a pin of the body.
#[derive(Clone, Copy, Debug)]
struct Dyad {
    centre: Point,
    pin: Point,
}

impl Pose {
    fn of(&self, w: Point) -> Point {
        let (cos, sin) = (self.angle.cos(), self.angle.sin());
        [self.p[0] + cos * w[0] - sin * w[1], self.p[1] + sin * w[0] + cos * w[1]]
    }
}

/// The condition of two poses, as coefficients of 1, u, v, x, y, u x + v y, u y − v x.
fn condition(first: &Pose, other: &Pose) -> [f64; 7] {
    let [mut all, other] = [first, other].map(|pose| {
        let ([x, y], cos, sin) = (pose.p, pose.angle.cos(), pose.angle.sin());
        // |P|²/2 − P·c, without |w|²/2 and |c|²/2, which are the same in all poses.
        [0.5 * (x * x + y * y), x * cos + y * sin, y * cos - x * sin, -x, -y, -cos, -sin]
    });
    for (a, b) in all.iter_mut().zip(other) {
        *a = b - *a;
    }
    all
}

fn off(conditions: &[[f64; 7]], dyad: &Dyad) -> DVector<f64> {
    let ([u, v], [x, y]) = (dyad.pin, dyad.centre);
    let monomials = [1.0, u, v, x, y, u * x + v * y, u * y - v * x];
    DVector::from_fn(conditions.len(), |i, _| {
        conditions[i].iter().zip(monomials).map(|(c, m)| c * m).sum()
    })
}

/// Newton's iteration on four conditions.
fn improved(conditions: &[[f64; 7]], dyad: Dyad) -> Option<Dyad> {
    let mut at = dyad;
    for _ in 0..8 {
        let ([u, v], [x, y]) = (at.pin, at.centre);
        let slopes = DMatrix::from_fn(4, 4, |i, j| {
            let c = &conditions[i];
            match j {
                0 => c[1] + c[5] * x + c[6] * y,
                1 => c[2] + c[5] * y - c[6] * x,
                2 => c[3] + c[5] * u - c[6] * v,
                _ => c[4] + c[5] * v + c[6] * u,
            }
        });
        let step = slopes.lu().solve(&off(conditions, &at))?;
        at.pin = [u - step[0], v - step[1]];
        at.centre = [x - step[2], y - step[3]];
    }
    let size = 1.0 + distance(at.pin, at.centre);
    (off(conditions, &at).amax() < 1e-9 * size * size).then_some(at)
}

/// The dyads of five poses, real ones, and the number of complex ones.
fn of_five(conditions: &[[f64; 7]]) -> Option<(Vec<Dyad>, usize)> {
    // Four conditions for x, y and the two products by 1, u, v.
    let left = DMatrix::from_fn(4, 4, |i, j| conditions[i][3 + j]);
    let right = DMatrix::from_fn(4, 3, |i, j| -conditions[i][j]);
    let by = left.lu().solve(&right)?;
    // Two conics: u x + v y and u y − v x are what they are by their own rows; in turned axes, lest one has no v².
    let (cos, sin) = (0.7f64.cos(), 0.7f64.sin());
    let conics = |s: f64, t: f64| {
        let (u, v) = (cos * s - sin * t, sin * s + cos * t);
        let of = |row: usize| by[(row, 0)] + by[(row, 1)] * u + by[(row, 2)] * v;
        let (x, y) = (of(0), of(1));
        [u * x + v * y - of(2), u * y - v * x - of(3)]
    };
    // a t² + b t + c of each conic at s.
    let in_t = |s: f64| {
        let [low, middle, high] = [-1.0, 0.0, 1.0].map(|t| conics(s, t));
        [0, 1].map(|k| [0.5 * (high[k] + low[k]) - middle[k], 0.5 * (high[k] - low[k]), middle[k]])
    };
    let minors = |s: f64| {
        let [[a1, b1, c1], [a2, b2, c2]] = in_t(s);
        [a1 * c2 - a2 * c1, a1 * b2 - a2 * b1, b1 * c2 - b2 * c1]
    };
    let resultant = |s: f64| {
        let [ac, ab, bc] = minors(s);
        ac * ac - ab * bc
    };
    let coefficients = through(4, resultant);
    let n_complex = roots(&coefficients).len();
    let mut found: Vec<Dyad> = Vec::new();
    for s in real_roots(&coefficients) {
        let [ac, ab, _] = minors(s);
        let t = -ac / ab;
        let pin = [cos * s - sin * t, sin * s + cos * t];
        let of = |row: usize| by[(row, 0)] + by[(row, 1)] * pin[0] + by[(row, 2)] * pin[1];
        let dyad = improved(conditions, Dyad { centre: [of(0), of(1)], pin });
        let is_new = |dyad: &Dyad| {
            found.iter().all(|known| {
                distance(known.pin, dyad.pin) > 1e-8 * (1.0 + distance(dyad.pin, [0.0, 0.0]))
            })
        };
        found.extend(dyad.filter(is_new));
    }
    Some((found, n_complex))
}

/// Rows by the pin: what u, v and 1 are multiplied with at a centre.
fn by_pin(conditions: &[[f64; 7]], [x, y]: Point) -> DMatrix<f64> {
    DMatrix::from_fn(conditions.len(), 3, |i, j| {
        let c = &conditions[i];
        [c[1] + c[5] * x + c[6] * y, c[2] + c[5] * y - c[6] * x, c[0] + c[3] * x + c[4] * y][j]
    })
}

/// The pin that belongs to a centre.
fn pin_of(conditions: &[[f64; 7]], centre: Point) -> Option<Point> {
    let rows = by_pin(conditions, centre);
    // The two rows whose minor is largest.
    let n = rows.nrows();
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let minor = |(i, j): (usize, usize)| rows[(i, 0)] * rows[(j, 1)] - rows[(i, 1)] * rows[(j, 0)];
    let (i, j) = pairs.max_by(|a, b| minor(*a).abs().total_cmp(&minor(*b).abs()))?;
    let matrix = Matrix2::new(rows[(i, 0)], rows[(i, 1)], rows[(j, 0)], rows[(j, 1)]);
    let pin = matrix.lu().solve(&Vector2::new(-rows[(i, 2)], -rows[(j, 2)]))?;
    (pin[0].is_finite() && pin[1].is_finite()).then_some([pin[0], pin[1]])
}

/// Factors of x, y and 1 at a pin, a row for each condition.
fn by_centre(conditions: &[[f64; 7]], [u, v]: Point) -> Vec<[f64; 3]> {
    let row = |c: &[f64; 7]| {
        [c[3] + c[5] * u - c[6] * v, c[4] + c[5] * v + c[6] * u, c[0] + c[1] * u + c[2] * v]
    };
    conditions.iter().map(row).collect()
}

/// The centres of a pin: of two conditions one, of one condition those on lines `y = …`.
fn centres_of(conditions: &[[f64; 7]], pin: Point, lines: &[f64]) -> Vec<Point> {
    let found: Vec<Point> = match by_centre(conditions, pin).as_slice() {
        [[a, b, c]] => lines.iter().map(|y| [-(c + b * y) / a, *y]).collect(),
        [[a, b, c], [d, e, f], ..] => {
            let determinant = a * e - b * d;
            vec![[(b * f - c * e) / determinant, (c * d - a * f) / determinant]]
        }
        [] => Vec::new(),
    };
    found.into_iter().filter(|centre| centre.iter().all(|x| x.is_finite())).collect()
}

/// Exponents of the cubic's terms.
const TERMS: [[i32; 2]; 10] =
    [[3, 0], [2, 1], [1, 2], [0, 3], [2, 0], [1, 1], [0, 2], [1, 0], [0, 1], [0, 0]];

/// The cubic of centres of four poses.
fn cubic(conditions: &[[f64; 7]], size: f64) -> Option<Vec<f64>> {
    let determinant = |[x, y]: Point| {
        let rows = by_pin(conditions, [x * size, y * size]);
        Matrix3::from_fn(|i, j| rows[(i, j)]).determinant()
    };
    // Through more points than need be, in units of the task.
    let points: Vec<Point> = (0..24)
        .map(|k| {
            let angle = 2.399_963 * f64::from(k);
            let radius = 0.3 + 0.05 * f64::from(k);
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let matrix = DMatrix::from_fn(24, 10, |i, j| {
        points[i][0].powi(TERMS[j][0]) * points[i][1].powi(TERMS[j][1])
    });
    let values = DVector::from_fn(24, |i, _| determinant(points[i]));
    let found = matrix.svd(true, true).solve(&values, 1e-14).ok()?;
    let unscaled = |k: usize| found[k] / size.powi(TERMS[k][0] + TERMS[k][1]);
    let first = unscaled(0);
    Some((0..10).map(|k| unscaled(k) / first).collect())
}

/// The pole of two poses: the point that does not move.
fn pole(a: &Pose, b: &Pose) -> Option<Point> {
    let turn = b.angle - a.angle;
    let (cos, sin) = (turn.cos(), turn.sin());
    // c = p_b + R (c − p_a).
    let matrix = Matrix2::new(1.0 - cos, sin, -sin, 1.0 - cos);
    let right = Vector2::new(
        b.p[0] - (cos * a.p[0] - sin * a.p[1]),
        b.p[1] - (sin * a.p[0] + cos * a.p[1]),
    );
    matrix.lu().solve(&right).map(|c| [c[0], c[1]])
}

pub(super) fn solve(wish: &Wish) -> Result<Synthesis, DesignError> {
    let read = |[x, y, angle]: &[Written; 3]| Ok(Pose { p: [si(x)?, si(y)?], angle: si(angle)? });
    let poses = wish.poses.iter().map(read).collect::<Result<Vec<Pose>, DesignError>>()?;
    let has_choice = match poses.len() {
        2 => !wish.pins.is_empty() && !wish.lines_y.is_empty(),
        3 => !wish.centres.is_empty() || !wish.pins.is_empty(),
        n => n == 4 || n == 5,
    };
    if !has_choice {
        let message = format!("{} poses make no task of finitely many dyads", poses.len());
        return Err(DesignError::fault(
            codes::BAD_QUESTION,
            message,
            "give two poses with `pins` and `lines_y`, three with `centres` or `pins`, four with `lines_y`, or five",
        ));
    }
    let conditions: Vec<[f64; 7]> =
        poses[1..].iter().map(|pose| condition(&poses[0], pose)).collect();
    let mut facts: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut dyads = Vec::new();
    match poses.len() {
        5 => {
            let (found, n_complex) = of_five(&conditions).ok_or_else(|| {
                none(
                    "the poses are too special for finitely many dyads",
                    "change one of them a little",
                )
            })?;
            facts.insert("complex_dyads".to_owned(), vec![n_complex as f64]);
            dyads = found;
        }
        4 => {
            let size = poses.iter().map(|pose| distance(pose.p, poses[0].p)).fold(1e-3, f64::max);
            let cubic = cubic(&conditions, size).ok_or_else(|| {
                none("the poses have no cubic of centres", "change one of them a little")
            })?;
            for (k, line) in wish.lines_y.iter().enumerate() {
                let y = si(line)?;
                let along = |x: f64| {
                    let terms = TERMS.iter().zip(&cubic);
                    terms.map(|([i, j], c)| c * (x * size).powi(*i) * y.powi(*j)).sum::<f64>()
                };
                let _ = k;
                for x in real_roots(&through(3, along)) {
                    let centre = [x * size, y];
                    dyads.extend(pin_of(&conditions, centre).map(|pin| Dyad { centre, pin }));
                }
            }
            for i in 0..4 {
                for j in i + 1..4 {
                    if let Some(pole) = pole(&poses[i], &poses[j]) {
                        facts.insert(format!("pole_{}_{}", i + 1, j + 1), pole.to_vec());
                    }
                }
            }
            facts.insert("cubic_x3_x2y_xy2_y3_x2_xy_y2_x_y_1".to_owned(), cubic);
        }
        n => {
            for [x, y] in wish.centres.iter().filter(|_| n == 3) {
                let centre = [si(x)?, si(y)?];
                dyads.extend(pin_of(&conditions, centre).map(|pin| Dyad { centre, pin }));
            }
            let lines = all_si(&wish.lines_y)?;
            for [u, v] in &wish.pins {
                let pin = [si(u)?, si(v)?];
                let centres = centres_of(&conditions, pin, &lines);
                dyads.extend(centres.into_iter().map(|centre| Dyad { centre, pin }));
            }
        }
    }
    let n_found = dyads.len();
    if let Some([[x0, y0], [x1, y1]]) = &wish.region {
        let (low, high) = ([si(x0)?, si(y0)?], [si(x1)?, si(y1)?]);
        dyads.retain(|d| (0..2).all(|k| low[k] <= d.centre[k] && d.centre[k] <= high[k]));
    }
    for (k, dyad) in dyads.iter().enumerate() {
        let at_first = poses[0].of(dyad.pin);
        let numbers = [dyad.centre, at_first, dyad.pin].concat();
        facts.insert(
            format!("dyad_{}", k + 1),
            [numbers, vec![distance(dyad.centre, at_first)]].concat(),
        );
    }
    facts.insert("real_dyads".to_owned(), vec![dyads.len() as f64]);

    // Every two make a four-bar.
    let mut candidates = Vec::new();
    for i in 0..dyads.len() {
        for j in i + 1..dyads.len() {
            let (a, b) = (&dyads[i], &dyads[j]);
            if distance(a.centre, b.centre) < 1e-9 || distance(a.pin, b.pin) < 1e-9 {
                continue;
            }
            let bars: Vec<FourBar> = poses
                .iter()
                .map(|pose| FourBar {
                    pivots: [a.centre, b.centre],
                    pins: [pose.of(a.pin), pose.of(b.pin)],
                    point: Some(pose.p),
                })
                .collect();
            let mut candidate = bars[0].candidate(&format!("poses-{}-{}", i + 1, j + 1));
            let same = |of: &dyn Fn(&FourBar) -> f64| {
                let signs: Vec<bool> = bars.iter().map(|bar| of(bar) > 0.0).collect();
                signs.windows(2).all(|pair| pair[0] == pair[1])
            };
            let driven_at_1 = same(&|bar| side(bar.pins[0], bar.pins[1], bar.pivots[1]));
            let driven_at_2 = same(&|bar| side(bar.pins[1], bar.pins[0], bar.pivots[0]));
            candidate.checks.insert("one_branch_if_driven_at_1".to_owned(), driven_at_1);
            candidate.checks.insert("one_branch_if_driven_at_2".to_owned(), driven_at_2);
            candidate.checks.insert("in_order_at_1".to_owned(), in_order(&bars, 0));
            candidate.checks.insert("in_order_at_2".to_owned(), in_order(&bars, 1));
            let least = bars.iter().map(FourBar::transmission).fold(f64::INFINITY, f64::min);
            candidate.numbers.insert("least_transmission_angle".to_owned(), least);
            candidates.push(candidate);
        }
    }
    // Those without a defect first, then by transmission.
    let rank = |c: &super::Candidate| {
        let good = |k: u8| {
            c.checks[&format!("one_branch_if_driven_at_{k}")]
                && c.checks[&format!("in_order_at_{k}")]
        };
        (!(good(1) || good(2)), -c.numbers["least_transmission_angle"])
    };
    candidates.sort_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let is_cubic_alone = poses.len() == 4 && wish.lines_y.is_empty();
    if dyads.is_empty() && !is_cubic_alone {
        let why = match facts.get("complex_dyads").and_then(|all| all.first()) {
            _ if n_found > 0 => format!("none of {n_found} bars has its centre in `region`"),
            Some(n) => {
                format!("of the {n} bars that keep their lengths through these poses none is real")
            }
            None => "no bar keeps its length through these poses".to_owned(),
        };
        let help = "change a pose, widen `region`, or name other `lines_y`, `centres` or `pins`";
        return Err(none(&why, help));
    }
    Ok(Synthesis { task: "poses".to_owned(), facts, candidates, ..Synthesis::default() })
}
