//! One small picture per primitive, compared with a kept one that was inspected.
//!
//! `BKSIM_BLESS=1 cargo test -p bksim-view --test view golden` replaces them: inspect them then.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::PathBuf;
use std::sync::Arc;

use bksim::sim::pose::Pose;
use bksim_scene::{
    Arrow, Attached, Camera, Color, Extras, Form, Marker, MarkerKind, Role, Scene, Shape, Span,
    SpanKind, Theme,
};
use bksim_view::film::write_png;
use bksim_view::offscreen::{Canvas, Image};
use bksim_view::renderer::Frame;

/// Points; a canvas has twice as many pixels.
const SIZE: [f64; 2] = [80.0, 60.0];

/// Largest difference of a channel, of 255, between equal pixels: adapters round edges differently.
const LARGEST_DIFFERENCE: u8 = 48;

/// Largest number of different pixels in a thousand.
const OTHERS_PER_THOUSAND: usize = 3;

/// A canvas; panics with the help on what to install.
fn canvas() -> Canvas {
    let size = SIZE.map(|x| format!("{:.0}", 2.0 * x).parse().expect("a size"));
    Canvas::new(size, 2.0).unwrap_or_else(|error| {
        panic!("{error}: {}", error.help().unwrap_or("no help is known"));
    })
}

/// Number of different pixels in a thousand.
fn difference(a: &Image, b: &Image) -> usize {
    if a.size != b.size {
        return 1000;
    }
    let is_other =
        |(a, b): &(&[u8; 4], &[u8; 4])| (0..4).any(|i| a[i].abs_diff(b[i]) > LARGEST_DIFFERENCE);
    let (a, b) = (a.rgba.as_chunks().0, b.rgba.as_chunks().0);
    (1000 * a.iter().zip(b).filter(is_other).count()).div_ceil(a.len())
}

/// The picture shifted by a pixel to the right.
fn shifted(image: &Image) -> Image {
    let width = 4 * image.size[0] as usize;
    let mut rgba = image.rgba.clone();
    for row in rgba.chunks_exact_mut(width) {
        row.rotate_right(4);
    }
    Image { size: image.size, rgba }
}

fn kept(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"))
}

fn load(path: &PathBuf) -> Image {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().expect("a PNG");
    let mut rgba = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut rgba).expect("a frame");
    Image { size: [info.width, info.height], rgba }
}

fn save(path: &PathBuf, image: &Image) {
    let file = File::create(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    write_png(BufWriter::new(file), image).expect("a picture");
}

/// Compares a picture with the kept one; a different one is written to the target directory.
fn check(name: &str, image: &Image) {
    let path = kept(name);
    if std::env::var_os("BKSIM_BLESS").is_some() {
        save(&path, image);
        return;
    }
    let expected = load(&path);
    let off = difference(&expected, image);
    if off > OTHERS_PER_THOUSAND {
        let found = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        save(&found, image);
        let (path, found) = (path.display(), found.display());
        panic!("{off} of 1000 pixels of {path} differ from {found}");
    }
    // The comparison is sharp enough: a shift by one pixel is too much.
    let off = difference(&expected, &shifted(image));
    assert!(off > OTHERS_PER_THOUSAND, "{name}: a shift by a pixel changes {off} of 1000 pixels");
}

fn camera() -> Camera {
    Camera { scale: 10.0, ..Camera::planar(SIZE) }
}

/// A scene of shapes on two bodies besides the ground.
fn scene(shapes: Vec<Shape>) -> Scene {
    let bodies = ["ground", "a", "b"].map(str::to_owned).to_vec();
    Scene { is_planar: true, bodies, shapes, pin: 0.25, ..Scene::default() }
}

fn turned(angle: f64, x: f64, y: f64) -> Pose {
    let (sin, cos) = angle.sin_cos();
    let r_world_from_body = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
    Pose { origin: [x, y, 0.0], r_world_from_body, ..Pose::default() }
}

fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
    points.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

fn region(body: usize, role: Role, rings: &[&[[f64; 2]]]) -> Shape {
    Shape { body, role, form: Form::Region(rings.iter().map(|ring| flat(ring)).collect()) }
}

fn line(body: usize, role: Role, points: &[[f64; 2]], is_closed: bool) -> Shape {
    Shape { body, role, form: Form::Line { points: flat(points), is_closed } }
}

fn circle(radius: f64, n: u32) -> Vec<[f64; 2]> {
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    (0..n).map(|i| [radius * angle(i).cos(), radius * angle(i).sin()]).collect()
}

/// The pixel in the middle.
fn in_the_middle(Image { size: [width, height], rgba }: &Image) -> Vec<u8> {
    let at = 4 * (width * (height / 2) + width / 2) as usize;
    rgba[at..at + 4].to_vec()
}

fn draw(scene: Scene, poses: &[Pose], extras: &Extras, camera: &Camera, theme: &Theme) -> Image {
    let mut canvas = canvas();
    canvas.scene_mut().set_scene(Arc::new(scene), theme);
    let frame = Frame { poses, extras, camera, theme, pixels_per_point: 1.0 };
    let (image, counts) = canvas.draw(&frame, Some(theme.background)).expect("a picture");
    // For the mechanism and each ghost: shapes below the springs, springs, shapes above; then
    // trails and arrows.
    let most = 3 * (1 + extras.ghosts.len()) + 2;
    assert!((1..=most).contains(&counts.n_draws), "{counts:?}");
    image
}

#[test]
fn a_moving_planar_mechanism_is_one_call_and_sends_only_its_placements() {
    let shapes = (0..100).map(|i| line(1 + i % 2, Role::Body(0), &circle(1.0, 64), true));
    let mut canvas = canvas();
    canvas.scene_mut().set_scene(Arc::new(scene(shapes.collect())), &Theme::LIGHT);
    let (camera, extras) = (camera(), Extras::default());
    for k in 0..3 {
        let poses = [Pose::default(), turned(0.1 * f64::from(k), 0.2, 0.1), turned(0.0, 0.0, 0.0)];
        let (camera, theme) = (&camera, &Theme::LIGHT);
        let frame = Frame { poses: &poses, extras: &extras, camera, theme, pixels_per_point: 2.0 };
        let counts = canvas.scene_mut().prepare(&frame);
        assert_eq!((counts.n_draws, counts.n_primitives), (1, 6400));
        // Three bodies, the world and the picture, each with 32 bytes.
        assert!((5 * 32..256).contains(&counts.n_bytes), "frame {k}: {counts:?}");
    }
}

#[test]
fn rods_in_space_are_two_primitives_each_and_stay_on_the_card_while_the_camera_turns() {
    let rod = |i: u8| {
        let (x, form) = (f64::from(i), |ends| Form::Rod { ends, radius: 0.1 });
        Shape { body: 1, role: Role::Body(0), form: form([[x, 0.0, 0.0], [x, 1.0, 1.0]]) }
    };
    let shapes: Vec<Shape> = (0..100).map(rod).collect();
    let mut canvas = canvas();
    let scene = Scene { is_planar: false, ..scene(shapes) };
    canvas.scene_mut().set_scene(Arc::new(scene), &Theme::LIGHT);
    let (poses, extras, theme) = ([Pose::default(); 3], Extras::default(), &Theme::LIGHT);
    for (k, order) in [800, 0, 0].into_iter().enumerate() {
        let camera = Camera::spatial(SIZE, 0.3 + 0.1 * k as f64, 0.2);
        let camera = &camera;
        let frame = Frame { poses: &poses, extras: &extras, camera, theme, pixels_per_point: 2.0 };
        let counts = canvas.scene_mut().prepare(&frame);
        assert_eq!((counts.n_draws, counts.n_primitives), (1, 200));
        // Five placements, and at first the order of painting.
        let n_bytes = counts.n_bytes - order;
        assert!((5 * 32..256).contains(&n_bytes), "frame {k}: {counts:?}");
    }
}

fn still(scene: Scene) -> Image {
    let poses = [Pose::default(), turned(0.3, 0.2, 0.1), turned(-0.5, 0.0, 0.0)];
    draw(scene, &poses, &Extras::default(), &camera(), &Theme::LIGHT)
}

const SQUARE: [[f64; 2]; 4] = [[-2.5, -2.0], [2.5, -2.0], [2.5, 2.0], [-2.5, 2.0]];

#[test]
fn an_area_has_its_hole() {
    let hole = circle(1.2, 24);
    check("hole", &still(scene(vec![region(1, Role::Body(0), &[&SQUARE, &hole])])));
}

#[test]
fn a_concave_area_is_not_filled_across() {
    let c = [
        [-2.5, -2.0],
        [2.5, -2.0],
        [2.5, -1.0],
        [-1.2, -1.0],
        [-1.2, 1.0],
        [2.5, 1.0],
        [2.5, 2.0],
        [-2.5, 2.0],
    ];
    check("concave", &still(scene(vec![region(1, Role::Body(1), &[&c])])));
}

#[test]
fn an_area_without_edges_is_smooth() {
    let dark = region(2, Role::MassDark, &[&SQUARE]);
    check("edgeless", &still(scene(vec![dark])));
}

#[test]
fn lines_have_round_joints_and_ends() {
    let zigzag = [[-3.5, -2.0], [-1.5, 2.0], [-1.0, -2.0], [0.5, 2.0], [0.6, -2.0], [3.0, 1.5]];
    check("joints", &still(scene(vec![line(0, Role::Link, &zigzag, false)])));
}

#[test]
fn a_closed_line_has_no_gap() {
    let circle = circle(2.0, 40);
    let triangle = [[-3.2, -2.2], [3.2, -2.2], [0.0, 2.4]];
    let shapes = vec![line(0, Role::Pin, &circle, true), line(0, Role::Link, &triangle, true)];
    check("closed", &still(scene(shapes)));
}

#[test]
fn later_shapes_lie_above_earlier_ones() {
    let bar = [[-3.5, -0.7], [3.5, -0.7], [3.5, 0.7], [-3.5, 0.7]];
    let pin = circle(0.5, 20);
    let shapes = vec![
        region(1, Role::Body(0), &[&bar]),
        region(2, Role::Body(1), &[&bar]),
        region(1, Role::Pin, &[&pin]),
    ];
    let image = still(scene(shapes.clone()));
    check("order", &image);
    let other = vec![shapes[1].clone(), shapes[0].clone(), shapes[2].clone()];
    assert!(difference(&image, &still(scene(other))) > OTHERS_PER_THOUSAND);
}

#[test]
fn in_space_nearer_shapes_lie_above() {
    let at = |z: f64, ring: Vec<[f64; 3]>| ring.into_iter().map(|[x, y, _]| [x, y, z]).collect();
    let plate = |z: f64, role, dx: f64| {
        let ring = SQUARE.map(|[x, y]| [0.6 * x + dx, 0.6 * y + dx]);
        Shape { body: 0, role, form: Form::Region(vec![at(z, flat(&ring))]) }
    };
    let camera = Camera { scale: 10.0, ..Camera::spatial(SIZE, 0.6, 0.7) };
    let spatial = |shapes| Scene { is_planar: false, ..scene(shapes) };
    let shapes = vec![plate(1.0, Role::Body(0), 0.4), plate(-0.5, Role::Body(1), -0.4)];
    let seen = |shapes| {
        let poses = [Pose::default(); 3];
        draw(spatial(shapes), &poses, &Extras::default(), &camera, &Theme::DARK)
    };
    let image = seen(shapes.clone());
    check("depth", &image);
    // The order in the scene does not matter.
    assert_eq!(difference(&image, &seen(shapes.into_iter().rev().collect())), 0);
}

#[test]
fn from_the_other_side_the_order_is_reversed_and_pins_are_in_front_of_their_bodies() {
    let upright = |y: f64, role, size: f64| {
        let ring = SQUARE.iter().map(|[x, z]| [size * x, y, size * z]).collect();
        Shape { body: 0, role, form: Form::Region(vec![ring]) }
    };
    let (near, far) = (upright(-1.0, Role::Body(0), 0.8), upright(1.0, Role::Body(1), 0.8));
    let pin = upright(0.0, Role::Pin, 0.3);
    let middle = |shapes: &[&Shape], azimuth: f64| {
        let shapes = shapes.iter().map(|&shape| shape.clone()).collect();
        let scene = Scene { is_planar: false, ..scene(shapes) };
        let camera = Camera { scale: 10.0, ..Camera::spatial(SIZE, azimuth, 0.1) };
        let poses = [Pose::default(); 3];
        in_the_middle(&draw(scene, &poses, &Extras::default(), &camera, &Theme::LIGHT))
    };
    let (front, back) = (0.0, std::f64::consts::PI);
    let [blue, orange, white] = [&near, &far, &pin].map(|shape| middle(&[shape], front));
    assert!(blue != orange && orange != white && white != blue);
    for (azimuth, expected) in
        [(front, &blue), (0.4, &blue), (back, &orange), (back + 0.4, &orange)]
    {
        for shapes in [[&near, &far], [&far, &near]] {
            assert_eq!(&middle(&shapes, azimuth), expected, "from {azimuth} rad");
        }
    }
    // A pin within its radius of a bar is visible from both sides, one far from it is not.
    let joined = upright(0.1, Role::Body(1), 0.8);
    assert_eq!(middle(&[&pin, &joined], front), white);
    assert_eq!(middle(&[&pin, &joined], back), white);
    assert_eq!(middle(&[&pin, &far], back), orange);
}

#[test]
fn rods_and_balls_are_equally_wide_in_every_view() {
    let rod = |body, role, ends, radius| Shape { body, role, form: Form::Rod { ends, radius } };
    let (foot, head) = ([-1.4, 0.0, -1.2], [1.2, 0.6, 1.4]);
    let shapes = vec![
        rod(1, Role::Body(0), [foot, head], 0.35),
        rod(1, Role::Weld, [foot, foot], 0.3),
        rod(2, Role::Body(1), [head, head], 0.8),
    ];
    let seen = |azimuth: f64, shapes| {
        let camera = Camera { scale: 10.0, ..Camera::spatial(SIZE, azimuth, 0.4) };
        let scene = Scene { is_planar: false, ..scene(shapes) };
        let poses = [Pose::default(); 3];
        draw(scene, &poses, &Extras::default(), &camera, &Theme::LIGHT)
    };
    let image = seen(0.6, shapes.clone());
    check("rods", &image);
    assert!(difference(&image, &seen(2.2, shapes)) > OTHERS_PER_THOUSAND);
}

#[test]
fn in_a_plane_rods_keep_their_position_in_the_order_of_the_scene() {
    let ball = |role, radius| {
        let form = Form::Rod { ends: [[0.0; 3]; 2], radius };
        Shape { body: 1, role, form }
    };
    let (plate, ball, pin) =
        (region(1, Role::Body(0), &[&SQUARE]), ball(Role::Body(1), 0.9), ball(Role::Pin, 0.4));
    let end = |x: f64| Attached { body: 0, position: [x, 0.0, 0.0] };
    let link = Span { name: "l".into(), ends: [end(-3.0), end(3.0)], kind: SpanKind::Link };
    let middle = |shapes: &[&Shape], spans: &[&Span]| {
        let shapes = shapes.iter().map(|&shape| shape.clone()).collect();
        let spans = spans.iter().map(|&span| span.clone()).collect();
        in_the_middle(&still(Scene { spans, ..scene(shapes) }))
    };
    let [blue, orange, white] = [&plate, &ball, &pin].map(|shape| middle(&[shape], &[]));
    let dark = middle(&[], &[&link]);
    assert!([&orange, &white, &dark].iter().all(|&other| *other != blue));
    assert!(orange != white && white != dark && dark != orange);
    for (shapes, expected) in
        [([&plate, &ball], &orange), ([&ball, &plate], &blue), ([&pin, &ball], &white)]
    {
        assert_eq!(&middle(&shapes, &[]), expected);
    }
    // A link lies over plates and balls, and below pins.
    assert_eq!(middle(&[&plate, &ball], &[&link]), dark);
    assert_eq!(middle(&[&pin, &ball], &[&link]), white);
}

#[test]
fn ghosts_are_faint_and_below_the_mechanism() {
    let bar = [[-0.4, -0.4], [3.2, -0.4], [3.2, 0.4], [-0.4, 0.4]];
    let shapes = vec![region(1, Role::Body(2), &[&bar])];
    let at = |angle: f64| vec![Pose::default(), turned(angle, -1.5, -1.0), Pose::default()];
    let ghosts = [1.6, 1.1, 0.7].map(at).to_vec();
    let extras = Extras { ghosts, ..Extras::default() };
    check("ghosts", &draw(scene(shapes), &at(0.3), &extras, &camera(), &Theme::LIGHT));
}

#[test]
fn springs_stretch_between_bodies() {
    let end = |body: usize, x: f64| Attached { body, position: [x, 0.0, 0.0] };
    let span = Span {
        name: "s".into(),
        ends: [end(0, -3.0), end(2, 2.0)],
        kind: SpanKind::Spring { length: 4.0, is_damped: false },
    };
    let scene = Scene { spans: vec![span], pin: 0.3, ..scene(Vec::new()) };
    check("spring", &still(scene));
}

#[test]
fn arrows_and_trails_and_names_are_drawn() {
    let pin = circle(0.4, 20);
    let markers = vec![Marker {
        name: "crank.P".into(),
        kind: MarkerKind::Point,
        at: Attached { body: 0, position: [-1.0, 0.0, 0.0] },
    }];
    let ring = pin.iter().map(|[x, y]| [x - 1.0, *y]).collect::<Vec<_>>();
    let scene = Scene { markers, ..scene(vec![region(0, Role::Pin, &[&ring])]) };
    let trail = flat(&circle(2.2, 60)[..40]);
    for (name, theme) in [("beside", &Theme::LIGHT), ("beside-dark", &Theme::DARK)] {
        let extras = Extras {
            trails: vec![(theme.palette[1], trail.clone())],
            arrows: vec![Arrow {
                color: theme.force,
                from: [-1.0, 0.0, 0.0],
                vector: [3.5, 1.5, 0.0],
                is_hollow: false,
            }],
            has_labels: true,
            ..Extras::default()
        };
        check(name, &draw(scene.clone(), &[Pose::default(); 3], &extras, &camera(), theme));
    }
}

#[test]
fn a_picture_without_background_is_transparent() {
    let scene = scene(vec![region(0, Role::Pin, &[&SQUARE])]);
    let mut canvas = canvas();
    canvas.scene_mut().set_scene(Arc::new(scene), &Theme::LIGHT);
    let (extras, camera) = (Extras::default(), camera());
    let poses = &[Pose::default(); 3];
    let theme = &Theme::LIGHT;
    let frame = Frame { poses, extras: &extras, camera: &camera, theme, pixels_per_point: 1.0 };
    let (image, _) = canvas.draw(&frame, None).expect("a picture");
    let pixels = image.rgba.as_chunks::<4>().0;
    assert_eq!(pixels[0], [0; 4]);
    let middle = pixels[pixels.len() / 2 + image.size[0] as usize / 2];
    let Color(white) = theme.background;
    assert_eq!(middle, white);
    // A second picture is the same to the last bit.
    let (again, _) = canvas.draw(&frame, None).expect("a picture");
    assert_eq!(image, again);
}

#[test]
fn far_from_the_origin_pictures_stay_exact() {
    // A hundred kilometres away, and a body whose outline is as far from the origin of its frame.
    let far = 1e5;
    let near = |x: f64| SQUARE.map(|[u, v]| [u + x, v]);
    let image = |x: f64| {
        let shapes =
            vec![region(1, Role::Body(0), &[&near(-x)]), region(0, Role::Pin, &[&near(x)])];
        let mut camera = camera();
        camera.centre = [x, 0.0, 0.0];
        let poses = [Pose::default(), turned(0.0, 2.0 * x, 0.0), Pose::default()];
        draw(scene(shapes), &poses, &Extras::default(), &camera, &Theme::LIGHT)
    };
    assert_eq!(difference(&image(0.0), &image(far)), 0);
}
