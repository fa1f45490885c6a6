//! Ticks at 1-2-5 numbers, and their labels.

/// Ticks of an axis.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Ticks {
    /// Their numbers, ascending.
    pub(crate) values: Vec<f64>,
    /// Label of each.
    pub(crate) labels: Vec<String>,
    /// Power of ten that the labels are to be multiplied by.
    pub(crate) exponent: i32,
    /// Text of the number that the labels are counted from, if that is not zero.
    pub(crate) offset: Option<String>,
}

/// Magnitude from which labels are multiples of a power of ten.
const LARGE: f64 = 1e5;
/// Magnitude below which labels are multiples of a power of ten.
const SMALL: f64 = 1e-2;
/// Number of digits from which labels are differences from the first tick.
const MAX_DIGITS: usize = 7;

/// Ticks that an axis has at least.
const FEWEST: usize = 3;
/// Steps that are tried, each finer than the one before, until there are so many.
const FINER: usize = 5;

/// The ticks of a linear axis from `low` to `high`: at most `max_n`, or one more, but three where there are fewer.
pub fn round_numbers(low: f64, high: f64, max_n: usize) -> Vec<f64> {
    Ticks::linear(low, high, max_n).values
}

impl Ticks {
    /// At most `max_n` multiples of 1, 2 or 5 times a power of ten from `low` to `high`, or one
    /// more, but [three](FEWEST) if the digits of numbers tell them apart, however short the axis is; one label in any case.
    pub(crate) fn linear(low: f64, high: f64, max_n: usize) -> Self {
        let mut step = step(high - low, max_n);
        let (mut counts, mut power) = (Vec::new(), step.1);
        for _ in 0..FINER {
            let more = multiples(low, high, step);
            if more.len() > counts.len() {
                (counts, power) = (more, step.1);
            }
            if counts.len() >= FEWEST {
                break;
            }
            step = finer(step);
        }
        if counts.is_empty() { Self::single(low) } else { Self::labelled(&counts, power) }
    }

    /// Powers of ten from `low` to `high`, and 2 and 5 times those where there are few.
    pub(crate) fn logarithmic(low: f64, high: f64, max_n: usize) -> Self {
        let [first, last] = [low, high].map(f64::log10);
        let n_decades = (last.floor() - first.ceil() + 1.0).max(0.0);
        let stride = (n_decades / max_n.max(1) as f64).ceil();
        let stride = stride.min((0.5 * (n_decades - 1.0)).floor()).max(1.0);
        let mantissas: &[f64] = if n_decades <= 2.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let mut ticks = Self { values: vec![], labels: vec![], exponent: 0, offset: None };
        let mut decade = (first.floor() / stride).floor() * stride;
        while decade <= last {
            for mantissa in mantissas {
                let power = whole(decade);
                let value = times_ten_to(*mantissa, power);
                if value >= low * (1.0 - 1e-6) && value <= high * (1.0 + 1e-6) {
                    ticks.values.push(value);
                    ticks.labels.push(power_label(*mantissa, power));
                }
            }
            decade += stride;
        }
        if ticks.values.len() >= FEWEST {
            return ticks;
        }
        // Zero has no place on an axis of logarithms.
        let even = Self::linear(low, high, max_n);
        let is_positive = even.values.iter().all(|&value| value > 0.0);
        if is_positive || ticks.values.is_empty() { even } else { ticks }
    }

    fn single(value: f64) -> Self {
        let labels = vec![minus(&format!("{value:.6e}"))];
        Self { values: vec![value], labels, exponent: 0, offset: None }
    }

    /// Ticks at `counts` times ten to `power`; counts are whole numbers.
    fn labelled(counts: &[f64], power: i32) -> Self {
        let values = counts.iter().map(|&count| times_ten_to(count, power)).collect();
        let form = Form::of(counts, power);
        let origin = counts[0];
        let (counts, form, offset) = if form.n_whole + form.n_decimals > MAX_DIGITS {
            let counts: Vec<f64> = counts.iter().map(|count| count - origin).collect();
            let form = Form::of(&counts, power);
            (counts, form, Some(offset_text(origin, power)))
        } else {
            (counts.to_vec(), form, None)
        };
        let Form { exponent, n_decimals, .. } = form;
        let label = |count: &f64| {
            minus(&format!("{:.n_decimals$}", times_ten_to(*count, power - exponent)))
        };
        Self { values, labels: counts.iter().map(label).collect(), exponent, offset }
    }
}

/// Number format of the labels of an axis.
struct Form {
    /// The power of ten that is factored out.
    exponent: i32,
    /// Digits before the point of the longest label.
    n_whole: usize,
    /// Digits after the point.
    n_decimals: usize,
}

impl Form {
    /// The format for `counts` times ten to `power`.
    fn of(counts: &[f64], power: i32) -> Self {
        let largest = counts.iter().fold(0.0, |largest: f64, count| largest.max(count.abs()));
        let size = times_ten_to(largest, power);
        // The only label is zero, whatever the step to the next tick outside.
        if size == 0.0 {
            return Self { exponent: 0, n_whole: 1, n_decimals: 0 };
        }
        let magnitude = whole(size.log10().floor());
        let is_plain = (SMALL..LARGE).contains(&size);
        let exponent = if is_plain { 0 } else { 3 * magnitude.div_euclid(3) };
        let digits = |n: i32| n.max(0).unsigned_abs() as usize;
        Self {
            exponent,
            n_whole: digits(magnitude - exponent) + 1,
            n_decimals: digits(exponent - power),
        }
    }
}

fn offset_text(count: f64, power: i32) -> String {
    let value = times_ten_to(count, power);
    let decimals = (-power).max(0).unsigned_abs() as usize;
    if decimals <= 15 && value.abs() < 1e15 {
        format!("{value:.decimals$}")
    } else {
        format!("{value:e}")
    }
}

/// Mantissa 1, 2 or 5 and power of ten of the smallest step of which `max_n` make up `span`.
fn step(span: f64, max_n: usize) -> (f64, i32) {
    let least = span / max_n.max(1) as f64;
    let power = least.log10().floor();
    if !power.is_finite() {
        return (1.0, 0);
    }
    let mantissa = least / 10f64.powf(power);
    let found = [1.0, 2.0, 5.0].into_iter().find(|&nice| mantissa <= nice * (1.0 + 1e-9));
    found.map_or((1.0, whole(power) + 1), |nice| (nice, whole(power)))
}

/// The next smaller step.
fn finer((mantissa, power): (f64, i32)) -> (f64, i32) {
    match mantissa {
        5.0 => (2.0, power),
        2.0 => (1.0, power),
        _ => (5.0, power - 1),
    }
}

/// The multiples of a step from `low` to `high`, in units of its power of ten.
fn multiples(low: f64, high: f64, (mantissa, power): (f64, i32)) -> Vec<f64> {
    let size = times_ten_to(mantissa, power);
    // Rounding of the ends must not lose a tick at an end.
    let (first, last) = ((low / size - 1e-6).ceil(), (high / size + 1e-6).floor());
    let mut counts = Vec::new();
    // None if the counts exceed the digits of a double, or the step is zero.
    if !(first.abs().max(last.abs()) < 1e15 && last - first < 1e4) {
        return counts;
    }
    let mut count = first;
    while count <= last {
        counts.push(count * mantissa);
        count += 1.0;
    }
    counts
}

/// A count times a power of ten, rounded once.
fn times_ten_to(count: f64, power: i32) -> f64 {
    if (-300..0).contains(&power) { count / 10f64.powi(-power) } else { count * 10f64.powi(power) }
}

#[expect(clippy::cast_possible_truncation, reason = "exponents of doubles are below 400")]
fn whole(value: f64) -> i32 {
    value as i32
}

fn power_label(mantissa: f64, power: i32) -> String {
    match power {
        -2..=-1 => format!("{:.*}", power.unsigned_abs() as usize, times_ten_to(mantissa, power)),
        0..=3 => times_ten_to(mantissa, power).to_string(),
        _ if mantissa == 1.0 => power_of_ten(power),
        _ => format!("{mantissa}·{}", power_of_ten(power)),
    }
}

/// `10⁻³`.
pub(crate) fn power_of_ten(power: i32) -> String {
    format!("10{}", superscript(&power.to_string()))
}

/// Digits and minus signs, raised.
pub(crate) fn superscript(text: &str) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |letter: char| match letter.to_digit(10) {
        Some(digit) => DIGITS[digit as usize],
        None if letter == '-' => '⁻',
        None => letter,
    };
    text.chars().map(raised).collect()
}

/// A number with a typographic minus sign, and none on zero.
fn minus(text: &str) -> String {
    let is_zero = !text.contains(|letter: char| ('1'..='9').contains(&letter));
    text.replace('-', if is_zero { "" } else { "−" })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    #[track_caller]
    fn check(low: f64, high: f64, labels: &[&str], exponent: i32, offset: Option<&str>) {
        let ticks = Ticks::linear(low, high, 6);
        assert_eq!(ticks.labels, labels);
        assert_eq!(ticks.exponent, exponent);
        assert_eq!(ticks.offset.as_deref(), offset);
    }

    #[test]
    fn ticks_stand_at_round_numbers_with_short_labels() {
        check(0.0, 5.0, &["0", "1", "2", "3", "4", "5"], 0, None);
        check(-0.31, 0.32, &["−0.2", "0.0", "0.2"], 0, None);
        check(0.0, 3e-7, &["0", "50", "100", "150", "200", "250", "300"], -9, None);
        check(-2.1e6, 1.0e6, &["−2", "−1", "0", "1"], 6, None);
        check(
            12.345_678_9,
            12.345_679_1,
            &["0", "50", "100", "150", "200"],
            -9,
            Some("12.34567890"),
        );
        check(0.0, 3600.0, &["0", "1000", "2000", "3000"], 0, None);
        assert_eq!(Ticks::linear(-9.9e-12, 9.9e-12, 2).labels, ["−5", "0", "5"]);
        assert_eq!(Ticks::linear(-474.9, -470.2, 2).labels, ["−474", "−473", "−472", "−471"]);
    }

    #[test]
    fn decades_have_ticks_of_their_own() {
        let labels = |low, high| Ticks::logarithmic(low, high, 6).labels;
        assert_eq!(labels(0.5, 30.0), ["0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(labels(1e-12, 1e4), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "1", "1000"]);
        assert_eq!(
            Ticks::logarithmic(1.1, 1.3, 4).labels,
            ["1.10", "1.15", "1.20", "1.25", "1.30"]
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(1637), ..ProptestConfig::default() })]

        #[test]
        fn ticks_are_few_inside_and_read_back(
            middle in -1e3..1e3_f64, power in -20..20_i32, span in 0.01..10.0_f64, max_n in 2..12_usize,
        ) {
            let scale = 10f64.powi(power);
            let (low, high) = (scale * (middle - span), scale * (middle + span));
            let ticks = Ticks::linear(low, high, max_n);
            prop_assert!((FEWEST..=(max_n + 1).max(7)).contains(&ticks.values.len()), "{ticks:?}");
            prop_assert_eq!(ticks.values.len(), ticks.labels.len());
            let offset = ticks.offset.as_ref().map_or(Ok(0.0), |text| text.parse::<f64>());
            let offset = offset.expect("a number");
            for (value, label) in ticks.values.iter().zip(&ticks.labels) {
                prop_assert!(*value >= low - 1e-6 * (high - low) && *value <= high + 1e-6 * (high - low));
                let read: f64 = label.replace('−', "-").parse().expect("a number");
                let back = offset + read * 10f64.powi(ticks.exponent);
                prop_assert!((back - value).abs() <= 1e-6 * (high - low), "{back} for {value}");
                prop_assert!(label.len() <= 12, "{label}");
            }
        }

        #[test]
        fn any_two_numbers_have_a_tick(low in any::<f64>(), high in any::<f64>(), max_n in 0..30_usize) {
            prop_assert!(!Ticks::linear(low, high, max_n).values.is_empty());
        }
    }
}
