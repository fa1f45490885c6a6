//! Solids cut by a plane: the areas of cut faces and the volumes that are left, against closed forms; and pictures.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use bksim_model::file::{Source, read};
use bksim_scene::{
    Arrow, Attached, Camera, CutSide, Extras, Form, Item, Marker, MarkerKind, Role, Scene, Section,
    Shape, Solid, Span, SpanKind, Theme, picture,
};
use bksim_sim::pose::Pose;

/// A scene of these forms on the ground.
fn scene_of(forms: Vec<Form>) -> Scene {
    let shape = |form| Shape { body: 0, role: Role::Body(0), form };
    let shapes = forms.into_iter().map(shape).collect();
    Scene { bodies: vec!["ground".into()], shapes, pin: 0.01, ..Scene::default() }
}

/// The form of the shape that a body has with this text.
fn stated(shape: &str) -> Form {
    let text =
        format!("space = \"spatial\"\n[bodies.b]\ndensity = 1000\nfree = true\nshapes = [{shape}]");
    let reading = read(&Source::new(&text, "section"));
    let model = reading.model.unwrap_or_else(|| panic!("{:#?}", reading.diagnostics));
    let is_stated = |shape: &Shape| matches!(shape.form, Form::Solid(_) | Form::Rod { .. });
    let shapes = Scene::of(&model, &[]).shapes;
    shapes.into_iter().find(is_stated).expect("a shape").form
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// The vector of the area inside a ring.
fn area(ring: &[[f64; 3]]) -> [f64; 3] {
    let next = ring.iter().cycle().skip(1);
    let parts = ring.iter().zip(next).map(|(&a, &b)| cross(a, b).map(|x| 0.5 * x));
    parts.fold([0.0; 3], |sum, part| [0, 1, 2].map(|i| sum[i] + part[i]))
}

/// The area inside rings of one plane by the even–odd rule: each counts by how many others are about it.
fn filled(rings: &[Vec<[f64; 3]>], n: [f64; 3]) -> f64 {
    let is_about = |ring: &[[f64; 3]], p: [f64; 3]| {
        let angle = |(&a, &b): (&[f64; 3], &[f64; 3])| {
            let [a, b] = [a, b].map(|q| [0, 1, 2].map(|i| q[i] - p[i]));
            dot(n, cross(a, b)).atan2(dot(a, b))
        };
        let turns: f64 = ring.iter().zip(ring.iter().cycle().skip(1)).map(angle).sum();
        (turns / TAU).round().rem_euclid(2.0) > 0.5
    };
    let sign = |k: usize| {
        let others = rings.iter().enumerate().filter(|(other, _)| *other != k);
        let n_about = others.filter(|(_, ring)| is_about(ring, rings[k][0])).count();
        if n_about % 2 == 0 { 1.0 } else { -1.0 }
    };
    (0..rings.len()).map(|k| sign(k) * dot(area(&rings[k]), n).abs()).sum()
}

/// Area of the cut face and volume of what is left below the plane.
fn cut(form: &Form, normal: [f64; 3], point: [f64; 3]) -> (f64, f64) {
    let section = Section::new(normal, point, CutSide::Above).expect("a plane");
    let n = section.normal();
    let half = section.kept(n, 0.0);
    let left = scene_of(vec![form.clone()]).cut(&half, &[Pose::default()], n);
    let (mut face, mut volume) = (0.0, 0.0);
    for shape in left.shapes {
        match shape.form {
            Form::Solid(solid) => {
                let corners = |ring: &[usize]| -> Vec<_> {
                    ring.iter().map(|&corner| solid.corners[corner]).collect()
                };
                // By the divergence theorem, of x: plane faces about corners below the plane.
                volume += solid
                    .faces
                    .iter()
                    .map(|ring| dot(corners(ring)[0], area(&relative(&corners(ring)))) / 3.0)
                    .sum::<f64>();
                assert!(solid.corners.iter().all(|&p| half.height(p) < 1e-12));
            }
            Form::Section { rings, .. } => {
                face = filled(&rings, n);
                volume += face * section.offset / 3.0;
            }
            Form::Rod { .. } => panic!("a rod that is not cut"),
            _ => panic!("only solids"),
        }
    }
    (face, volume)
}

/// A ring about its first corner, so that its area does not suffer from the distance to the origin.
fn relative(ring: &[[f64; 3]]) -> Vec<[f64; 3]> {
    ring.iter().map(|p| [0, 1, 2].map(|i| p[i] - ring[0][i])).collect()
}

#[track_caller]
fn check((area, volume): (f64, f64), expected: (f64, f64), tolerance: f64) {
    assert!((area / expected.0 - 1.0).abs() < tolerance, "area {area}, not {}", expected.0);
    assert!((volume / expected.1 - 1.0).abs() < tolerance, "volume {volume}, not {}", expected.1);
}

/// A square plate of triangles, 2 m wide and 0.2 m thick, with a hole of `n` corners.
fn plate_with_hole(radius: f64, n: usize) -> Form {
    let inner = |k: usize| {
        let angle = TAU * k as f64 / n as f64;
        [radius * angle.cos(), radius * angle.sin()]
    };
    // On the outer square in the same direction.
    let outer = |k: usize| {
        let [x, y] = inner(k);
        let most = x.abs().max(y.abs());
        [x / most, y / most]
    };
    let mut corners = Vec::new();
    for z in [-0.1, 0.1] {
        for ring in [&outer as &dyn Fn(usize) -> [f64; 2], &inner] {
            corners.extend((0..n).map(|k| [ring(k)[0], ring(k)[1], z]));
        }
    }
    let mut faces = Vec::new();
    let mut quad = |[a, b, c, d]: [usize; 4]| faces.extend([vec![a, b, c], vec![a, c, d]]);
    for k in 0..n {
        let next = (k + 1) % n;
        let [low_out, low_in, high_out, high_in] = [0, n, 2 * n, 3 * n];
        quad([high_out + k, high_out + next, high_in + next, high_in + k]);
        quad([low_out + next, low_out + k, low_in + k, low_in + next]);
        quad([low_out + k, low_out + next, high_out + next, high_out + k]);
        quad([low_in + next, low_in + k, high_in + k, high_in + next]);
    }
    Form::Solid(Solid::new(corners, faces))
}

/// A torus of triangles about z.
fn torus(radius: f64, tube: f64, n: usize) -> Form {
    let angle = |k: usize| TAU * k as f64 / n as f64;
    let corner = |at: usize| {
        let (about, around) = (angle(at / n), angle(at % n));
        let r = radius + tube * around.cos();
        [r * about.cos(), r * about.sin(), tube * around.sin()]
    };
    let at = |i: usize, j: usize| (i % n) * n + j % n;
    let faces = (0..n * n).flat_map(|k| {
        let (i, j) = (k / n, k % n);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [vec![a, b, c], vec![a, c, d]]
    });
    Form::Solid(Solid::new((0..n * n).map(corner).collect(), faces.collect()))
}

/// Twice the area of a polygon of `n` corners on a circle, over the square of its radius.
fn polygon(n: usize) -> f64 {
    n as f64 * (TAU / n as f64).sin()
}

#[test]
fn cut_faces_of_boxes_cylinders_and_plates_have_the_areas_of_the_formulas() {
    let cube = stated("{ type = \"box\", size = [0.3, 0.2, 0.1] }");
    check(cut(&cube, [1.0, 0.0, 0.0], [0.05, 7.0, 7.0]), (0.02, 0.004), 1e-12);
    check(cut(&cube, [-2.0, 0.0, 0.0], [0.05, 0.0, 0.0]), (0.02, 0.002), 1e-12);
    // Across the diagonal of a cube: a regular hexagon.
    let cube = stated("{ type = \"box\", size = [2, 2, 2], at = [5, 0, 0] }");
    check(cut(&cube, [1.0, 1.0, 1.0], [5.0, 0.0, 0.0]), (3.0 * 3f64.sqrt(), 4.0), 1e-12);
    // A cylinder at a slant, an ellipse; and along its axis, a rectangle.
    let cylinder = stated("{ type = \"cylinder\", radius = 0.2, length = 2 }");
    let base = 0.5 * polygon(64) * 0.04;
    let (sin, cos) = 0.5_f64.sin_cos();
    check(cut(&cylinder, [sin, 0.0, cos], [0.0; 3]), (base / cos, base), 1e-12);
    check(cut(&cylinder, [0.0, 1.0, 0.0], [0.0; 3]), (0.8, base), 1e-12);
    // Two legs of a fork, and its bridge.
    let fork = stated(
        "{ type = \"plate\", thickness = 0.1, outline = [[0, 0], [3, 0], [3, 4], [2, 4], [2, 1], \
         [1, 1], [1, 4], [0, 4]] }",
    );
    check(cut(&fork, [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]), (0.2, 0.5), 1e-12);
    check(cut(&fork, [0.0, 0.0, 1.0], [0.0; 3]), (9.0, 0.45), 1e-12);
    check(cut(&fork, [1.0, 0.0, 0.0], [1.5, 0.0, 0.0]), (0.1, 0.45), 1e-12);
}

#[test]
fn holes_of_meshes_are_spared() {
    let (radius, n) = (0.5, 24);
    let plate = plate_with_hole(radius, n);
    let hole = 0.5 * polygon(n) * radius * radius;
    check(cut(&plate, [0.0, 0.0, 1.0], [0.0; 3]), (4.0 - hole, 0.1 * (4.0 - hole)), 1e-12);
    check(cut(&plate, [0.0, 1.0, 0.0], [0.0; 3]), (0.2, 0.1 * (4.0 - hole)), 1e-12);
    let torus = torus(1.0, 0.25, 120);
    let volume = 2.0 * PI * PI / 16.0;
    check(cut(&torus, [0.0, 0.0, 1.0], [0.0; 3]), (PI, 0.5 * volume), 2e-3);
    check(cut(&torus, [1.0, 0.0, 0.0], [0.0; 3]), (PI / 8.0, 0.5 * volume), 2e-3);
    // Through the middle at a slant that touches it twice: two circles of Villarceau, of radius 1.
    let slant = 0.25_f64.asin();
    let found = cut(&torus, [0.0, slant.sin(), -slant.cos()], [0.0; 3]).1;
    assert!((found / (0.5 * volume) - 1.0).abs() < 2e-3, "{found}");
}

#[test]
fn rods_and_balls_are_cut_as_solids() {
    let ball = Form::Rod { ends: [[0.0, 0.0, 0.3]; 2], radius: 0.5 };
    // A cap of height 0.3 is left out.
    let left = 4.0 / 3.0 * PI * 0.125 - PI * 0.09 * (0.5 - 0.1);
    check(cut(&ball, [0.0, 0.0, 1.0], [0.0, 0.0, 0.5]), (PI * (0.25 - 0.04), left), 0.015);
    let rod = Form::Rod { ends: [[0.0; 3], [2.0, 0.0, 0.0]], radius: 0.1 };
    let whole = PI * 0.02 + 4.0 / 3.0 * PI * 1e-3;
    let along = 0.4 + PI * 0.01;
    check(cut(&rod, [0.0, 1.0, 0.0], [0.0; 3]), (along, 0.5 * whole), 0.015);
    check(cut(&rod, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), (PI * 0.01, 0.5 * whole), 0.015);
}

#[test]
fn both_sides_of_any_plane_make_up_the_whole() {
    let solids = [
        (stated("{ type = \"box\", size = [1, 2, 3], rpy = [0.3, 0.2, 0.1] }"), 6.0),
        (stated("{ type = \"cylinder\", radius = 1, length = 2 }"), polygon(64)),
        (plate_with_hole(0.5, 16), 0.2 * (4.0 - 0.125 * polygon(16))),
        (
            stated(
                "{ type = \"plate\", thickness = 1, outline = [[0, 0], [1, 0.5], [2, 0], [2, 2], \
                 [1.5, 0.7], [1, 2], [0.5, 0.7], [0, 2]] }",
            ),
            2.0 * (0.5 * 2.0 * 2.0) - 0.0,
        ),
    ];
    // A low-discrepancy sequence of planes.
    let part = |k: u32, root: f64| (f64::from(k) * root).fract();
    for (solid, expected) in &solids[..3] {
        for k in 1..200 {
            let (azimuth, height) = (TAU * part(k, 0.754_877), 2.0 * part(k, 0.569_84) - 1.0);
            let r = (1.0 - height * height).sqrt();
            let normal = [r * azimuth.cos(), r * azimuth.sin(), height];
            let offset = 1.2 * part(k, 0.618_034) - 0.6;
            let point = normal.map(|x| offset * x);
            let below = cut(solid, normal, point);
            let above = cut(solid, normal.map(|x| -x), point);
            assert!((below.0 - above.0).abs() < 1e-12, "plane {k}: {below:?}, {above:?}");
            let whole = below.1 + above.1;
            assert!((whole / expected - 1.0).abs() < 1e-11, "plane {k}: {whole}, not {expected}");
        }
    }
    // Concave faces fall into pieces at any height.
    let (crown, _) = &solids[3];
    let whole = cut(crown, [0.0, 1.0, 0.0], [0.0, 9.0, 0.0]).1;
    for k in 1..200 {
        let y = 2.0 * part(k, 0.618_034);
        let slanted = [0.3 * part(k, 0.754_877), 1.0, 0.2];
        let below = cut(crown, slanted, [1.0, y, 0.0]);
        let above = cut(crown, slanted.map(|x| -x), [1.0, y, 0.0]);
        assert!((below.0 - above.0).abs() < 1e-12, "plane {k}");
        assert!((below.1 + above.1 - whole).abs() < 1e-11 * whole, "plane {k}");
    }
}

#[test]
fn a_solid_that_only_touches_the_plane_is_whole_or_gone() {
    let cube = stated("{ type = \"box\", size = [2, 2, 2] }");
    let scene = scene_of(vec![cube.clone()]);
    let left = |z: f64, normal: [f64; 3]| {
        let section = Section::new(normal, [0.0, 0.0, z], CutSide::Above).expect("a plane");
        let half = scene.half(Some(section), normal).expect("in space");
        scene.cut(&half, &[Pose::default()], normal).shapes
    };
    let up = [0.0, 0.0, 1.0];
    assert_eq!(left(1.0, up), scene.shapes);
    assert_eq!(left(-1.0, up), []);
    assert_eq!(left(1.0, up.map(|x| -x)), []);
    assert_eq!(left(0.0, up).len(), 2);
}

/// A ball in a box with a cavity, a spring and signs on both sides of x = 0.
fn housing() -> (Scene, Extras) {
    let block = |half: f64, is_cavity: bool| {
        let Form::Solid(solid) =
            stated(&format!("{{ type = \"box\", size = [{0}, {0}, {0}] }}", 2.0 * half))
        else {
            panic!("a box")
        };
        let turned = |face: &Vec<usize>| face.iter().rev().copied().collect();
        let faces =
            solid.faces.iter().map(|face| if is_cavity { turned(face) } else { face.clone() });
        (solid.corners, faces.collect::<Vec<_>>())
    };
    let ((mut corners, mut faces), (inner, inner_faces)) = (block(1.0, false), block(0.6, true));
    let n = corners.len();
    corners.extend(inner);
    faces.extend(inner_faces.iter().map(|face| face.iter().map(|corner| corner + n).collect()));
    let mut scene = scene_of(vec![
        Form::Rod { ends: [[0.0; 3]; 2], radius: 0.3 },
        Form::Solid(Solid::new(corners, faces)),
    ]);
    scene.pin = 0.05;
    let at = |x: f64| Attached { body: 0, position: [x, 0.0, 1.5] };
    for x in [-0.8, 0.8] {
        let form = Form::Rod { ends: [at(x).position; 2], radius: 0.05 };
        scene.shapes.push(Shape { body: 0, role: Role::Pin, form });
        let name = if x < 0.0 { "left" } else { "right" };
        scene.markers.push(Marker { name: name.into(), kind: MarkerKind::Point, at: at(x) });
    }
    let kind = SpanKind::Spring { length: 1.0, is_damped: false };
    scene.spans.push(Span { name: "spring".into(), ends: [at(-0.8), at(0.8)], kind });
    let color = Theme::LIGHT.force;
    let arrow =
        |x: f64| Arrow { color, from: at(x).position, vector: [-0.1, 0.0, 0.2], is_hollow: false };
    let trail = (0..=20).map(|k| [0.1 * f64::from(k) - 1.0, 0.0, 1.3]).collect();
    let extras = Extras {
        trails: vec![(color, trail)],
        arrows: vec![arrow(-0.8), arrow(0.8)],
        has_labels: true,
        ..Extras::default()
    };
    (scene, extras)
}

#[test]
fn nothing_is_drawn_beyond_the_plane_and_the_cut_face_lies_over_what_is_left() {
    let (scene, extras) = housing();
    let camera = Camera { scale: 100.0, ..Camera::spatial([400.0, 400.0], 0.0, 0.0) };
    let seen = |section| {
        let extras = Extras { section, ..extras.clone() };
        picture(&scene, &[Pose::default()], &extras, &camera, &Theme::LIGHT)
    };
    let rightmost = |items: &[Item]| {
        let points = items.iter().flat_map(|item| match item {
            Item::Region { rings, .. } => rings.concat(),
            Item::Line { points, .. } => points.clone(),
            Item::Text { at, .. } => vec![*at],
        });
        points.map(|p| p[0]).fold(f32::NEG_INFINITY, f32::max)
    };
    let texts =
        |items: &[Item]| items.iter().filter(|item| matches!(item, Item::Text { .. })).count();
    let whole = seen(None).items;
    assert!(rightmost(&whole) > 299.0 && texts(&whole) == 2);
    // The half at the left, seen from the front: its face is seen on edge, and not drawn.
    let section = Section::new([1.0, 0.0, 0.0], [0.0; 3], CutSide::Above);
    let half = seen(section).items;
    let far = rightmost(&half);
    assert!((199.0..201.0).contains(&far), "{far}");
    assert_eq!(texts(&half), 1);

    // The front half is left out: the walls are cut, then the ball, both over what lies behind them.
    let section = Section::new([0.0, 1.0, 0.0], [0.0; 3], CutSide::Nearer);
    let items = seen(section).items;
    let fill = Theme::LIGHT.section(Role::Body(0)).fill;
    let region = |item: &Item| match item {
        Item::Region { rings, fill } => Some((rings.len(), *fill)),
        _ => None,
    };
    let faces: Vec<(usize, usize)> = items
        .iter()
        .enumerate()
        .filter_map(|(at, item)| region(item).filter(|it| it.1 == fill).map(|it| (at, it.0)))
        .collect();
    let n_rings: Vec<usize> = faces.iter().map(|face| face.1).collect();
    assert_eq!(n_rings, [1, 2], "the ball, and walls about their cavity");
    let body = |shade: f32| Theme::LIGHT.paint(Role::Body(0)).shaded(shade);
    let is_body = |color| (0..=1000).any(|k| body(k as f32 / 1000.0) == Some(color));
    let last = items.iter().rposition(|item| region(item).is_some_and(|it| is_body(it.1)));
    assert!(last.expect("a face of a solid") < faces[0].0);
    assert_eq!(texts(&items), 2, "signs in the plane are kept");
}

#[test]
fn a_body_that_moves_is_cut_where_it_is() {
    let mut scene = scene_of(vec![stated("{ type = \"box\", size = [2, 1, 1] }")]);
    scene.bodies.push("slider".into());
    scene.shapes[0].body = 1;
    let section = Section::new([0.0, 1.0, 0.0], [0.0, 0.25, 0.0], CutSide::Above).expect("one");
    let eye = section.normal();
    let half = section.kept(eye, 0.0);
    let (sin, cos) = FRAC_PI_4.sin_cos();
    let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
    for (x, r_world_from_body) in [(0.0, Pose::default().r_world_from_body), (3.0, turn)] {
        let pose = Pose { origin: [x, 0.0, 0.0], r_world_from_body, ..Pose::default() };
        let left = scene.cut(&half, &[Pose::default(), pose], eye);
        let [_, Shape { form: Form::Section { rings, hatching }, .. }] = &left.shapes[..] else {
            panic!("a solid and its face")
        };
        // The hatching stays where it is in the plane while the body moves.
        let in_plane = |p: [f64; 3]| (pose.place(p)[1] - 0.25).abs() < 1e-12;
        assert!(rings.iter().flatten().chain(hatching.as_flattened()).all(|&p| in_plane(p)));
        let found = dot(area(&rings[0]), pose.r_world_from_body[1]).abs();
        let expected = if x == 0.0 { 2.0 } else { 2f64.sqrt() };
        assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
    }
}

#[test]
fn lines_are_kept_in_pieces_up_to_the_plane() {
    let section = Section::new([2.0, 0.0, 0.0], [1.0, 9.0, 9.0], CutSide::Above).expect("a plane");
    let eye = [0.0, 0.0, 1.0];
    let half = section.kept(eye, 0.0);
    let at = |x: f64| [x, 2.0 * x, 0.0];
    let line = [0.0, 3.0, 0.5, 0.25, 2.0].map(at);
    let kept = vec![[0.0, 1.0].map(at).to_vec(), [1.0, 0.5, 0.25, 1.0].map(at).to_vec()];
    assert_eq!(half.pieces(&line), kept);
    assert!(half.pieces(&[at(2.0), at(3.0)]).is_empty());
    // A closed line begins where it was left out, and so has no seam.
    let square = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let scene = scene_of(vec![Form::Line { points: square, is_closed: true }]);
    let left = scene.cut(&half, &[Pose::default()], eye);
    let [Shape { form: Form::Line { points, is_closed: false }, .. }] = &left.shapes[..] else {
        panic!("one piece");
    };
    let expected = [[1.0, 2.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    assert_eq!(points[..], expected);
}

#[test]
fn plane_areas_are_cut_with_their_holes() {
    let square = |half: f64| {
        [[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]].to_vec()
    };
    let scene = scene_of(vec![Form::Region(vec![square(2.0), square(1.0)])]);
    let kept = |x: f64| {
        let section = Section::new([1.0, 0.0, 0.0], [x, 0.0, 0.0], CutSide::Above);
        let half = section.expect("a plane").kept([0.0, 0.0, 1.0], 0.0);
        match &scene.cut(&half, &[Pose::default()], [0.0, 0.0, 1.0]).shapes[..] {
            [Shape { form: Form::Region(rings), .. }] => filled(rings, [0.0, 0.0, 1.0]),
            left => {
                assert_eq!(left, []);
                0.0
            }
        }
    };
    for (x, area) in [(-2.5, 0.0), (-1.5, 2.0), (0.5, 10.0 - 3.0), (1.5, 10.0), (3.0, 12.0)] {
        assert!((kept(x) - area).abs() < 1e-12, "{} up to x = {x}", kept(x));
    }
}

#[test]
fn the_nearer_side_is_left_out_from_wherever_it_is_seen() {
    let section = Section::new([0.0, 3.0, 0.0], [0.0, 0.5, 0.0], CutSide::Nearer);
    let section = section.expect("a plane");
    for eye in [[0.6, 0.8, 0.0], [0.6, -0.8, 0.0]] {
        let half = section.kept(eye, 0.0);
        assert!(half.height(eye) > 0.0 && half.height([0.0, 0.5, 3.0]).abs() < 1e-15);
    }
    let mut above = section;
    above.side = CutSide::Above;
    assert!(above.kept([0.6, -0.8, 0.0], 0.0).height([0.0, 1.0, 0.0]) > 0.0);
    assert_eq!(Section::new([0.0; 3], [1.0; 3], CutSide::Above), None);
    assert_eq!(Section::new([1.0; 3], [f64::NAN; 3], CutSide::Above), None);
}

#[test]
fn a_hatching_covers_the_cut_face_evenly_and_spares_its_hole() {
    for pin in [0.02, 1e-7] {
        for body in 0..6 {
            let mut scene = scene_of(vec![plate_with_hole(0.5, 48)]);
            scene.pin = pin;
            scene.bodies = vec![String::new(); 6];
            scene.shapes[0].body = body;
            let section = Section::new([0.0, 0.0, 1.0], [0.0; 3], CutSide::Above);
            let half = section.expect("a plane").kept([0.0, 0.0, 1.0], 0.0);
            let left = scene.cut(&half, &[Pose::default(); 6], [0.0, 0.0, 1.0]);
            let Form::Section { hatching, .. } = &left.shapes[1].form else { panic!("a face") };
            let ([ax, ay, _], [bx, by, _]) = (hatching[0][0], hatching[0][1]);
            let length = (bx - ax).hypot(by - ay);
            let across = |[x, y, _]: [f64; 3]| (ax - bx) / length * y + (by - ay) / length * x;
            let mut places: Vec<f64> = hatching.iter().map(|line| across(line[0])).collect();
            places.sort_by(f64::total_cmp);
            places.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            assert!(places.len() < 203, "{} lines", places.len());
            let spacing = (places[places.len() - 1] - places[0]) / (places.len() - 1) as f64;
            let total: f64 = hatching.iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum();
            let area = 4.0 - 0.125 * polygon(48);
            assert!((total * spacing / area - 1.0).abs() < 0.03, "{} m²", total * spacing);
            let is_in_hole =
                |[a, b]: &[[f64; 3]; 2]| (0.5 * (a[0] + b[0])).hypot(0.5 * (a[1] + b[1])) < 0.49;
            assert!(!hatching.iter().any(is_in_hole), "body {body}");
        }
    }
}
