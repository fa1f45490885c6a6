//! Masses, centres of mass and inertia tensors of bodies made of shapes, each written in two ways.

use std::f64::consts::PI;
use std::fmt::Write;

use bksim_expr::Expr;
use bksim_model::Model;
use bksim_model::file::{Source, read};

/// Mass, centre of mass, and xx, yy, zz, xy, yz, zx of a body.
type Properties = [f64; 10];

fn properties(body: &str) -> Properties {
    let text = format!(
        "space = \"spatial\"\n[parameters]\na = \"0.3 m\"\n[bodies.b]\nfree = true\n{body}"
    );
    let reading = read(&Source::new(&text, "solids"));
    let model = reading.model.unwrap_or_else(|| panic!("{:#?}", reading.diagnostics));
    let of = &model.bodies[1];
    let parts = [of.mass].into_iter().chain(of.com).chain(of.inertia.moments);
    let all: Vec<f64> = parts.chain(of.inertia.products).map(|e| value(&model, e)).collect();
    all.try_into().expect("ten numbers")
}

fn value(model: &Model, e: Expr) -> f64 {
    let known = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    model.pool.evaluate(e, &known).expect("a number")
}

#[track_caller]
fn assert_same(one: Properties, other: Properties, tolerance: f64) {
    let largest = one.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for (a, b) in one.iter().zip(&other) {
        assert!((a - b).abs() <= tolerance * largest, "{one:?}\n{other:?}");
    }
}

#[test]
fn a_box_is_known_in_closed_form() {
    let [m, x, y, z, xx, yy, zz, rest @ ..] = properties(
        "density = 1000\nshapes = [{ type = \"box\", size = [\"a\", 0.2, 0.1], at = [1, 2, 3] }]\n",
    );
    assert!((m - 6.0).abs() < 1e-12);
    assert_eq!([x, y, z], [1.0, 2.0, 3.0]);
    for (found, sides) in [(xx, [0.2, 0.1]), (yy, [0.1, 0.3]), (zz, [0.3, 0.2])] {
        let [p, q]: [f64; 2] = sides;
        assert!((found - 6.0 * (p * p + q * q) / 12.0).abs() < 1e-12);
    }
    assert_eq!(rest, [0.0; 3]);
}

#[test]
fn a_turned_box_is_a_plate_with_turned_corners() {
    let (sin, cos) = 0.5_f64.sin_cos();
    let corner = |[x, y]: [f64; 2]| [cos * x - sin * y + 0.7, sin * x + cos * y - 0.4];
    let corners = [[-0.15, -0.1], [0.15, -0.1], [0.15, 0.1], [-0.15, 0.1]].map(corner);
    let plate = properties(&format!(
        "density = 800\nshapes = [{{ type = \"plate\", outline = {corners:?}, thickness = 0.1 }}]\n"
    ));
    let turned = properties(
        "density = 800\nshapes = [{ type = \"box\", size = [\"a\", 0.2, 0.1], at = [0.7, -0.4, 0], rpy = [0, 0, 0.5] }]\n",
    );
    assert_same(plate, turned, 1e-14);
    // The outline of the body itself is the same plate.
    let outline = properties(&format!("density = 800\nthickness = 0.1\noutline = {corners:?}\n"));
    assert_same(plate, outline, 1e-14);
}

#[test]
fn two_halves_are_the_whole_in_any_orientation() {
    let frame = "quaternion = [0.5, 0.5, -0.5, 0.5]";
    let whole = properties(&format!(
        "density = 2\nshapes = [{{ type = \"box\", size = [0.4, 0.2, 0.1], at = [0, 1, 0], {frame} }}]\n"
    ));
    // x of the frame is R x = (0, 0, -1) for this quaternion.
    let halves: String = [0.1, -0.1].iter().fold(String::new(), |mut text, z| {
        write!(text, "{{ type = \"box\", size = [0.2, 0.2, 0.1], at = [0, 1, {z}], {frame} }},")
            .expect("text grows");
        text
    });
    assert_same(whole, properties(&format!("density = 2\nshapes = [{halves}]\n")), 1e-14);
}

#[test]
fn a_cylinder_is_the_limit_of_prisms_and_a_ball_of_discs() {
    let n = 2000;
    let ring: Vec<[f64; 2]> = (0..n)
        .map(|i| 2.0 * PI * f64::from(i) / f64::from(n))
        .map(|angle| [0.2 * angle.cos(), 0.2 * angle.sin()])
        .collect();
    let frame = "at = [0.1, 0, 0.3], rpy = [0.3, -0.8, 1.1]";
    let prism = properties(&format!(
        "density = 5\nshapes = [{{ type = \"plate\", outline = {ring:?}, thickness = 0.5, {frame} }}]\n"
    ));
    let cylinder = properties(&format!(
        "density = 5\nshapes = [{{ type = \"cylinder\", radius = 0.2, length = 0.5, {frame} }}]\n"
    ));
    assert_same(prism, cylinder, 1e-5);

    let discs: String = (0..400).fold(String::new(), |mut text, i| {
        let z = (f64::from(i) + 0.5) / 200.0 - 1.0;
        let radius = (1.0 - z * z).sqrt();
        write!(
            text,
            "{{ type = \"cylinder\", radius = {radius}, length = 0.005, at = [0, 0, {z}] }},"
        )
        .expect("text grows");
        text
    });
    let ball = properties("density = 5\nshapes = [{ type = \"sphere\", radius = 1 }]\n");
    assert_same(ball, properties(&format!("density = 5\nshapes = [{discs}]\n")), 1e-4);
}

#[test]
fn a_stated_mass_leaves_shapes_to_be_drawn() {
    let [m, ..] = properties("mass = 3\nshapes = [{ type = \"sphere\", radius = 1 }]\n");
    assert_eq!(m, 3.0);
}

#[test]
fn faults_of_shapes_name_them() {
    let codes = |body: &str| -> Vec<&'static str> {
        let text = format!("[bodies.b]\nfree = true\n{body}");
        let reading = read(&Source::new(&text, "solids"));
        reading
            .diagnostics
            .iter()
            .filter(|fault| fault.is_error())
            .map(|fault| fault.code.0)
            .collect()
    };
    for (shape, code) in [
        ("{ size = [1, 1, 1] }", "M006"),
        ("{ type = \"cone\" }", "M008"),
        ("{ type = \"sphere\", radius = -1 }", "M044"),
        ("{ type = \"sphere\", radius = \"1 kg\" }", "M031"),
        ("{ type = \"box\", size = [1, 2] }", "M007"),
        ("{ type = \"sphere\", length = 1, radius = 1 }", "M005"),
    ] {
        assert_eq!(codes(&format!("density = 1\nshapes = [{shape}]\n")), [code], "{shape}");
    }
    assert_eq!(codes("density = 1\nshapes = []\n"), ["M007"]);
}
