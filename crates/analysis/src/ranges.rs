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
    use OptimizationDirection::{Maximize, Minimize};
    let unit = unit_of(quantities);
    let n = quantities.first().map_or(0, |quantity| quantity.slopes.len());
    // Whether anything keeps to the bounds at all.
    if extreme(quantities, &vec![0.0; n], Minimize, unit).is_err() {
        return None;
    }
    let range = |quantity: &Bounded| {
        let end = |direction, open: f64| {
            extreme(quantities, &quantity.slopes, direction, unit)
                .map_or(open, |(x, _)| quantity.value + unit * x)
        };
        [end(Minimize, f64::NEG_INFINITY), end(Maximize, f64::INFINITY)]
    };
    Some(quantities.iter().map(range).collect())
}

/// The s at which one quantity is least or largest while all keep to their bounds; `None` where there is none.
pub(crate) fn extreme_at(
    quantities: &[Bounded],
    target: usize,
    direction: OptimizationDirection,
) -> Option<Vec<f64>> {
    let unit = unit_of(quantities);
    let (_, s) = extreme(quantities, &quantities[target].slopes, direction, unit).ok()?;
    Some(s.into_iter().map(|s| unit * s).collect())
}

/// The largest value, so that the tolerances of the linear programs are relative ones.
fn unit_of(quantities: &[Bounded]) -> f64 {
    let finite = quantities.iter().flat_map(|q| [q.value, q.bounds[0], q.bounds[1]]);
    let unit = finite.filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()));
    if unit > 0.0 { unit } else { 1.0 }
}

/// The extreme of Σ target · s in this unit, and s.
fn extreme(
    quantities: &[Bounded],
    target: &[f64],
    direction: OptimizationDirection,
    unit: f64,
) -> Result<(f64, Vec<f64>), microlp::Error> {
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
        Ok(solution) => {
            let at = s.iter().map(|&variable| solution[variable]).collect();
            Ok((solution.objective(), at))
        }
        Err(_) => Err(microlp::Error::InternalError(String::new())),
    }
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
