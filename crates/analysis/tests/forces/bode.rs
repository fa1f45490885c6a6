//! Frequency responses against closed forms.

use crate::support::model;
use bksim_analysis::{About, Channels, Frequencies, Response, bode};

fn response(text: &str, input: &str, output: &str, [from, to]: [f64; 2], n: usize) -> Response {
    let channels = Channels {
        inputs: vec![input.to_owned()],
        outputs: vec![output.to_owned()],
        states: Vec::new(),
    };
    bode(model(text), About::Static, &channels, Some(Frequencies { from, to, n }))
        .expect("a response")
}

#[track_caller]
fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(off <= tolerance * expected.abs().max(1e-3), "{found} for {expected}: off by {off:e}");
}

/// Two masses in a row: springs k1 to the ground and k2 between, dampers c1 and c2 next to them.
const TWO_MASSES: &str = "[parameters]\nF = 0\n[ground.points]\nP = [-1, 0]\n\
    [bodies]\na = { mass = 2 }\nb = { mass = 0.5 }\n\
    [joints]\nA = { type = \"prismatic\", between = [\"ground\", \"a\"], axis = [1, 0] }\n\
    B = { type = \"prismatic\", between = [\"ground\", \"b\"], axis = [1, 0] }\n\
    [loads]\nk1 = { type = \"spring\", between = [\"ground.P\", \"a\"], stiffness = 30, length = 1 }\n\
    c1 = { type = \"damper\", between = [\"ground.P\", \"a\"], damping = 0.4 }\n\
    F = { type = \"force\", on = \"a\", vector = [\"F\", 0] }\n";

/// (m s² + c s + k)⁻¹ of one mass on a guide.
#[test]
fn a_mass_on_a_spring_responds_by_its_closed_form() {
    let text = "[parameters]\nF = 0\n[ground.points]\nP = [-0.5, 0]\n[bodies]\na = { mass = 2 }\n\
                [joints]\nA = { type = \"prismatic\", between = [\"ground\", \"a\"], axis = [1, 0] }\n\
                [loads]\nk = { type = \"spring\", between = [\"ground.P\", \"a\"], stiffness = 50, length = 0.5 }\n\
                c = { type = \"damper\", between = [\"ground.P\", \"a\"], damping = 0.8 }\n\
                F = { type = \"force\", on = \"a\", vector = [\"F\", 0] }\n";
    for input in ["F", "A"] {
        let found = response(text, input, "A.position", [0.1, 100.0], 61);
        let transfer = &found.transfers[0];
        for (k, w) in found.omega.iter().enumerate() {
            let (re, im) = (50.0 - 2.0 * w * w, 0.8 * w);
            assert_close(transfer.gain[k], 1.0 / re.hypot(im), 1e-11);
            assert_close(transfer.phase[k], -im.atan2(re), 1e-11);
        }
        assert!(transfer.zeros.is_empty());
        let root = (50.0f64 / 2.0 - 0.04).sqrt();
        for [re, im] in &found.linear.poles {
            assert_close(*re, -0.2, 1e-11);
            assert_close(im.abs(), root, 1e-11);
        }
        // The rate has a zero at rest.
        let rate = response(text, input, "A.velocity", [0.1, 100.0], 3);
        assert_eq!(rate.transfers[0].zeros.len(), 1);
        assert!(rate.transfers[0].zeros[0][0].abs() < 1e-9 && rate.transfers[0].zeros[0][1] == 0.0);
    }
}

/// The driven mass rests where the other one absorbs: zeros at those of b on its spring and damper.
#[test]
fn an_absorber_makes_zeros() {
    let text = format!(
        "{TWO_MASSES}k2 = {{ type = \"spring\", between = [\"a\", \"b.P\"], stiffness = 8, length = 1 }}\n\
         c2 = {{ type = \"damper\", between = [\"a\", \"b.P\"], damping = 0.1 }}\n"
    )
    .replace("b = { mass = 0.5 }", "b = { mass = 0.5, points = { P = [1, 0] } }");
    let found = response(&text, "F", "A.position", [0.5, 50.0], 41);
    let zeros = &found.transfers[0].zeros;
    assert_eq!(zeros.len(), 2, "{zeros:?}");
    let (re, square) = (-0.1 / (2.0 * 0.5), 8.0 / 0.5);
    for [a, b] in zeros {
        assert_close(*a, re, 1e-9);
        assert_close(b.abs(), (square - re * re).sqrt(), 1e-10);
    }
    // At b the force is felt through spring and damper: one zero.
    let through = response(&text, "F", "B.position", [0.5, 50.0], 41);
    assert_eq!(through.transfers[0].zeros.len(), 1);
    assert_close(through.transfers[0].zeros[0][0], -8.0 / 0.1, 1e-8);
    let of_b = &through.transfers[0];
    for (k, &w) in through.omega.iter().enumerate() {
        // x_b = (k2 + c2 s) F / det.
        type C = nalgebra::Complex<f64>;
        let s = C::new(0.0, w);
        let (za, zb) = (s * s * 2.0 + s * 0.5 + 38.0, s * s * 0.5 + s * 0.1 + 8.0);
        let coupled = s * 0.1 + 8.0;
        let h = coupled / (za * zb - coupled * coupled);
        assert_close(of_b.gain[k], h.norm(), 1e-10);
    }
}

#[test]
fn a_response_needs_an_input_and_an_output() {
    let refused = bode(model(TWO_MASSES), About::Start, &Channels::default(), None);
    assert_eq!(
        refused.expect_err("nothing asked").to_string(),
        "a frequency response needs an input and an output"
    );
}

/// Inputs and outputs of the model stand where none are named.
#[test]
fn the_model_states_inputs_and_outputs() {
    let text = format!(
        "{TWO_MASSES}[io]\ninput = [\"F\", \"B\"]\noutput = [\"A.position\", \"B.velocity\"]\n"
    );
    let named = |input: &str| Channels { inputs: vec![input.to_owned()], ..Channels::default() };
    let all = bksim_analysis::linearize(model(&text), About::Start, &Channels::default());
    let all = all.expect("a linear system");
    assert_eq!(all.inputs, ["F", "B"]);
    assert_eq!([all.c.nrows(), all.b.ncols()], [2, 2]);
    let one = bksim_analysis::linearize(model(&text), About::Start, &named("F"))
        .expect("a linear system");
    assert_eq!(one.inputs, ["F"]);
    assert_eq!(one.b.column(0), all.b.column(0));
}
