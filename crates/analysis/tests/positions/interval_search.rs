//! Assemblies of random linkages against a search that knows nothing of groups: branch and bound over intervals.
//!
//! Unknowns are the angles of bodies, and the way of a slider; each loop gives two equations. A box is given up where an
//! equation has no zero in it, or where Krawczyk's operator leaves it; it holds exactly one solution where the operator maps it into
//! its inside. Source: R. E. Moore, R. B. Kearfott and M. J. Cloud, *Introduction to Interval Analysis* (2009), chapter 8.
//!
//! `BKSIM_ASSEMBLIES=10000 cargo test -p bksim-analysis --test analysis interval_search` takes as many linkages.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::support::geometry;
use bksim_analysis::assemblies;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// All numbers from the first to the second.
#[derive(Clone, Copy, Debug)]
struct Interval(f64, f64);

impl Interval {
    fn point(x: f64) -> Self {
        Self(x, x)
    }

    /// Outwards by more than one operation rounds.
    fn rounded(low: f64, high: f64) -> Self {
        Self(low.next_down().next_down(), high.next_up().next_up())
    }

    fn plus(self, other: Self) -> Self {
        Self::rounded(self.0 + other.0, self.1 + other.1)
    }

    fn times(self, other: Self) -> Self {
        let all = [self.0 * other.0, self.0 * other.1, self.1 * other.0, self.1 * other.1];
        let low = all.into_iter().fold(f64::INFINITY, f64::min);
        Self::rounded(low, all.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    fn scaled(self, by: f64) -> Self {
        self.times(Self::point(by))
    }

    fn cos(self) -> Self {
        // Where the cosine has an extreme, k π, between both ends.
        let (first, last) = ((self.0 / PI).ceil(), (self.1 / PI).floor());
        if last - first >= 1.0 {
            return Self(-1.0, 1.0);
        }
        let (a, b) = (self.0.cos(), self.1.cos());
        let (mut low, mut high) = (a.min(b) - 1e-15, a.max(b) + 1e-15);
        if first <= last {
            if first.rem_euclid(2.0) == 0.0 { high = 1.0 } else { low = -1.0 }
        }
        Self(low, high)
    }

    fn sin(self) -> Self {
        Self::rounded(self.0 - FRAC_PI_2, self.1 - FRAC_PI_2).cos()
    }

    fn width(self) -> f64 {
        self.1 - self.0
    }

    fn middle(self) -> f64 {
        0.5 * (self.0 + self.1)
    }
}

/// A vector of a loop.
#[derive(Clone, Copy, Debug)]
enum Part {
    Fixed([f64; 2]),
    /// Turned by the unknown angle.
    Turned(usize, [f64; 2]),
    /// Direction as long as the unknown.
    Slid(usize, [f64; 2]),
}

/// Loops whose vectors sum to zero.
struct Loops {
    loops: Vec<Vec<Part>>,
    n: usize,
}

impl Loops {
    /// Sums, and their slopes by the unknowns.
    fn at(&self, x: &[Interval]) -> (Vec<Interval>, Vec<Vec<Interval>>) {
        let zero = Interval::point(0.0);
        let turns: Vec<[Interval; 2]> = x.iter().map(|x| [x.cos(), x.sin()]).collect();
        let mut values = Vec::with_capacity(self.n);
        let mut slopes = Vec::with_capacity(self.n);
        for parts in &self.loops {
            let mut sum = [zero; 2];
            let mut rows = [vec![zero; self.n], vec![zero; self.n]];
            for part in parts {
                let (vector, slope) = match *part {
                    Part::Fixed(v) => (v.map(Interval::point), None),
                    Part::Slid(k, v) => {
                        (v.map(|v| x[k].scaled(v)), Some((k, v.map(Interval::point))))
                    }
                    Part::Turned(k, [u, v]) => {
                        let [cos, sin] = turns[k];
                        let turned =
                            [cos.scaled(u).plus(sin.scaled(-v)), sin.scaled(u).plus(cos.scaled(v))];
                        (turned, Some((k, [turned[1].scaled(-1.0), turned[0]])))
                    }
                };
                for i in 0..2 {
                    sum[i] = sum[i].plus(vector[i]);
                    if let Some((k, slope)) = slope {
                        rows[i][k] = rows[i][k].plus(slope[i]);
                    }
                }
            }
            values.extend(sum);
            slopes.extend(rows);
        }
        (values, slopes)
    }

    /// All solutions in a box, each once; `None` where one is too near to another to be told.
    fn solutions(&self, start: Vec<Interval>) -> Option<Vec<Vec<f64>>> {
        const NARROWEST: f64 = 1e-7;
        const MOST: usize = 400_000;
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut open = vec![start];
        let mut n_boxes = 0;
        while let Some(mut x) = open.pop() {
            n_boxes += 1;
            if n_boxes > MOST {
                return None;
            }
            let (values, slopes) = self.at(&x);
            if values.iter().any(|v| v.0 > 0.0 || v.1 < 0.0) {
                continue;
            }
            let before: f64 = x.iter().map(|x| x.width()).fold(0.0, f64::max);
            if before < 1.2 {
                match self.krawczyk(&x, &slopes) {
                    Krawczyk::None => continue,
                    Krawczyk::One(solution) => {
                        if !found.iter().any(|known| is_same(known, &solution)) {
                            found.push(solution);
                        }
                        continue;
                    }
                    Krawczyk::Within(smaller) => x = smaller,
                    Krawczyk::Unknown => {}
                }
            }
            let widest = (0..self.n).max_by(|&a, &b| x[a].width().total_cmp(&x[b].width()))?;
            if x[widest].width() < NARROWEST {
                return None;
            }
            let middle = x[widest].middle();
            let mut other = x.clone();
            (x[widest].1, other[widest].0) = (middle, middle);
            open.extend([other, x]);
        }
        Some(found)
    }

    /// K(X) = m − Y f(m) + (1 − Y J(X)) (X − m), Y = J(m)⁻¹.
    fn krawczyk(&self, x: &[Interval], slopes: &[Vec<Interval>]) -> Krawczyk {
        let n = self.n;
        let m: Vec<Interval> = x.iter().map(|x| Interval::point(x.middle())).collect();
        let (value, slope) = self.at(&m);
        let centre = DMatrix::from_fn(n, n, |i, k| slope[i][k].middle());
        let Some(y) = centre.try_inverse().filter(|y| y.amax() < 1e8) else {
            return Krawczyk::Unknown;
        };
        let (mut is_inside, mut shrinks) = (true, false);
        let mut next = Vec::with_capacity(n);
        for i in 0..n {
            let mut k = m[i];
            for j in 0..n {
                k = k.plus(value[j].scaled(-y[(i, j)]));
                let mut rest = Interval::point(if i == j { 1.0 } else { 0.0 });
                for (l, row) in slopes.iter().enumerate() {
                    rest = rest.plus(row[j].scaled(-y[(i, l)]));
                }
                let off = Interval::rounded(x[j].0 - m[j].1, x[j].1 - m[j].0);
                k = k.plus(rest.times(off));
            }
            if k.0 > x[i].1 || k.1 < x[i].0 {
                return Krawczyk::None;
            }
            is_inside &= k.0 > x[i].0 && k.1 < x[i].1;
            let both = Interval(k.0.max(x[i].0), k.1.min(x[i].1));
            shrinks |= both.width() < 0.7 * x[i].width();
            next.push(both);
        }
        if is_inside {
            return Krawczyk::One(self.refined(next.iter().map(|x| x.middle()).collect()));
        }
        if shrinks { Krawczyk::Within(next) } else { Krawczyk::Unknown }
    }

    /// Newton's steps from a point of a box that holds one solution.
    fn refined(&self, mut x: Vec<f64>) -> Vec<f64> {
        for _ in 0..12 {
            let (value, slope) =
                self.at(&x.iter().map(|x| Interval::point(*x)).collect::<Vec<_>>());
            let jacobian = DMatrix::from_fn(self.n, self.n, |i, k| slope[i][k].middle());
            let right = nalgebra::DVector::from_fn(self.n, |i, _| value[i].middle());
            let Some(step) = jacobian.lu().solve(&right) else { break };
            x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= step);
        }
        x
    }
}

enum Krawczyk {
    None,
    One(Vec<f64>),
    Within(Vec<Interval>),
    Unknown,
}

/// Whether two solutions are equal, whole turns aside.
fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs().min(turn(a - b).abs()) < 1e-6)
}

fn turn(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// A random linkage: its loops, its model, and the measure of each unknown.
struct Linkage {
    loops: Loops,
    text: String,
    unknowns: Vec<&'static str>,
    start: Vec<Interval>,
}

const KINDS: [&str; 6] =
    ["four-bar", "slider-crank", "watt-1", "watt-2", "stephenson-3", "stephenson-triad"];

fn linkage(kind: &str, random: &mut Pcg64) -> Linkage {
    let mut number = |low: f64, high: f64| {
        let x: f64 = random.random_range(low..high);
        (x * 1e3).round() / 1e3
    };
    let crank = number(-3.1, 3.1);
    let a = number(0.3, 1.5);
    let d = [number(0.6, 2.5), number(-0.5, 0.5)];
    let [b, c, l, o] = [0; 4].map(|_| number(0.6, 2.6));
    let g = [number(-2.0, 2.0), number(-2.0, 2.0)];
    let [e, f] = [0; 2].map(|_| [number(-1.5, 1.5), number(-1.5, 1.5)]);
    let tip = [a * crank.cos(), a * crank.sin()];
    let less = |v: [f64; 2]| Part::Fixed([-v[0], -v[1]]);
    let (fixed, turned) = (Part::Fixed, Part::Turned);
    let mut ground = format!("D = [{}, {}], G = [{}, {}]", d[0], d[1], g[0], g[1]);
    let revolute = |name: &str, first: &str, second: &str| {
        format!("{name} = {{ type = \"revolute\", between = [\"{first}\", \"{second}\"] }}\n")
    };
    let body = |name: &str, points: &[(&str, [f64; 2])]| {
        let points = points.iter().map(|(name, [x, y])| format!("{name} = [{x}, {y}]"));
        format!("{name} = {{ points = {{ {} }} }}\n", points.collect::<Vec<_>>().join(", "))
    };
    let mut bodies = body("crank", &[("B", [a, 0.0])]);
    let mut joints = revolute("A", "ground", "crank");
    let whole = Interval(-PI, PI);
    let four_bar = vec![fixed(tip), turned(0, [b, 0.0]), turned(1, [-c, 0.0]), less(d)];
    let (loops, unknowns, start) = match kind {
        "slider-crank" => {
            ground = format!("G = [{}, {}]", g[0], g[1]);
            bodies += &body("rod", &[("C", [b, 0.0])]);
            bodies += "slider = {}\n";
            joints += &revolute("B", "crank.B", "rod");
            joints += &revolute("C", "rod.C", "slider");
            joints += "S = { type = \"prismatic\", between = [\"ground.G\", \"slider\"], axis = [1, 0] }\n";
            let parts = vec![fixed(tip), turned(0, [b, 0.0]), less(g), Part::Slid(1, [-1.0, 0.0])];
            (vec![parts], vec!["rod.angle", "S.position"], vec![whole, Interval(-7.0, 7.0)])
        }
        "stephenson-triad" => {
            bodies += &body("link", &[("C", [b, 0.0])]);
            bodies += &body("platform", &[("E", e), ("F", f)]);
            bodies += &body("rocker", &[("E", [l, 0.0])]);
            bodies += &body("output", &[("F", [o, 0.0])]);
            for (name, first, second) in [
                ("B", "crank.B", "link"),
                ("C", "link.C", "platform"),
                ("D", "ground.D", "rocker"),
                ("E", "platform.E", "rocker.E"),
                ("G", "ground.G", "output"),
                ("F", "platform.F", "output.F"),
            ] {
                joints += &revolute(name, first, second);
            }
            let to_platform = [fixed(tip), turned(0, [b, 0.0])];
            let first = [&to_platform[..], &[turned(1, e), turned(2, [-l, 0.0]), less(d)]].concat();
            let second =
                [&to_platform[..], &[turned(1, f), turned(3, [-o, 0.0]), less(g)]].concat();
            let names = vec!["link.angle", "platform.angle", "rocker.angle", "output.angle"];
            (vec![first, second], names, vec![whole; 4])
        }
        _ => {
            bodies += &body("coupler", &[("C", [b, 0.0]), ("E", e)]);
            bodies += &body("rocker", &[("C", [c, 0.0]), ("F", f)]);
            joints += &revolute("B", "crank.B", "coupler");
            joints += &revolute("C", "coupler.C", "rocker.C");
            joints += &revolute("D", "ground.D", "rocker");
            let mut all = (vec![four_bar], vec!["coupler.angle", "rocker.angle"], vec![whole; 2]);
            let dyad = [turned(2, [l, 0.0]), turned(3, [-o, 0.0])];
            let (second, from, to) = match kind {
                "watt-1" => (
                    vec![fixed(tip), turned(0, e), less(d), turned(1, [-f[0], -f[1]])],
                    "coupler.E",
                    "rocker.F",
                ),
                "watt-2" => (vec![fixed(d), turned(1, f), less(g)], "rocker.F", "ground.G"),
                "stephenson-3" => {
                    (vec![fixed(tip), turned(0, e), less(g)], "coupler.E", "ground.G")
                }
                _ => (Vec::new(), "", ""),
            };
            if !second.is_empty() {
                bodies += &body("link", &[("H", [l, 0.0])]);
                bodies += &body("output", &[("H", [o, 0.0])]);
                joints += &revolute("E", from, "link");
                joints += &revolute("H", "link.H", "output.H");
                joints += &revolute("F", to, "output");
                all.0.push([&second[..], &dyad].concat());
                all.1.extend(["link.angle", "output.angle"]);
                all.2.extend([whole; 2]);
            }
            all
        }
    };
    let text = format!(
        "[ground]\npoints = {{ {ground} }}\n[bodies]\n{bodies}[joints]\n{joints}[initial]\n\
         A = {{ angle = {crank} }}\n"
    );
    let n = unknowns.len();
    Linkage { loops: Loops { loops, n }, text, unknowns, start }
}

#[test]
#[expect(clippy::print_stdout, reason = "the counts are what a long run is for")]
fn random_linkages_have_the_assemblies_that_an_interval_search_finds() {
    let n = std::env::var("BKSIM_ASSEMBLIES").ok().and_then(|n| n.parse().ok()).unwrap_or(60);
    let mut random = Pcg64::seed_from_u64(7);
    // Of each kind how many linkages have how many assemblies; those that either search leaves open.
    let mut counts = [[0_usize; 7]; KINDS.len()];
    let (mut n_open, mut n_unproved) = (0, 0);
    for k in 0..n {
        let kind = k % KINDS.len();
        let Linkage { loops, text, unknowns, start } = linkage(KINDS[kind], &mut random);
        let Some(expected) = loops.solutions(start) else {
            n_open += 1;
            continue;
        };
        let found = match assemblies(geometry(&text)) {
            Ok(found) => found,
            Err(error) => {
                assert!(expected.is_empty(), "{k}: {error}\n{text}{expected:?}");
                counts[kind][0] += 1;
                continue;
            }
        };
        if found.proof.is_none() {
            n_unproved += 1;
            continue;
        }
        assert_eq!(found.assemblies.len(), expected.len(), "{k}:\n{text}{expected:?}");
        for solution in &expected {
            let is_there = |a: &&bksim_analysis::Assembly| {
                unknowns.iter().zip(solution).all(|(name, expected)| {
                    let (_, value, unit) =
                        a.pose.iter().find(|(known, ..)| known == name).expect("a quantity");
                    let off = value - expected;
                    (if *unit == "rad" { turn(off) } else { off }).abs() < 1e-7
                })
            };
            let n_there = found.assemblies.iter().filter(is_there).count();
            assert_eq!(n_there, 1, "{k}: {solution:?}\n{text}");
        }
        counts[kind][expected.len()] += 1;
    }
    println!("{n} linkages, {n_open} left open by the search, {n_unproved} not proved:");
    for (kind, of) in KINDS.iter().zip(counts) {
        println!("{kind:18} {of:?}");
    }
    assert!((n_open + n_unproved) * 50 <= n, "{n_open} and {n_unproved} of {n}");
    // Every kind closes now and then.
    assert!(counts.iter().all(|of| of[1..].iter().sum::<usize>() > 0), "{counts:?}");
}
