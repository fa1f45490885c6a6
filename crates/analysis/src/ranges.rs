//! Ranges of quantities that are x₀ + N s for any s, some of which have bounds: linear programs, two for each quantity.

use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};

/// A quantity x = value + slopes · s, with the least and largest value that it may have, infinite where it has none.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Bounded {
    pub(crate) value: f64,
    pub(crate) slopes: Vec<f64>,
    pub(crate) bounds: [f64; 2],
}

/// The least and the largest value of each quantity while all keep to their bounds; `None` where no s does.
pub(crate) fn ranges(quantities: &[Bounded]) -> Option<Vec<[f64; 2]>> {
    // In units of the largest value, so that the tolerances of the linear programs are relative ones.
    let finite = quantities.iter().flat_map(|q| [q.value, q.bounds[0], q.bounds[1]]);
    let unit = finite.filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let unit = if unit > 0.0 { unit } else { 1.0 };
    let n = quantities.first().map_or(0, |quantity| quantity.slopes.len());
    let extreme = |target: &[f64],
                   direction: OptimizationDirection|
     -> Result<f64, microlp::Error> {
        let mut problem = Problem::new(direction);
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let s: Vec<Variable> = target.iter().map(|&slope| problem.add_var(slope, free)).collect();
        for Bounded { value, slopes, bounds: [least, most] } in quantities {
            let terms = || s.iter().copied().zip(slopes.iter().copied()).collect::<Vec<_>>();
            if least.is_finite() {
                problem.add_constraint(terms(), ComparisonOp::Ge, (least - value) / unit);
            }
            if most.is_finite() {
                problem.add_constraint(terms(), ComparisonOp::Le, (most - value) / unit);
            }
        }
        match problem.solve()?.into_solution() {
            Ok(solution) => Ok(solution.objective()),
            Err(_) => Err(microlp::Error::InternalError(String::new())),
        }
    };
    // Whether anything keeps to the bounds at all.
    if extreme(&vec![0.0; n], OptimizationDirection::Minimize).is_err() {
        return None;
    }
    let range = |quantity: &Bounded| {
        let end = |direction, open: f64| {
            extreme(&quantity.slopes, direction).map_or(open, |x| quantity.value + unit * x)
        };
        [
            end(OptimizationDirection::Minimize, f64::NEG_INFINITY),
            end(OptimizationDirection::Maximize, f64::INFINITY),
        ]
    };
    Some(quantities.iter().map(range).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounded(value: f64, slopes: &[f64], bounds: [f64; 2]) -> Bounded {
        Bounded { value, slopes: slopes.to_vec(), bounds }
    }

    #[test]
    fn bounds_of_one_quantity_bound_the_others() {
        let open = [f64::NEG_INFINITY, f64::INFINITY];
        // x = 10 + s, y = 5 − s, z = w free of both.
        let all = [
            bounded(10.0, &[1.0, 0.0], [0.0, 30.0]),
            bounded(5.0, &[-1.0, 0.0], [0.0, f64::INFINITY]),
            bounded(0.0, &[0.0, 1.0], open),
        ];
        let found = ranges(&all).expect("a solution");
        for (found, expected) in found[..2].as_flattened().iter().zip([0.0, 15.0, 0.0, 15.0]) {
            assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
        }
        assert_eq!(found[2], open);
    }

    #[test]
    fn bounds_that_exclude_each_other_have_no_solution() {
        let all = [bounded(1.0, &[1.0], [5.0, 6.0]), bounded(1.0, &[-1.0], [0.0, 9.0])];
        assert_eq!(ranges(&all), None);
    }
}
