//! Optima whose slopes are found back along the motion.

use crate::optima::{is_close, solved, value};

/// Twelve forces on a mass, least squares with a condition: x = Σ aₖ (t/k − sin(k t)/k²) at the samples, by its own normal
/// equations.
#[test]
fn many_quantities_are_varied_by_the_adjoint() {
    const N: usize = 12;
    let names: Vec<String> = (1..=N).map(|k| format!("a{k}")).collect();
    let parameters: Vec<String> =
        names.iter().map(|name| format!("{name} = \"0.1 N\"\n")).collect();
    let parameters = parameters.concat();
    let force: Vec<String> = (1..=N).map(|k| format!("a{k}*sin({k}*t/(1 s))")).collect();
    let squares: Vec<String> = names.iter().map(|name| format!("{name}^2")).collect();
    let vary: Vec<String> =
        names.iter().map(|name| format!("{name} = [\"-30 N\", \"30 N\"]")).collect();
    let text = format!(
        "[parameters]\n{parameters}[bodies.b]\nmass = 1\n\
         [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n\
         [loads.f]\ntype = \"force\"\non = \"b\"\nvector = [\"{}\", 0]\n\
         [initial]\nS = {{ position = 0, velocity = 0 }}\n\
         [solve]\nt_end = 2\nevery = 0.05\n\
         [optimize]\nminimize = \"mean((S.position - 0.3 m*t/(1 s))^2)/(1 m^2) + 1e-3*({})/(1 N^2)\"\n\
         subject_to = [\"final(S.velocity) == 0.2 m/s\"]\nvary = {{ {} }}\n",
        force.join(" + "),
        squares.join(" + "),
        vary.join(", ")
    );
    let found = solved(&text);
    assert_eq!(found.slopes, "the adjoint of the motion");
    assert!(found.converged, "{found:?}");

    let shape = |k: usize, t: f64| {
        let k = k as f64;
        [t / k - (k * t).sin() / (k * k), (1.0 - (k * t).cos()) / k]
    };
    let mut all = nalgebra::DMatrix::zeros(N + 1, N + 1);
    let mut right = nalgebra::DVector::zeros(N + 1);
    for sample in 0..=40_usize {
        let (t, weight) = (0.05 * sample as f64, if sample % 40 == 0 { 0.5 } else { 1.0 } / 40.0);
        for i in 0..N {
            let own = shape(i + 1, t)[0];
            right[i] += weight * own * 0.3 * t;
            (0..N).for_each(|j| all[(i, j)] += weight * own * shape(j + 1, t)[0]);
        }
    }
    for i in 0..N {
        all[(i, i)] += 1e-3;
        (all[(i, N)], all[(N, i)]) = (shape(i + 1, 2.0)[1], shape(i + 1, 2.0)[1]);
    }
    right[N] = 0.2;
    let exact = all.lu().solve(&right).expect("a solution");
    for (k, name) in names.iter().enumerate() {
        is_close(value(&found, name), exact[k], 1e-5);
    }
}
