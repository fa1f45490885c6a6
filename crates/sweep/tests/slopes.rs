//! Derivatives of outputs back along the motion are those of differences.

use bksim_sweep::{Monitor, NeedsSlopes, Request, Study};

use crate::common::plan;

/// A double pendulum with a spring, whose stiffness follows from another parameter; initial values and a mass vary, too.
const SWING: &str = r#"
[parameters]
l = "0.5 m"
k = "20 N m/rad"
k2 = "2*k + 1 N m/rad"
[bodies.one]
mass = "1.2 kg"
inertia = 0.02
com = ["l/2", 0]
points = { E = ["l", 0] }
[bodies.two]
mass = "0.7 kg"
inertia = 0.01
com = ["0.2 m", 0]
points = { P = ["0.4 m", 0] }
[joints.A]
type = "revolute"
between = ["ground", "one"]
[joints.B]
type = "revolute"
between = ["one.E", "two"]
[loads.spring]
type = "torque"
joint = "B"
value = "-k2*B.angle - 0.1 N m s/rad*B.rate"
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[initial]
A = { angle = 0.3, rate = 0 }
B = { angle = -0.2, rate = 0 }
[solve]
t_end = 0.8
every = 0.02
rtol = 1e-11
atol = 1e-12
"#;

#[test]
fn derivatives_back_along_the_motion_are_those_of_differences() {
    let axes = [
        ("l", "0.5:0.6:2"),
        ("k", "20:21:2"),
        ("one.mass", "1.2:1.3:2"),
        ("B.angle", "-0.2:0.1 rad:2"),
    ];
    let mut request = Request::new(SWING, "swing", plan(&axes));
    request.slopes = NeedsSlopes::Yes;
    request.outputs = [
        "final(two.P.x)",
        "mean((A.angle + B.angle)^2) * k",
        "rms(reactions.A.fy)",
        "two.P.y@0.5",
        "final(energy.total) / l",
        "rms(k2*B.angle + t*(1 N m/s))",
        "l^2",
    ]
    .map(str::to_owned)
    .to_vec();
    let study = Study::prepare(request).expect("a study");
    assert!(study.may_have_slopes());
    let n = study.outputs().len();
    let spans = [0.1, 2.0, 0.2, 0.1];
    // The equations are made at the first point, and serve the second.
    for point in [[0.5, 20.0, 1.2, -0.2], [0.55, 23.0, 1.0, 0.3]] {
        let found = study.slopes_at(n, (&point, &spans), &|| false).expect("slopes");
        for axis in 0..point.len() {
            let step = 2e-3 * spans[axis];
            let moved = |by: f64| {
                let mut point = point.to_vec();
                point[axis] += by * step;
                point
            };
            let points: Vec<Vec<f64>> = [-2.0, -1.0, 1.0, 2.0].map(moved).to_vec();
            let rows = study.rows_at(&points, 1, &Monitor::default()).expect("threads");
            let rows = rows.expect("an end");
            for (k, output) in study.outputs().iter().enumerate() {
                let [a, b, c, d] = [0, 1, 2, 3].map(|row: usize| rows[row].outputs[k]);
                let expected = (a - 8.0 * b + 8.0 * c - d) / (12.0 * step);
                let size = rows[0].outputs[k].abs() / spans[axis];
                let off = (found[k][axis] - expected).abs();
                assert!(
                    off < 1e-6 * expected.abs() + 1e-7 * size,
                    "{} by axis {axis}: {} for {expected}",
                    output.name,
                    found[k][axis]
                );
            }
        }
    }
}

#[test]
fn peaks_have_no_derivatives_back_along_the_motion() {
    let mut request = Request::new(SWING, "swing", plan(&[("l", "0.5:0.6:2")]));
    request.slopes = NeedsSlopes::Yes;
    request.outputs = vec!["max(A.angle)".to_owned()];
    let study = Study::prepare(request).expect("a study");
    assert!(!study.may_have_slopes());
}
