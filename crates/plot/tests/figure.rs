//! Figures from outside: the SVG is parsed, the PNG decoded, the PDF searched.

use bksim_plot::{Axis, Curve, Figure, Format, Panel, Point, Scale, Screen, Size, Theme};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const SIZE: Size = Size { width: 800.0, height: 500.0 };

fn wave(n: u32) -> Vec<Point> {
    (0..n).map(|i| 10.0 * f64::from(i) / f64::from(n - 1)).map(|t| [t, 3.0 * t.sin()]).collect()
}

fn figure(curves: Vec<Curve>) -> Figure {
    let panel = Panel::new(Axis::new("Time", "s"), Axis::new("Angle", "rad"), curves);
    Figure::new("pendulum", vec![panel])
}

/// Points of the path of each curve, piece by piece.
fn drawn(svg: &str) -> Vec<Vec<Vec<Point>>> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let curves = document.descendants().filter(|node| node.attribute("class") == Some("curve"));
    let path = |node: roxmltree::Node<'_, '_>| {
        let path = node.children().find(|child| child.has_tag_name("path")).expect("a path");
        let pieces = path.attribute("d").expect("data").split('M').skip(1);
        let point = |text: &str| {
            let mut numbers =
                text.trim_end_matches("h0").split(' ').map(|n| n.parse().expect("a number"));
            [numbers.next().expect("x"), numbers.next().expect("y")]
        };
        pieces.map(|piece| piece.split('L').map(point).collect()).collect()
    };
    curves.map(path).collect()
}

/// Numbers at an axis, with their positions: of the ordinate if `anchor` is `end`.
fn numbers(svg: &str, anchor: &str) -> Vec<(f64, f64)> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    let of_axis = texts.filter(|node| node.attribute("text-anchor") == Some(anchor));
    let number = |node: roxmltree::Node<'_, '_>| {
        let value = node.text()?.replace('−', "-").parse().ok()?;
        let at = node.attribute(if anchor == "end" { "y" } else { "x" })?.parse().ok()?;
        Some((value, at))
    };
    of_axis.filter_map(number).collect()
}

/// The inverse of an axis: the straight line through two pairs of number and position.
fn inverse(numbers: &[(f64, f64)]) -> impl Fn(f64) -> f64 + use<> {
    let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
    move |position| first.0 + (position - first.1) / (last.1 - first.1) * (last.0 - first.0)
}

#[test]
fn points_stand_at_the_numbers_of_the_axes() {
    let svg = figure(vec![Curve::new("A_angle", wave(40))]).to_svg(SIZE, &Theme::LIGHT);
    let points = &drawn(&svg)[0][0];
    let [x, y] = ["middle", "end"].map(|anchor| inverse(&numbers(&svg, anchor)));
    // Numbers are not level with their ticks; that shifts all of them alike.
    let shift = {
        let line = svg.split("class=\"zero\" d=\"M").nth(1).expect("a line at zero");
        let position: f64 = line.split([' ', 'H']).nth(1).expect("y").parse().expect("a number");
        y(position)
    };
    assert_eq!(points.len(), 40);
    for (point, [t, value]) in points.iter().zip(wave(40)) {
        assert!((x(point[0]) - t).abs() < 2e-3, "{} for {t}", x(point[0]));
        assert!((y(point[1]) - shift - value).abs() < 5e-3, "{} for {value}", y(point[1]) - shift);
    }
}

#[test]
fn a_peak_of_one_point_in_a_hundred_thousand_is_drawn() {
    let mut points = wave(100_000);
    points[54_321][1] = 50.0;
    let svg = figure(vec![Curve::new("a", points)]).to_svg(SIZE, &Theme::LIGHT);
    let points = &drawn(&svg)[0][0];
    assert!(points.len() < 4 * 2 * 800, "{}", points.len());
    let y = inverse(&numbers(&svg, "end"));
    let highest = points.iter().map(|point| y(point[1])).fold(f64::MIN, f64::max);
    assert!((49.0..51.0).contains(&highest), "{highest}");
}

#[test]
fn gaps_part_a_curve_and_a_lone_point_is_a_dot() {
    let nan = f64::NAN;
    let points =
        vec![[0.0, 1.0], [1.0, 2.0], [2.0, nan], [3.0, f64::INFINITY], [4.0, 1.0], [5.0, nan]];
    let svg = figure(vec![Curve::new("a", points)]).to_svg(SIZE, &Theme::LIGHT);
    assert_eq!(drawn(&svg)[0].iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
    assert!(svg.contains("h0"));
}

#[test]
fn units_that_are_lengths_in_both_directions_have_one_scale() {
    let circle = (0..=90).map(|i| f64::from(i) * 4f64.to_radians());
    let circle = circle.map(|angle| [2.0 + angle.cos(), angle.sin()]).collect();
    let mut figure = figure(vec![Curve::new("path", circle)]);
    figure.panels[0].equal_scale = true;
    let svg = figure.to_svg(SIZE, &Theme::LIGHT);
    let points = &drawn(&svg)[0][0];
    let extent = |axis: usize| {
        let values = || points.iter().map(|point| point[axis]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    assert!((extent(0) / extent(1) - 1.0).abs() < 2e-3, "{} by {}", extent(0), extent(1));
}

#[test]
fn all_texts_lie_inside_and_none_over_another() {
    let curves =
        |n: usize| (0..n).map(|i| Curve::new(&format!("joint_{i}_angle"), wave(9))).collect();
    for n_panels in 1..=6 {
        let panel = |n| {
            Panel::new(Axis::new("Time", "s"), Axis::new("Angular velocity", "rad/s"), curves(n))
        };
        let figure = Figure::new(
            "A mechanism of many parts",
            (0..n_panels).map(|n| panel(2 * n + 1)).collect(),
        );
        let sizes = [figure.natural_size(), Size { width: 420.0, height: 900.0 }];
        for size in sizes {
            let svg = figure.to_svg(size, &Theme::DARK);
            let boxes = text_boxes(&svg);
            assert!(boxes.len() > 5);
            for (idx, (text, own)) in boxes.iter().enumerate() {
                let [left, top, right, bottom] = *own;
                let is_inside =
                    left >= 0.0 && top >= 0.0 && right <= size.width && bottom <= size.height;
                assert!(is_inside, "`{text}` at {own:?} in {size:?} with {n_panels} panels");
                for (other_text, other) in &boxes[..idx] {
                    let apart = right <= other[0]
                        || other[2] <= left
                        || bottom <= other[1]
                        || other[3] <= top;
                    assert!(
                        apart,
                        "`{text}` {own:?} over `{other_text}` {other:?}, {n_panels} panels, {size:?}"
                    );
                }
            }
        }
    }
}

/// Texts with their boxes: left, top, right, bottom.
fn text_boxes(svg: &str) -> Vec<(String, [f64; 4])> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    let covered = |node: roxmltree::Node<'_, '_>| {
        let number = |name: &str| node.attribute(name).and_then(|text| text.parse::<f64>().ok());
        let (length, size) =
            (number("textLength").expect("length"), number("font-size").expect("size"));
        let before = match node.attribute("text-anchor") {
            Some("middle") => 0.5 * length,
            Some("end") => length,
            _ => 0.0,
        };
        let (up, down) = (0.72 * size, 0.2 * size);
        let bounds = if let Some((x, y)) = number("x").zip(number("y")) {
            [x - before, y - up, x - before + length, y + down]
        } else {
            let turned = node.attribute("transform").expect("a position");
            let turned = turned.trim_start_matches("translate(").split([' ', ')']);
            let at: Vec<f64> = turned.take(2).map(|n| n.parse().expect("a number")).collect();
            [at[0] - up, at[1] - before, at[0] + down, at[1] - before + length]
        };
        (node.text().unwrap_or_default().to_owned(), bounds)
    };
    texts.map(covered).collect()
}

#[test]
fn a_png_has_its_pixels_and_its_colours() {
    let figure =
        figure(vec![Curve::new("a", wave(50)), Curve::new("b", vec![[0.0, 1.0], [9.0, -2.0]])]);
    for (theme, background) in [(Theme::LIGHT, [255, 255, 255]), (Theme::DARK, [0x16, 0x19, 0x1d])]
    {
        let size = Size { width: 640.0, height: 400.0 };
        let png = figure.render(Format::Png, Some(size), &theme).expect("a picture");
        let mut reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().expect("PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let frame = reader.next_frame(&mut pixels).expect("pixels");
        assert_eq!((frame.width, frame.height), (640, 400));
        let share = |color: [u8; 3]| {
            let near = |pixel: &&[u8]| pixel.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 12);
            pixels.chunks(frame.line_size / 640).filter(near).count() as f64 / (640.0 * 400.0)
        };
        assert!((0.8..0.99).contains(&share(background)), "{}", share(background));
        for color in theme.palette[..2].iter().map(|color| color.to_be_bytes()) {
            let share = share([color[1], color[2], color[3]]);
            assert!((0.001..0.05).contains(&share), "{share} of {color:?}");
        }
        // The same bytes again.
        assert_eq!(png, figure.render(Format::Png, Some(size), &theme).expect("a picture"));
    }
    let fine = figure.render(Format::Png, None, &Theme::LIGHT).expect("a picture");
    assert_eq!(fine[16..24], [0, 0, 5, 160, 0, 0, 3, 112]);
}

#[test]
fn a_pdf_has_one_page_with_texts() {
    let pdf = figure(vec![Curve::new("a", wave(50))]).render(Format::Pdf, None, &Theme::LIGHT);
    let pdf = pdf.expect("a page");
    assert!(pdf.starts_with(b"%PDF-"));
    let text = String::from_utf8_lossy(&pdf);
    assert!(text.contains("/Type /Page") || text.contains("/Type/Page"), "no page");
    assert!(text.contains("Ubuntu"), "no font");
    assert!(text.contains("540"), "720 px are 540 points");
    assert!(!text.contains("/Subtype /Image"), "an image");
}

#[test]
fn sizes_that_cannot_be_are_refused() {
    let figure = figure(vec![]);
    for (width, height) in [(0.0, 100.0), (1e9, 500.0), (f64::NAN, 500.0), (-5.0, 500.0)] {
        let error = figure.render(Format::Svg, Some(Size { width, height }), &Theme::LIGHT);
        assert!(error.expect_err("refused").to_string().contains("a picture cannot be"));
    }
}

#[test]
fn names_cannot_break_the_document() {
    let name = "</text><script>&\"'\u{1}\u{7}\n";
    let mut figure = figure(vec![Curve::new(name, wave(3)), Curve::new(name, wave(3))]);
    figure.title = name.to_owned();
    figure.panels[0].y.unit = name.to_owned();
    let svg = figure.to_svg(SIZE, &Theme::LIGHT);
    let document = roxmltree::Document::parse(&svg).expect("XML");
    assert!(!document.descendants().any(|node| node.has_tag_name("script")));
    figure.render(Format::Png, Some(SIZE), &Theme::LIGHT).expect("a picture");
}

#[test]
fn text_shows_the_curves_between_their_axes() {
    let curves = vec![
        Curve::new("up", (0..=10).map(|i| [f64::from(i), f64::from(i)]).collect()),
        Curve::new("down", (0..=10).map(|i| [f64::from(i), f64::from(10 - i)]).collect()),
    ];
    let panel = Panel::new(Axis::new("Time", "s"), Axis::new("Position", "m"), curves);
    let figure = Figure::new("two lines", vec![panel]);
    let screen = Screen { width: 44, panel_height: 13, has_colors: false };
    let text = figure.to_text(screen);
    assert_eq!(text, include_str!("two_lines.txt"), "\n{text}");
    let colored = figure.to_text(Screen { has_colors: true, ..screen });
    assert!(colored.contains("\x1b[34m") && colored.contains("\x1b[33m"));
    assert!(colored.ends_with("\x1b[0m\n"), "{colored:?}");
}

#[test]
fn ends_that_are_given_cut_the_curves() {
    let mut figure = figure(vec![Curve::new("a", wave(50))]);
    figure.panels[0].y.range = Some([-1.0, 1.0]);
    let svg = figure.to_svg(SIZE, &Theme::LIGHT);
    let document = roxmltree::Document::parse(&svg).expect("XML");
    let cut = document.descendants().find(|node| node.has_attribute("clip-path")).expect("a cut");
    assert_eq!(cut.descendants().filter(|n| n.attribute("class") == Some("curve")).count(), 1);
    assert!(figure.render(Format::Png, Some(SIZE), &Theme::LIGHT).is_ok());
}

#[test]
fn powers_of_ten_are_raised() {
    let points = (1..=9).map(|i| [f64::from(i), 1e-9 * f64::from(i)]).collect();
    let mut figure = figure(vec![Curve::new("a", points)]);
    figure.panels[0].y.unit = "m/s^2".to_owned();
    let svg = figure.to_svg(SIZE, &Theme::LIGHT);
    roxmltree::Document::parse(&svg).expect("XML");
    let title = "(10<tspan dy=\"-6\" font-size=\"10.5\">−9</tspan><tspan dy=\"6\"> m/s";
    assert!(svg.contains(title), "{svg}");
    figure.render(Format::Png, Some(SIZE), &Theme::LIGHT).expect("a picture");
}

#[test]
fn decades_are_equally_high() {
    let points = (0..=40).map(|i| f64::from(i) * 0.1).map(|t| [t, 10f64.powf(t)]).collect();
    let mut figure = figure(vec![Curve::new("a", points)]);
    figure.panels[0].y.scale = Scale::Logarithmic;
    let svg = figure.to_svg(SIZE, &Theme::LIGHT);
    let points = &drawn(&svg)[0][0];
    // A straight line: all between its ends is dropped.
    assert!(points.len() <= 4, "{points:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: RngSeed::Fixed(1786), ..ProptestConfig::default() })]

    #[test]
    fn any_numbers_make_a_document(
        points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..40),
        log in any::<bool>(),
        equal_scale in any::<bool>(),
        width in 120.0..2000.0_f64,
        height in 120.0..2000.0_f64,
    ) {
        let points = points.into_iter().map(|(x, y)| [x, y]).collect();
        let mut figure = figure(vec![Curve::new("a", points), Curve::new("b", vec![])]);
        figure.panels[0].equal_scale = equal_scale;
        if log {
            figure.panels[0].y.scale = Scale::Logarithmic;
        }
        let svg = figure.to_svg(Size { width, height }, &Theme::LIGHT);
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        for point in drawn(&svg).iter().flatten().flatten() {
            prop_assert!(point[0] >= -1.0 && point[0] <= width + 1.0, "{point:?}");
            prop_assert!(point[1] >= -1.0 && point[1] <= height + 1.0, "{point:?}");
        }
        let screen = Screen { width: 61, panel_height: 12, has_colors: false };
        prop_assert!(figure.to_text(screen).lines().all(|line| line.chars().count() <= 61));
    }
}
