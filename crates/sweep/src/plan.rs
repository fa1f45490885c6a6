//! Which values each case has: grids and samples, computed from a case's number.

use bksim::model::diagnostic::Diagnostic;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

use crate::axis::{Axis, Values};
use crate::codes;

/// How cases fill the space of the axes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Design {
    /// Every value with every other; the last axis turns fastest.
    Grid,
    /// The first value of every axis, then the second of every axis, and so on.
    Pairs,
    /// Independent samples.
    Random {
        /// How many.
        n: u64,
        /// Equal seeds, equal samples.
        seed: u64,
    },
    /// Latin hypercube: one sample in each of n equal parts of every axis.
    LatinHypercube {
        /// How many.
        n: u64,
        /// Equal seeds, equal samples.
        seed: u64,
    },
    /// Sobol's sequence with Owen's scrambling: 2^k samples fill the space most evenly.
    Sobol {
        /// How many.
        n: u64,
        /// Equal seeds, equal samples.
        seed: u64,
    },
}

impl Design {
    /// True if it takes samples.
    pub fn is_sampled(&self) -> bool {
        !matches!(self, Self::Grid | Self::Pairs)
    }
}

/// The cases of a sweep.
#[derive(Clone, Debug)]
pub struct Plan {
    axes: Vec<Axis>,
    design: Design,
    n_cases: u64,
    /// The part of each axis that each sample of a Latin hypercube lies in.
    parts: Vec<Vec<u32>>,
}

/// More cases than this are refused: their table would have a hundred million rows.
pub const LARGEST: u64 = 100_000_000;

/// More samples of a Latin hypercube are refused: their order takes four bytes each.
const LARGEST_HYPERCUBE: u64 = 10_000_000;

/// Sobol's sequence has so many points, and axes, in the library that is used.
const LARGEST_SOBOL: (u64, usize) = (1 << 16, 256);

impl Plan {
    /// The cases of these axes.
    ///
    /// # Errors
    /// A diagnostic when an axis occurs twice or does not fit the design, or there are too many
    /// cases.
    pub fn new(axes: Vec<Axis>, design: Design) -> Result<Self, Diagnostic> {
        // Axes, each once.
        for (idx, axis) in axes.iter().enumerate() {
            if axes[..idx].iter().any(|known| known.name == axis.name) {
                let message = format!("`{}` is varied twice", axis.name);
                let help = "give each axis once; a list of values may hold any numbers";
                return Err(Diagnostic::error(codes::AXIS_TWICE, message).help(help));
            }
        }

        // Cases, as many as the design has or can have.
        let n_cases = match design {
            Design::Grid => n_of_grid(&axes)?,
            Design::Pairs => n_of_pairs(&axes)?,
            Design::Random { n, .. }
            | Design::LatinHypercube { n, .. }
            | Design::Sobol { n, .. } => {
                check_ranges(&axes)?;
                n
            }
        };
        let (largest, of) = match design {
            Design::LatinHypercube { .. } => (LARGEST_HYPERCUBE, "a Latin hypercube"),
            Design::Sobol { .. } => (LARGEST_SOBOL.0, "Sobol's sequence"),
            _ => (LARGEST, "a sweep"),
        };
        if n_cases == 0 || n_cases > largest {
            let message = format!("{of} of {n_cases} cases");
            let help = format!("ask for 1 to {largest} cases, or split the sweep");
            return Err(Diagnostic::error(codes::N_CASES, message).help(help));
        }
        if matches!(design, Design::Sobol { .. }) && axes.len() > LARGEST_SOBOL.1 {
            let message = format!("Sobol's sequence of {} axes", axes.len());
            let help = format!("vary up to {} quantities, or use random samples", LARGEST_SOBOL.1);
            return Err(Diagnostic::error(codes::N_CASES, message).help(help));
        }

        // The order of the parts of a hypercube; all else follows from the number of a case.
        let parts = match design {
            Design::LatinHypercube { n, seed } => {
                (0..axes.len()).map(|axis_idx| shuffled(n, seed, axis_idx)).collect()
            }
            _ => Vec::new(),
        };
        Ok(Self { axes, design, n_cases, parts })
    }

    /// The varied quantities.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How cases fill their space.
    pub fn design(&self) -> Design {
        self.design
    }

    /// Number of cases.
    pub fn n_cases(&self) -> u64 {
        self.n_cases
    }

    /// Writes the numbers of a case, one per axis in its unit.
    ///
    /// # Panics
    /// When `case` is not below [`Plan::n_cases`], or `numbers` is not as long as the list of axes.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "checked counts"
    )]
    pub fn case(&self, case: u64, numbers: &mut [f64]) {
        assert!(case < self.n_cases, "case {case} of {}", self.n_cases);
        assert_eq!(numbers.len(), self.axes.len(), "one number per axis");
        match self.design {
            Design::Grid => {
                let mut rest = case;
                for (axis, number) in self.axes.iter().zip(numbers).rev() {
                    let n = axis.n_values().expect("a plan refuses grids over ranges");
                    *number = axis.value(rest % n);
                    rest /= n;
                }
            }
            Design::Pairs => {
                for (axis, number) in self.axes.iter().zip(numbers) {
                    *number = axis.value(case);
                }
            }
            Design::Random { seed, .. } => {
                for (axis_idx, (axis, number)) in self.axes.iter().zip(numbers).enumerate() {
                    *number = axis.sample(uniform(seed, axis_idx, case));
                }
            }
            Design::LatinHypercube { n, seed } => {
                for (axis_idx, (axis, number)) in self.axes.iter().zip(numbers).enumerate() {
                    let part = f64::from(self.parts[axis_idx][case as usize]);
                    *number = axis.sample((part + uniform(seed, axis_idx, case)) / n as f64);
                }
            }
            Design::Sobol { seed, .. } => {
                for (axis_idx, (axis, number)) in self.axes.iter().zip(numbers).enumerate() {
                    let seed = (seed ^ (seed >> 32)) as u32;
                    let at = sobol_burley::sample(case as u32, axis_idx as u32, seed);
                    *number = axis.sample(f64::from(at));
                }
            }
        }
    }

    /// In words that say all of it, for people and for fingerprints.
    pub fn describe(&self) -> String {
        let axes: Vec<String> = self.axes.iter().map(Axis::describe).collect();
        let design = match self.design {
            Design::Grid => "grid".to_owned(),
            Design::Pairs => "pairs".to_owned(),
            Design::Random { n, seed } => format!("{n} random samples, seed {seed}"),
            Design::LatinHypercube { n, seed } => format!("Latin hypercube of {n}, seed {seed}"),
            Design::Sobol { n, seed } => format!("{n} of Sobol's sequence, seed {seed}"),
        };
        format!("{design}\n{}", axes.join("\n"))
    }
}

/// A generator of its own for each axis.
fn generator(seed: u64, axis_idx: usize) -> Pcg64 {
    Pcg64::new(u128::from(seed), axis_idx as u128)
}

/// From 0 up to 1; one step of the axis's generator per case.
fn uniform(seed: u64, axis_idx: usize, case: u64) -> f64 {
    let mut generator = generator(seed, axis_idx);
    generator.advance(u128::from(case));
    generator.random()
}

/// The numbers below `n` in an order of the axis's own.
#[expect(clippy::cast_possible_truncation, reason = "checked: below ten million")]
fn shuffled(n: u64, seed: u64, axis_idx: usize) -> Vec<u32> {
    let mut parts: Vec<u32> = (0..n as u32).collect();
    // Another stream than the positions within the parts.
    parts.shuffle(&mut generator(!seed, axis_idx));
    parts
}

fn n_of_grid(axes: &[Axis]) -> Result<u64, Diagnostic> {
    let mut counts = axes.iter().map(|axis| counted(axis, "a grid"));
    counts.try_fold(1u64, |n_cases, n| Ok(n_cases.saturating_mul(n?)))
}

/// Number of cases in pairs: every axis has this many values.
fn n_of_pairs(axes: &[Axis]) -> Result<u64, Diagnostic> {
    let Some(first) = axes.first() else { return Ok(1) };
    let n_cases = counted(first, "pairs")?;
    for axis in axes {
        let n = counted(axis, "pairs")?;
        if n != n_cases {
            let message = format!(
                "the axes `{}` and `{}` of pairs have {n_cases} and {n} values",
                first.name, axis.name
            );
            let help = "give every axis as many values, or leave out the pairs for a grid";
            return Err(Diagnostic::error(codes::BAD_AXIS, message).help(help));
        }
    }
    Ok(n_cases)
}

/// Number of values of an axis that has one.
fn counted(axis: &Axis, of: &str) -> Result<u64, Diagnostic> {
    axis.n_values().ok_or_else(|| {
        let name = &axis.name;
        let message = format!("the axis `{name}` of {of} does not say how many values it has");
        let help =
            format!("add a count, as in `{name}=0.8:1.2:41`, or ask for samples of this range");
        Diagnostic::error(codes::BAD_AXIS, message).help(help)
    })
}

/// Samples lie between ends or in lists.
fn check_ranges(axes: &[Axis]) -> Result<(), Diagnostic> {
    let Some(axis) = axes.iter().find(|axis| matches!(axis.values, Values::Even { .. })) else {
        return Ok(());
    };
    let name = &axis.name;
    let message = format!("the axis `{name}` has a count, but samples lie anywhere in its range");
    let help =
        format!("leave out the count: `{name}=0.8:1.2`, or leave out the samples for a grid");
    Err(Diagnostic::error(codes::BAD_AXIS, message).help(help))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(axes: &[(&str, &str)], design: Design) -> Result<Plan, Diagnostic> {
        let axes = axes.iter().map(|(name, text)| {
            Axis::parse(name, text).map(|axis| axis.expect("more than one value"))
        });
        Plan::new(axes.collect::<Result<_, _>>()?, design)
    }

    fn cases(plan: &Plan) -> Vec<Vec<f64>> {
        let case = |idx| {
            let mut numbers = vec![0.0; plan.axes().len()];
            plan.case(idx, &mut numbers);
            numbers
        };
        (0..plan.n_cases()).map(case).collect()
    }

    #[test]
    fn a_grid_has_every_pair_once() {
        let plan = plan(&[("a", "1:2:2"), ("b", "5,7,9")], Design::Grid).expect("a plan");
        let expected = [[1.0, 5.0], [1.0, 7.0], [1.0, 9.0], [2.0, 5.0], [2.0, 7.0], [2.0, 9.0]];
        assert_eq!(cases(&plan), expected);
    }

    #[test]
    fn pairs_take_one_value_of_every_axis() {
        let pairs = |axes| plan(axes, Design::Pairs);
        let plan = pairs(&[("a", "1:3:3"), ("b", "5,7,9")]).expect("a plan");
        assert_eq!(cases(&plan), [[1.0, 5.0], [2.0, 7.0], [3.0, 9.0]]);
        let uneven = pairs(&[("a", "1:3:3"), ("b", "5,7")]).expect_err("a fault");
        assert_eq!(uneven.code, codes::BAD_AXIS);
    }

    #[test]
    fn a_hypercube_has_one_sample_in_each_part_of_each_axis() {
        let design = Design::LatinHypercube { n: 50, seed: 3 };
        let plan = plan(&[("a", "0:1"), ("b", "-2:3")], design).expect("a plan");
        let all = cases(&plan);
        for (axis_idx, (from, span)) in [(0.0, 1.0), (-2.0, 5.0)].into_iter().enumerate() {
            let mut parts: Vec<f64> =
                all.iter().map(|case| ((case[axis_idx] - from) / span * 50.0).floor()).collect();
            parts.sort_by(f64::total_cmp);
            assert_eq!(parts, (0..50).map(f64::from).collect::<Vec<_>>());
        }
        let a: Vec<f64> = all.iter().map(|case| case[0]).collect();
        assert!(!a.is_sorted(), "the parts are shuffled");
    }

    #[test]
    fn samples_fill_their_range_and_follow_their_seed() {
        for design in [
            |seed| Design::Random { n: 4096, seed },
            |seed| Design::LatinHypercube { n: 4096, seed },
            |seed| Design::Sobol { n: 4096, seed },
        ] {
            let of_seed = |seed| {
                cases(&plan(&[("a", "1:3"), ("b", "10:1000:log")], design(seed)).expect("a plan"))
            };
            let all = of_seed(1);
            assert_eq!(all, of_seed(1), "{:?}", design(1));
            assert_ne!(all, of_seed(2), "{:?}", design(1));
            let mean = all.iter().map(|case| case[0]).sum::<f64>() / 4096.0;
            // The deviation of 4096 random samples is 0.58/64.
            assert!((mean - 2.0).abs() < 4.0 * 0.009, "{:?}: {mean}", design(1));
            let middle = all.iter().map(|case| case[1].ln()).sum::<f64>() / 4096.0;
            assert!((middle - 100f64.ln()).abs() < 4.0 * 0.021, "{:?}: {middle}", design(1));
            assert!(all.iter().all(|case| (1.0..3.0).contains(&case[0])));
            let both = all.iter().map(|c| (c[0] - 2.0) * (c[1].ln() - 100f64.ln())).sum::<f64>();
            assert!((both / 4096.0).abs() < 0.05, "axes hang together: {both}");
        }
    }

    #[test]
    fn sobols_points_are_more_even_than_random_ones() {
        // Points in each of 16 × 16 boxes; 1024 of Sobol's have exactly four in each.
        let counts = |design| {
            let mut counts = [0; 256];
            for case in cases(&plan(&[("a", "0:16"), ("b", "0:16")], design).expect("a plan")) {
                let (i, j) = (case[0].floor(), case[1].floor());
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0 … 255"
                )]
                let box_idx = (16.0 * i + j) as usize;
                counts[box_idx] += 1;
            }
            counts
        };
        assert_eq!(counts(Design::Sobol { n: 1024, seed: 5 }), [4; 256]);
        assert_ne!(counts(Design::Random { n: 1024, seed: 5 }), [4; 256]);
    }

    #[test]
    fn plans_that_make_no_sense_are_refused() {
        let grid = |axes: &[(&str, &str)]| plan(axes, Design::Grid).expect_err("a fault").code;
        assert_eq!(grid(&[("a", "1:2:2"), ("a", "1:2:3")]), codes::AXIS_TWICE);
        assert_eq!(grid(&[("a", "1:2")]), codes::BAD_AXIS);
        assert_eq!(grid(&[("a", "1:2:99999"), ("b", "1:2:99999")]), codes::N_CASES);
        let many = "1:2:99999999999";
        assert_eq!(grid(&[("a", many), ("b", many), ("c", many)]), codes::N_CASES);
        let sobol = plan(&[("a", "1:2")], Design::Sobol { n: 65_537, seed: 0 });
        assert_eq!(sobol.expect_err("too many").code, codes::N_CASES);
        let counted = plan(&[("a", "1:2:3")], Design::Random { n: 5, seed: 0 });
        assert_eq!(counted.expect_err("a count").code, codes::BAD_AXIS);
    }
}
