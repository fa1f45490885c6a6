//! Masses, centres of mass and inertia tensors of bodies made of shapes, each written in two ways.

use std::f64::consts::PI;
use std::fmt::Write;

use bksim_expr::Expr;
use bksim_model::Model;
use bksim_model::file::{Limits, Source, expand, read};

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

/// The corners and faces of a box about the origin, in mm.
fn box_mesh([a, b, c]: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let corners = (0..8).map(|k| {
        let side =
            |bit: usize, length: f64| if k >> bit & 1 == 1 { 0.5 * length } else { -0.5 * length };
        [side(0, a), side(1, b), side(2, c)]
    });
    // Quadrilaterals counter-clockwise as seen from outside, each as two triangles.
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (corners.collect(), faces)
}

fn inline(corners: &[[f64; 3]], faces: &[[usize; 3]], more: &str) -> String {
    format!(
        "density = 1000\nshapes = [{{ type = \"mesh\", corners = {corners:?}, faces = {faces:?}{more} }}]\n"
    )
}

#[test]
fn a_mesh_of_a_box_is_the_box() {
    let (corners, faces) = box_mesh([300.0, 200.0, 100.0]);
    let frame = "at = [1, 2, 3], rpy = [0.3, -0.5, 0.7]";
    let mesh = properties(&inline(&corners, &faces, &format!(", unit = \"mm\", {frame}")));
    let solid = properties(&format!(
        "density = 1000\nshapes = [{{ type = \"box\", size = [0.3, 0.2, 0.1], {frame} }}]\n"
    ));
    assert_same(mesh, solid, 1e-14);
}

#[test]
fn a_tetrahedron_is_known_in_closed_form() {
    // With legs a, b, c along the axes: V = abc/6, ∫ x² = a² V/10, ∫ xy = ab V/20.
    let [a, b, c] = [0.6, 0.4, 0.2];
    let corners = [[0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let found = properties(&inline(&corners, &faces, ""));
    let m = 1000.0 * a * b * c / 6.0;
    let square = |x: f64| m * x * x * (0.1 - 0.0625);
    let product = |x: f64, y: f64| -m * x * y * (0.05 - 0.0625);
    let [xx, yy, zz] = [a, b, c].map(square);
    let expected = [[m, a / 4.0, b / 4.0, c / 4.0], [yy + zz, zz + xx, xx + yy, product(a, b)]];
    let rest = [product(b, c), product(c, a)];
    let expected: Vec<f64> = expected.into_iter().flatten().chain(rest).collect();
    assert_same(found, expected.try_into().expect("ten numbers"), 1e-14);
}

#[test]
fn a_finer_mesh_of_a_ball_is_nearer_to_it() {
    // Rings of latitude with n corners around; the volume of such a mesh differs by a term in 1/n².
    let off = |n: usize| {
        let m = n / 2;
        let mut corners = vec![[0.0, 0.0, 1.0]];
        for i in 1..m {
            for j in 0..n {
                let (theta, phi) = (PI * i as f64 / m as f64, 2.0 * PI * j as f64 / n as f64);
                corners.push([theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]);
            }
        }
        corners.push([0.0, 0.0, -1.0]);
        let ring = |i: usize, j: usize| 1 + (i - 1) * n + j % n;
        let mut faces = Vec::new();
        for j in 0..n {
            faces.push([0, ring(1, j), ring(1, j + 1)]);
            faces.push([corners.len() - 1, ring(m - 1, j + 1), ring(m - 1, j)]);
            for i in 1..m - 1 {
                faces.push([ring(i, j), ring(i + 1, j), ring(i + 1, j + 1)]);
                faces.push([ring(i, j), ring(i + 1, j + 1), ring(i, j + 1)]);
            }
        }
        let [mass, x, y, z, xx, ..] = properties(&inline(&corners, &faces, ""));
        assert!([x, y, z].iter().all(|x| x.abs() < 1e-13));
        let exact = 1000.0 * 4.0 / 3.0 * PI;
        [1.0 - mass / exact, 1.0 - xx / (0.4 * exact)]
    };
    let [coarse, fine] = [off(16), off(32)];
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        assert!((3.7..4.3).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}

/// The faults of a model that reads a file of this name and content.
fn told(name: &str, bytes: &[u8]) -> (Vec<&'static str>, Option<Properties>) {
    let text = format!(
        "space = \"spatial\"\n[bodies.b]\nfree = true\ndensity = 1000\n\
         shapes = [{{ type = \"mesh\", unit = \"mm\", file = \"{name}\" }}]\n"
    );
    let mut open = |_: &str| Ok(bytes.to_vec());
    let whole = expand("test", &text, Limits::default(), &mut open).expect("there is a file");
    if !whole.faults.is_empty() {
        return (whole.faults.iter().map(|fault| fault.code.0).collect(), None);
    }
    let reading = read(&Source::new(&whole.text, "solids"));
    let codes = reading.diagnostics.iter().map(|fault| fault.code.0).collect();
    let properties = reading.model.map(|model| {
        let of = &model.bodies[1];
        let parts = [of.mass].into_iter().chain(of.com).chain(of.inertia.moments);
        let all: Vec<f64> = parts.chain(of.inertia.products).map(|e| value(&model, e)).collect();
        all.try_into().expect("ten numbers")
    });
    (codes, properties)
}

/// The box as binary STL, as its text, and as OBJ with quadrilaterals.
fn files() -> [(&'static str, Vec<u8>); 3] {
    let (corners, faces) = box_mesh([300.0, 200.0, 100.0]);
    let mut binary = b"solid, some programs begin binary files".to_vec();
    binary.resize(80, b' ');
    binary.extend(u32::try_from(faces.len()).expect("few").to_le_bytes());
    let mut text = String::from("solid\n");
    let mut obj = String::from("# box\no box\nvn 0 0 1\n");
    for face in &faces {
        binary.extend([0; 12]);
        text += "facet normal 0 0 0\nouter loop\n";
        for &corner in face {
            let [x, y, z] = corners[corner];
            for number in [x, y, z] {
                #[expect(clippy::cast_possible_truncation, reason = "what STL has")]
                binary.extend((number as f32).to_le_bytes());
            }
            writeln!(text, "  vertex {x} {y:e} {z}").expect("text grows");
        }
        binary.extend([0; 2]);
        text += "endloop\nendfacet\n";
    }
    text += "endsolid\n";
    for [x, y, z] in &corners {
        writeln!(obj, "v {x} {y} {z}").expect("text grows");
    }
    for [a, b, c, d] in
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    {
        let back = |k: i64| k - 8;
        writeln!(obj, "f {}//1 {}//1 {} {}", a + 1, b + 1, back(c), back(d)).expect("text grows");
    }
    [("box.stl", binary), ("box.STL", text.into_bytes()), ("box.obj", obj.into_bytes())]
}

#[test]
fn meshes_in_files_are_the_box() {
    let solid =
        properties("density = 1000\nshapes = [{ type = \"box\", size = [0.3, 0.2, 0.1] }]\n");
    for (name, bytes) in files() {
        let (codes, found) = told(name, &bytes);
        assert!(codes.is_empty(), "{name}: {codes:?}");
        assert_same(found.expect("a model"), solid, 1e-14);
    }
}

#[test]
fn a_mesh_that_is_no_solid_is_refused() {
    let (corners, faces) = box_mesh([1.0, 1.0, 1.0]);
    let code = |faces: &[[usize; 3]]| {
        let text = format!(
            "space = \"spatial\"\n[bodies.b]\nfree = true\n{}",
            inline(&corners, faces, "")
        );
        let reading = read(&Source::new(&text, "solids"));
        assert!(reading.model.is_none());
        reading.diagnostics.iter().map(|fault| fault.code.0).collect::<Vec<_>>()
    };
    assert_eq!(code(&faces[1..]), ["M101"], "open");
    let mut one_turned = faces.clone();
    one_turned[3].reverse();
    assert_eq!(code(&one_turned), ["M101"], "one face is turned");
    let inside_out: Vec<[usize; 3]> = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(code(&inside_out), ["M101"], "inside out");
    assert_eq!(code(&[[0, 1, 2], [0, 2, 1]]), ["M101"], "flat");
    assert_eq!(code(&[[0, 1, 8]]), ["M100"], "no such corner");
}

#[test]
fn damaged_meshes_are_read_or_refused() {
    // A generator of Lehmer's, for damages that are the same each time.
    let mut state = 1_u64;
    let mut below = move |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(state >> 33).expect("31 bits") % n.max(1)
    };
    let mut n_refused = 0;
    for (name, bytes) in files() {
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            match below(4) {
                0 => damaged.truncate(below(bytes.len())),
                1 => damaged.extend(std::iter::repeat_n(b'1', below(200))),
                2 => drop(damaged.drain(below(bytes.len() / 2)..bytes.len() / 2)),
                _ => (),
            }
            for _ in 0..below(4) {
                let (place, byte) = (below(damaged.len()), below(256));
                if let Some(at) = damaged.get_mut(place) {
                    *at = u8::try_from(byte).expect("a byte");
                }
            }
            let (codes, found) = told(name, &damaged);
            assert!(found.is_some() || !codes.is_empty(), "refused without a reason");
            if found.is_none() {
                let known = |code: &&str| ["M100", "M101", "M002", "M094"].contains(code);
                assert!(codes.iter().all(known), "{codes:?}");
                n_refused += 1;
            }
        }
    }
    assert!(n_refused > 600, "{n_refused} of 1200 damages were seen");
}
