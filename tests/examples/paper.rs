//! The two worked examples of Lê Hồng Lam and Đinh Văn Phong (2008): energies, equations,
//! constraints and starts are the paper's.

use crate::support::{Within, close, coordinate, derive, example, parse};
use bksim::Mechanism;
use bksim::expr::{Expr, Pool, SymbolId, Tape};

/// The equations that the paper prints for one mechanism, in its order.
struct Paper {
    example: &'static str,
    kinetic: &'static str,
    potential: &'static str,
    /// Name of the coordinate, left side of its Lagrange equation.
    equations: &'static [(&'static str, &'static str)],
    /// Constraints of ld1, ld2 …
    constraints: &'static [&'static str],
}

const SLIDER_CRANK: Paper = Paper {
    example: "slider-crank",
    kinetic: "1/2*m3*x3_dot^2 + 1/2*m2*x2_dot^2 + 1/2*m2*y2_dot^2 + 1/2*i2*theta2_dot^2 \
              + 1/2*i1*theta1_dot^2",
    potential: "g*m2*y2 + m1*g*s1*sin(theta1)",
    equations: &[
        ("x3", "x3_ddot*m3 - ld1"),
        ("x2", "x2_ddot*m2 + ld1 - ld3"),
        ("y2", "y2_ddot*m2 + m2*g + ld2 - ld4"),
        (
            "theta2",
            "theta2_ddot*i2 - s2*sin(theta2)*ld1 + ld2*cos(theta2)*s2 - ld3*sin(theta2)*s2 \
             + ld4*cos(theta2)*s2",
        ),
        (
            "theta1",
            "theta1_ddot*i1 + s1*g*m1*cos(theta1) - q1 - ld3*sin(theta1)*l1 + ld4*cos(theta1)*l1",
        ),
    ],
    constraints: &[
        "x2 + s2*cos(theta2) - x3",
        "y2 + s2*sin(theta2)",
        "l1*cos(theta1) - (x2 - s2*cos(theta2))",
        "l1*sin(theta1) - (y2 - s2*sin(theta2))",
    ],
};

/// The energies and equations by (1.1) and (1.3) from the paper's constraints; the height of the
/// rocker's pivot is a constant of V.
const FIVE_LINK: Paper = Paper {
    example: "five-link",
    kinetic: "1/2*m*(x2_dot^2 + y2_dot^2 + x3_dot^2 + x4_dot^2 + y4_dot^2) \
              + 1/2*i*(ti1_dot^2 + ti2_dot^2 + ti4_dot^2 + ti5_dot^2)",
    potential: "m*g*(s1*sin(ti1) + y2 + y4 + h2 + s5*sin(ti5))",
    equations: &[
        ("x2", "m*x2_ddot + ld1 + ld5 - ld7"),
        ("y2", "m*y2_ddot + m*g + ld2 + ld6 - ld8"),
        ("ti2", "i*ti2_ddot + s2*(cos(ti2)*(ld6 + ld8) - sin(ti2)*(ld5 + ld7))"),
        ("x3", "m*x3_ddot - ld5"),
        ("x4", "m*x4_ddot - ld1 + ld3"),
        ("y4", "m*y4_ddot + m*g - ld2 + ld4"),
        ("ti4", "i*ti4_ddot + s4*(sin(ti4)*(ld1 + ld3) - cos(ti4)*(ld2 + ld4))"),
        ("ti1", "i*ti1_ddot + m*g*s1*cos(ti1) - q1 - l1*sin(ti1)*ld7 + l1*cos(ti1)*ld8"),
        ("ti5", "i*ti5_ddot + m*g*s5*cos(ti5) + l5*sin(ti5)*ld3 - l5*cos(ti5)*ld4"),
    ],
    constraints: &[
        "x2 - (x4 + s4*cos(ti4))",
        "y2 - (y4 + s4*sin(ti4))",
        "x4 - s4*cos(ti4) - (h1 + l5*cos(ti5))",
        "y4 - s4*sin(ti4) - (h2 + l5*sin(ti5))",
        "x2 + s2*cos(ti2) - x3",
        "y2 + s2*sin(ti2)",
        "l1*cos(ti1) - (x2 - s2*cos(ti2))",
        "l1*sin(ti1) - (y2 - s2*sin(ti2))",
    ],
};

#[test]
fn the_slider_crank_has_the_equations_of_the_paper() {
    has_equations_of(&SLIDER_CRANK);
}

#[test]
fn the_five_link_has_the_equations_of_the_paper() {
    has_equations_of(&FIVE_LINK);
}

fn has_equations_of(paper: &Paper) {
    let mechanism = derive(example(paper.example));
    let printed = mechanism.equations();
    // A pool of its own: what is compared is what a reader of the text sees.
    let pool = Pool::new();
    equal(&pool, "T", &printed.kinetic_energy, parse(&pool, paper.kinetic));
    equal(&pool, "V", &printed.potential_energy, parse(&pool, paper.potential));

    // Each constraint of the paper is one of bksim's, up to sign: that maps the multipliers.
    assert_eq!(printed.constraints.len(), paper.constraints.len());
    let mut multipliers: Vec<(SymbolId, Expr)> = Vec::new();
    for (row, text) in paper.constraints.iter().enumerate() {
        let (found, sign) = match_constraint(&pool, &printed.constraints, parse(&pool, text));
        let [theirs, ours] = [row, found].map(|row| pool.symbol(&format!("ld{}", row + 1)));
        let theirs = pool.symbol_id(theirs).expect("a symbol");
        assert!(multipliers.iter().all(|&(_, other)| other != ours && other != pool.neg(ours)));
        multipliers.push((theirs, if sign { ours } else { pool.neg(ours) }));
    }

    assert_eq!(printed.equations.len(), paper.equations.len());
    for (name, text) in paper.equations {
        let ours = &printed.equations[coordinate(&mechanism, name)];
        let theirs = pool.substitute(parse(&pool, text), &multipliers);
        equal(&pool, name, ours, theirs);
    }
}

/// Which of `printed` is `expected`, and whether with the same sign.
fn match_constraint(pool: &Pool, printed: &[String], expected: Expr) -> (usize, bool) {
    for (row, text) in printed.iter().enumerate() {
        let ours = parse(pool, text);
        for (sign, difference) in
            [(true, pool.sub(ours, expected)), (false, pool.add(ours, expected))]
        {
            if pool.is_zero(pool.simplify(difference)) {
                return (row, sign);
            }
        }
    }
    panic!("`{}` is none of {printed:?}", pool.to_text(expected));
}

/// Asserts that two expressions are equal: their difference simplifies to zero, and their values
/// agree at scattered points.
fn equal(pool: &Pool, what: &str, ours: &str, theirs: Expr) {
    let difference = pool.simplify(pool.sub(parse(pool, ours), theirs));
    let theirs_text = pool.to_text(theirs);
    assert!(
        pool.is_zero(difference),
        "{what}: `{ours}` less `{theirs_text}` leaves `{}`",
        pool.to_text(difference)
    );

    let symbols = symbols_of(pool, &format!("{ours} {theirs_text}"));
    let pair = [parse(pool, ours), theirs];
    let tape = Tape::compile(pool, &pair, &symbols, &[]).expect("all symbols are inputs");
    let mut workspace = tape.workspace(&[]);
    for seed in 1..=20_u32 {
        // Points spread by the golden ratio over (−3, 3).
        let place = |k: usize| (f64::from(seed) * 7.3 + k as f64 * 0.618_034).fract() * 6.0 - 3.0;
        let inputs: Vec<f64> = (0..symbols.len()).map(place).collect();
        let mut values = [0.0; 2];
        tape.evaluate(&mut workspace, &inputs, &mut values);
        close(what, values[0], values[1], Within { relative: 1e-12, absolute: 1e-11 });
    }
}

/// The symbols named in a text.
fn symbols_of(pool: &Pool, text: &str) -> Vec<SymbolId> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut ids: Vec<SymbolId> =
        text.split(|c| !is_part(c)).filter_map(|word| pool.find_symbol(word)).collect();
    ids.sort();
    ids.dedup();
    ids
}

/// Asserts named coordinates and multipliers of the start, each to half a unit of the last digit
/// printed.
fn starts_at(mechanism: &Mechanism, q: &[(&str, f64, f64)], lambda: &[f64], half_unit: f64) {
    let start = mechanism.start().expect("the mechanism closes");
    for &(name, expected, absolute) in q {
        let found = start.q[coordinate(mechanism, name)];
        close(name, found, expected, Within { relative: 0.0, absolute });
    }
    for (row, &expected) in lambda.iter().enumerate() {
        let what = format!("ld{}", row + 1);
        close(&what, start.lambda[row], expected, Within { relative: 0.0, absolute: half_unit });
    }
}

#[test]
fn the_five_link_starts_where_the_paper_says() {
    let mechanism = derive(example("five-link"));
    let q = [
        ("ti1", 0.0, 1e-15),
        ("x3", 125.0, 1e-10),
        ("ti5", 1.600_983_169_22, 5e-12),
        ("x4", 87.490_887_098_4, 5e-11),
        ("y4", 0.477_220_593_49, 5e-12),
        ("ti4", -9.386_591_033_01, 5e-12),
        ("x2", 75.0, 1e-10),
        ("y2", 0.0, 1e-10),
        ("ti2", 0.0, 1e-12),
    ];
    let lambda =
        [0.622_419, 8.017_293, 0.387_744, -7.939_330, 0.0, -15.055_723, 0.622_419, 15.060_643];
    starts_at(&mechanism, &q, &lambda, 6e-7);
}

#[test]
fn the_slider_crank_starts_outstretched() {
    let mechanism = derive(example("slider-crank"));
    // By hand at θ1 = 0: the rod's mass hangs half on the crank pin and half on the slider.
    let q = [("theta1", 0.0, 1e-15), ("x2", 2.5, 1e-12), ("y2", 0.0, 1e-12), ("x3", 4.0, 1e-12)];
    let lambda = [0.0, -27.394_117_647_058_824, 0.0, 27.958_823_529_411_763];
    starts_at(&mechanism, &q, &lambda, 1e-10);
}

#[test]
fn a_crank_lighter_about_its_centre_than_nothing_is_warned_about_and_runs() {
    let stated = crate::support::example_text("slider-crank");
    let silent = Mechanism::from_toml(&stated, "slider-crank").expect("the paper's model");
    assert!(silent.warnings.is_empty(), "{}", crate::support::messages(&silent.warnings));
    let mechanism = Mechanism::from_toml(&stated.replace(", as_stated = true", ""), "slider-crank")
        .expect("a warning is no error");
    let text = crate::support::messages(&mechanism.warnings);
    assert!(text.contains("crank") && text.contains("inertia"), "warnings: {text}");
}
