//! Four-bars: types, checks, cognates, and their models.

use std::collections::BTreeMap;
use std::fmt::Write;

use nalgebra::Complex;
use serde::Deserialize;

use super::{Candidate, DesignError, Point, Synthesis, none, optional, si};
use crate::spec::Written;

/// A four-bar in one pose: pivots, pins, and a point of the coupler.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct FourBar {
    /// Pivots of crank and rocker.
    pub(super) pivots: [Point; 2],
    /// Pins of crank and rocker.
    pub(super) pins: [Point; 2],
    pub(super) point: Option<Point>,
}

pub(super) fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Twice the signed area of a triangle.
pub(super) fn side(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

impl FourBar {
    /// Crank, coupler, rocker, ground.
    pub(super) fn lengths(&self) -> [f64; 4] {
        let ([a, d], [b, c]) = (self.pivots, self.pins);
        [distance(a, b), distance(b, c), distance(d, c), distance(a, d)]
    }

    /// Grashof's condition, and the type.
    pub(super) fn kind(&self) -> (bool, &'static str) {
        let [crank, coupler, rocker, ground] = self.lengths();
        let mut sorted = [crank, coupler, rocker, ground];
        sorted.sort_by(f64::total_cmp);
        let margin = sorted[1] + sorted[2] - sorted[0] - sorted[3];
        if margin.abs() < 1e-12 * sorted[3] {
            return (true, "change point");
        }
        if margin < 0.0 {
            return (false, "triple rocker");
        }
        let kind = match sorted[0] {
            least if least == ground => "double crank",
            least if least == crank => "crank-rocker",
            least if least == rocker => "rocker-crank",
            _ => "double rocker",
        };
        (true, kind)
    }

    /// The acute angle between coupler and rocker, rad.
    pub(super) fn transmission(&self) -> f64 {
        let [b, c] = self.pins;
        let d = self.pivots[1];
        let along = |p: Point| (c[1] - p[1]).atan2(c[0] - p[0]);
        let angle = (along(b) - along(d)).rem_euclid(std::f64::consts::PI);
        angle.min(std::f64::consts::PI - angle)
    }

    /// The candidate of this name.
    pub(super) fn candidate(&self, name: &str) -> Candidate {
        let [crank, coupler, rocker, ground] = self.lengths();
        let (is_grashof, kind) = self.kind();
        let mut numbers: BTreeMap<String, f64> =
            [("crank", crank), ("coupler", coupler), ("rocker", rocker), ("ground", ground)]
                .into_iter()
                .map(|(name, value)| (name.to_owned(), value))
                .collect();
        let places = [
            ("pivot_1", self.pivots[0]),
            ("pivot_2", self.pivots[1]),
            ("pin_1", self.pins[0]),
            ("pin_2", self.pins[1]),
        ];
        for (name, [x, y]) in places {
            numbers.insert(format!("{name}_x"), x);
            numbers.insert(format!("{name}_y"), y);
        }
        Candidate {
            name: name.to_owned(),
            numbers,
            kind: Some(kind.to_owned()),
            checks: [("grashof".to_owned(), is_grashof)].into_iter().collect(),
            model: self.model(name),
        }
    }

    /// Model of the four-bar: links of one kilogram, which begin to move from this pose.
    pub(super) fn model(&self, name: &str) -> String {
        self.model_with(name, None)
    }

    /// The model with what the coupler's point moves.
    pub(super) fn model_with(&self, name: &str, second: Option<Second>) -> String {
        let [crank, coupler, rocker, _] = self.lengths();
        let ([a, d], [b, c]) = (self.pivots, self.pins);
        let angle = |from: Point, to: Point| (to[1] - from[1]).atan2(to[0] - from[0]);
        let of_coupler = angle(b, c);
        let point = self.point.map_or(String::new(), |p| {
            let (x, y) = (p[0] - b[0], p[1] - b[1]);
            let (cos, sin) = (of_coupler.cos(), of_coupler.sin());
            format!(", P = [\"{} m\", \"{} m\"]", x * cos + y * sin, y * cos - x * sin)
        });
        let mut text = format!(
            "name = \"{name}\"\n\n[parameters]\ncrank = \"{crank} m\"\ncoupler = \"{coupler} m\"\nrocker = \"{rocker} m\"\n{}\n[ground]\npoints = {{ A = [\"{} m\", \"{} m\"], D = [\"{} m\", \"{} m\"]{} }}\n",
            match (second, self.point) {
                (Some(Second::Rocker([g, q])), Some(p)) => {
                    format!("link = \"{} m\"\noutput = \"{} m\"\n", distance(p, q), distance(g, q))
                }
                (Some(Second::Slide(_, reach)), _) => format!("output = \"{reach} m\"\n"),
                _ => String::new(),
            },
            a[0],
            a[1],
            d[0],
            d[1],
            second.map_or(String::new(), |second| {
                let [x, y] = second.pivot();
                format!(", G = [\"{x} m\", \"{y} m\"]")
            })
        );
        let mut bodies = vec![
            ("crank", "A", "B", String::new()),
            ("coupler", "B", "C", point),
            ("rocker", "D", "C", String::new()),
        ];
        let mut joints = vec![
            ("A", "ground.A", "crank.A"),
            ("B", "crank.B", "coupler.B"),
            ("C", "coupler.C", "rocker.C"),
            ("D", "ground.D", "rocker.D"),
        ];
        match second {
            Some(Second::Rocker(_)) => {
                bodies.extend([
                    ("link", "P", "Q", String::new()),
                    ("output", "G", "Q", String::new()),
                ]);
                joints.extend([
                    ("P", "coupler.P", "link.P"),
                    ("Q", "link.Q", "output.Q"),
                    ("G", "ground.G", "output.G"),
                ]);
            }
            Some(Second::Slide(..)) => {
                bodies.push(("output", "G", "E", String::new()));
                joints.extend([("P", "coupler.P", "block"), ("G", "ground.G", "output.G")]);
                text += "\n[bodies.block]\nmass = \"0.1 kg\"\ninertia = 0\n\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"output\", \"block\"]\naxis = [1, 0]\n";
            }
            None => (),
        }
        for (body, from, to, more) in bodies {
            text += &bar(body, [from, to], &more);
        }
        for (joint, from, to) in joints {
            text += &revolute(joint, [from, to]);
        }
        let start = angle(a, b).to_degrees();
        let _ = write!(
            text,
            "\n[initial]\nA = {{ angle = \"{start} deg\", rate = \"1 rad/s\" }}\nB = {{ guess = {{ angle = \"{} deg\" }} }}\nD = {{ guess = {{ angle = \"{} deg\" }} }}\n",
            of_coupler.to_degrees() - start,
            angle(d, c).to_degrees()
        );
        if let (Some(second), Some(p)) = (second, self.point) {
            let (of_p, of_g) = match second {
                Second::Rocker([g, q]) => (angle(p, q), angle(g, q)),
                Second::Slide(g, _) => (angle(g, p), angle(g, p)),
            };
            let _ = write!(
                text,
                "P = {{ guess = {{ angle = \"{} deg\" }} }}\nG = {{ guess = {{ angle = \"{} deg\" }} }}\n",
                (of_p - of_coupler).to_degrees(),
                of_g.to_degrees()
            );
            if let Second::Slide(g, _) = second {
                let _ =
                    writeln!(text, "S = {{ guess = {{ position = \"{} m\" }} }}", distance(g, p));
            }
        }
        text += "\n[solve]\nt_end = \"0.5 s\"\n";
        text
    }
}

/// Link that the point of a coupler moves.
#[derive(Clone, Copy, Debug)]
pub(super) enum Second {
    /// A link to the pin of a second rocker: its pivot, and the pin.
    Rocker([Point; 2]),
    /// A block in the slot of an arm: its pivot, and its length, m.
    Slide(Point, f64),
}

impl Second {
    fn pivot(self) -> Point {
        match self {
            Self::Rocker([pivot, _]) | Self::Slide(pivot, _) => pivot,
        }
    }
}

/// True if a crank passes its angles one after the other in one sense, within a turn.
pub(super) fn in_order(bars: &[FourBar], which: usize) -> bool {
    let angle = |bar: &FourBar| {
        let (from, to) = (bar.pivots[which], bar.pins[which]);
        (to[1] - from[1]).atan2(to[0] - from[0])
    };
    let angles: Vec<f64> = bars.iter().map(angle).collect();
    let sum_of = |sense: f64| -> f64 {
        angles
            .windows(2)
            .map(|pair| (sense * (pair[1] - pair[0])).rem_euclid(std::f64::consts::TAU))
            .sum()
    };
    sum_of(1.0) < std::f64::consts::TAU || sum_of(-1.0) < std::f64::consts::TAU
}

/// True if poses of one four-bar are on one circuit: in a Grashof linkage the angles at the joints that its shortest link is
/// not in keep their sense.
pub(super) fn one_circuit(bars: &[FourBar]) -> bool {
    let Some(first) = bars.first() else { return true };
    let [crank, coupler, rocker, ground] = first.lengths();
    if !first.kind().0 {
        return true;
    }
    let least = crank.min(coupler).min(rocker).min(ground);
    let sense = |bar: &FourBar| {
        let ([a, d], [b, c]) = (bar.pivots, bar.pins);
        if least == crank {
            side(b, c, d)
        } else if least == coupler {
            side(d, a, b)
        } else {
            side(a, b, c)
        }
    };
    let signs: Vec<bool> = bars.iter().map(|bar| sense(bar) > 0.0).collect();
    signs.windows(2).all(|pair| pair[0] == pair[1])
}

/// A four-bar whose cognates are asked for.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct CognateWish {
    crank: Written,
    coupler: Written,
    rocker: Written,
    ground: Written,
    /// In the coupler's frame: from the crank pin, x to the rocker pin.
    point: [Written; 2],
    /// Angle of the crank at which all are drawn; 60° unless given.
    angle: Option<Written>,
    /// True if the rocker pin is to the right of the line from crank pin to rocker pivot.
    #[serde(default)]
    crossed: bool,
}

type C = Complex<f64>;

fn xy(z: C) -> Point {
    [z.re, z.im]
}

/// Roberts' and Chebyshev's cognates: `λ = p/b`; third pivot `d λ`.
pub(super) fn cognates(wish: &CognateWish) -> Result<Synthesis, DesignError> {
    let [a, b, c, d] = [si(&wish.crank)?, si(&wish.coupler)?, si(&wish.rocker)?, si(&wish.ground)?];
    let p = C::new(si(&wish.point[0])?, si(&wish.point[1])?);
    let angle = optional(wish.angle.as_ref())?.unwrap_or(std::f64::consts::FRAC_PI_3);
    // The pose: crank pin, rocker pin.
    let pin = C::from_polar(a, angle);
    let to_pivot = C::new(d, 0.0) - pin;
    let l = to_pivot.norm();
    let cosine = (b * b + l * l - c * c) / (2.0 * b * l);
    if cosine.abs() > 1.0 {
        let help = "give another `angle` of the crank, at which the four-bar closes";
        return Err(none("the four-bar does not close at that angle of its crank", help));
    }
    let turn = if wish.crossed { -cosine.acos() } else { cosine.acos() };
    let coupler = C::from_polar(b, to_pivot.arg() + turn);
    let lambda = p / b;
    let point = pin + coupler * lambda;
    let third = C::new(d, 0.0) * lambda;
    let zero = C::new(0.0, 0.0);
    let ground = C::new(d, 0.0);
    let other_pin = pin + coupler;
    let rocker = other_pin - ground;
    let own = FourBar {
        pivots: [xy(zero), xy(ground)],
        pins: [xy(pin), xy(other_pin)],
        point: Some(xy(point)),
    };
    // Parallelograms from the coupler point to the pivots, triangles similar to the coupler's.
    let first = FourBar {
        pivots: [xy(zero), xy(third)],
        pins: [xy(point - pin), xy(third + rocker * lambda)],
        point: Some(xy(point)),
    };
    let second = FourBar {
        pivots: [xy(ground), xy(third)],
        pins: [xy(ground + point - other_pin), xy(third + pin * (C::new(1.0, 0.0) - lambda))],
        point: Some(xy(point)),
    };
    let mut candidates = Vec::new();
    // A point on a pin draws a circle, and has no others.
    let has_links = |bar: &FourBar| bar.lengths().iter().all(|length| *length > 1e-9 * (a + d));
    let all = [("given", own), ("cognate-1", first), ("cognate-2", second)];
    for (name, bar) in all.into_iter().filter(|(name, bar)| *name == "given" || has_links(bar)) {
        let mut candidate = bar.candidate(name);
        let [from, to] = bar.pins.map(|[x, y]| C::new(x, y));
        let over = (point - from) / (to - from);
        candidate.numbers.insert("point_over_coupler_x".to_owned(), over.re);
        candidate.numbers.insert("point_over_coupler_y".to_owned(), over.im);
        for (k, name) in ["bar_1_angle", "bar_2_angle"].into_iter().enumerate() {
            let (from, to) = (bar.pivots[k], bar.pins[k]);
            candidate.numbers.insert(name.to_owned(), (to[1] - from[1]).atan2(to[0] - from[0]));
        }
        candidates.push(candidate);
    }
    let facts = [
        ("third_pivot".to_owned(), vec![third.re, third.im]),
        ("point".to_owned(), vec![point.re, point.im]),
    ];
    Ok(Synthesis {
        task: "cognates".to_owned(),
        facts: facts.into_iter().collect(),
        candidates,
        ..Synthesis::default()
    })
}

/// The text of a uniform bar of 1 kg, whose length is a parameter of its name, with points at both ends and `more`.
pub(super) fn bar(name: &str, [from, to]: [&str; 2], more: &str) -> String {
    format!(
        "\n[bodies.{name}]\nmass = \"1 kg\"\ninertia = \"1 kg*{name}^2/12\"\ncom = [\"{name}/2\", 0]\npoints = {{ {from} = [0, 0], {to} = [\"{name}\", 0]{more} }}\n"
    )
}

/// The text of a revolute joint between two points.
pub(super) fn revolute(name: &str, [from, to]: [&str; 2]) -> String {
    format!("\n[joints.{name}]\ntype = \"revolute\"\nbetween = [\"{from}\", \"{to}\"]\n")
}
