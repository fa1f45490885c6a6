//! Which inputs matter: how much of an output's spread an input explains by itself, and which way.

/// The influence of an input on an output.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Influence {
    /// Share of the output's variance that the input explains alone, 0 … 1: the correlation ratio η² of K. Pearson
    /// (1905) over the input's values; where these are too many, over classes of equally many cases, less what chance
    /// gives (T. L. Kelley, PNAS 21 (1935) 554–559).
    pub share: f64,
    /// Rank correlation, −1 … 1: positive where the output grows with the input (C. Spearman, 1904).
    pub rank: f64,
}

/// Differences of an output below this part of its size, or below this number, are rounding.
const ROUNDING: [f64; 2] = [1e-9, 1e-13];
/// More values than this are gathered in classes.
const N_CLASSES: usize = 20;

impl Influence {
    /// Of the cases where both are numbers; `None` where the input is the same in all, or the output but for rounding, or
    /// there are fewer than three.
    pub fn of(input: &[f64], output: &[f64]) -> Option<Self> {
        let pairs = input.iter().zip(output).map(|(x, y)| (*x, *y));
        let mut pairs: Vec<(f64, f64)> =
            pairs.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ys: Vec<f64> = pairs.iter().map(|pair| pair.1).collect();
        let xs: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
        let whole = spread(&ys);
        if pairs.len() < 3 || xs.first() == xs.last() || !changes(&ys) || whole <= 0.0 {
            return None;
        }

        // The variance of the means of classes, as a share of the whole.
        let (classes, are_values) = classes(&xs);
        let within: f64 = classes.iter().map(|class| spread(&ys[class.clone()])).sum();
        let (n, k) = (count(pairs.len()), count(classes.len()));
        let by_chance = if are_values { 1.0 } else { (n - 1.0) / (n - k) };
        let share = (1.0 - within / whole * by_chance).max(0.0);
        Some(Self { share, rank: correlation(&ranks(&xs), &ranks(&ys)) })
    }
}

/// True where values differ by more than rounding.
fn changes(values: &[f64]) -> bool {
    let [least, most] = [f64::min, f64::max].map(|of| values.iter().copied().reduce(of));
    least.zip(most).is_some_and(|(least, most)| {
        most - least > ROUNDING[1].max(ROUNDING[0] * least.abs().max(most.abs()))
    })
}

/// Sum of the squares of the deviations from the mean.
fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / count(values.len());
    values.iter().map(|value| (value - mean).powi(2)).sum()
}

/// Runs of equal values, or, where they are too many, of equally many; true of the former.
fn classes(sorted: &[f64]) -> (Vec<std::ops::Range<usize>>, bool) {
    let mut starts: Vec<usize> =
        (0..sorted.len()).filter(|&idx| idx == 0 || sorted[idx] != sorted[idx - 1]).collect();
    // Half as many classes as cases would leave too few in each.
    let n_most = N_CLASSES.min((sorted.len() / 5).max(2));
    let are_values = starts.len() <= n_most;
    if !are_values {
        starts = (0..n_most).map(|class| class * sorted.len() / n_most).collect();
    }
    let ends = starts.iter().skip(1).copied().chain([sorted.len()]);
    (starts.iter().copied().zip(ends).map(|(start, end)| start..end).collect(), are_values)
}

/// Ranks, equal values sharing the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    while first < order.len() {
        let alike = order[first..].iter().take_while(|&&idx| values[idx] == values[order[first]]);
        let n = alike.count().max(1);
        let mean = count(first) + 0.5 * count(n - 1);
        order[first..first + n].iter().for_each(|&idx| ranks[idx] = mean);
        first += n;
    }
    ranks
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / count(of.len());
    let (mean_a, mean_b) = (mean(a), mean(b));
    let both: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
    let size = (spread(a) * spread(b)).sqrt();
    if size > 0.0 { both / size } else { 0.0 }
}

#[expect(clippy::cast_precision_loss, reason = "cases are counted far below 2⁵³")]
fn count(n: usize) -> f64 {
    n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of x, y in 0 … 1.
    fn grid(n: u32, output: fn(f64, f64) -> f64) -> [Vec<f64>; 3] {
        let at = |idx: u32| f64::from(idx) / f64::from(n - 1);
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (at(i), at(j))));
        let (x, y): (Vec<f64>, Vec<f64>) = all.unzip();
        let z = x.iter().zip(&y).map(|(x, y)| output(*x, *y)).collect();
        [x, y, z]
    }

    #[test]
    fn shares_of_a_sum_are_those_of_its_variances() {
        // Var(3x + 4y): 9 and 16 parts of 25; −y makes it fall.
        let [x, y, z] = grid(11, |x, y| 3.0 * x - 4.0 * y);
        let of = |input: &[f64]| Influence::of(input, &z).expect("both vary");
        assert!((of(&x).share - 0.36).abs() < 1e-12 && of(&x).rank > 0.5, "{:?}", of(&x));
        assert!((of(&y).share - 0.64).abs() < 1e-12 && of(&y).rank < -0.7, "{:?}", of(&y));
    }

    #[test]
    fn what_has_no_part_in_an_output_has_no_influence() {
        let [x, y, z] = grid(15, |x, _| (x - 0.5).powi(2));
        let of = |input: &[f64]| Influence::of(input, &z).expect("both vary");
        // A symmetric dependence has no direction, but explains everything.
        assert!(of(&x).share > 0.99 && of(&x).rank.abs() < 0.05, "{:?}", of(&x));
        assert!(of(&y).share < 1e-12 && of(&y).rank.abs() < 1e-12, "{:?}", of(&y));
    }

    #[test]
    fn cases_that_failed_do_not_count_and_constants_have_none() {
        let [x, y, mut z] = grid(9, |x, _| x);
        z[3] = f64::NAN;
        assert!(Influence::of(&x, &z).expect("both vary").share > 0.999);
        assert_eq!(Influence::of(&vec![1.0; y.len()], &z), None);
        assert_eq!(Influence::of(&y, &vec![2.0; y.len()]), None);
        assert_eq!(Influence::of(&[1.0, 2.0], &[1.0, 2.0]), None);
        let rounded: Vec<f64> = x.iter().map(|x| 1e3 * (1.0 + 1e-13 * x)).collect();
        assert_eq!(Influence::of(&x, &rounded), None);
    }
}
