//! Chaining and nesting: what is joined, what is refused, and where.

use super::shapes::{
    Dice, TOLERANCE, arc, bar, line, outline, polygon, rectangle, rounded_rectangle, strokes,
};
use bksim_cad::codes;
use bksim_cad::geometry::{Path, Point};
use bksim_cad::outline::{Outline, OutlineError, chain, doubled, nest};
use std::f64::consts::{PI, TAU};

fn fault(paths: impl IntoIterator<Item = Path>) -> OutlineError {
    Outline::of(&strokes(paths), TOLERANCE).expect_err("a fault")
}

#[test]
fn small_gaps_are_closed_and_listed() {
    let gap = 4e-7;
    let paths = [
        line([0.0, 0.0], [3.0, 0.0]),
        line([3.0, gap], [3.0, 4.0]),
        line([0.0, 0.0], [3.0 - gap, 4.0]),
    ];
    let (outline, snaps) = Outline::of(&strokes(paths), TOLERANCE).expect("a good outline");
    assert_eq!(outline.loops.len(), 1);
    let listed: Vec<[usize; 2]> = snaps.iter().map(|snap| snap.entities).collect();
    assert_eq!(listed, [[0, 1], [1, 2]]);
    for snap in &snaps {
        assert!((snap.distance - gap).abs() < 1e-15, "{snap:?}");
        assert_eq!(snap.diagnostic().code, codes::SNAPPED);
    }
    assert_eq!([snaps[0].from, snaps[0].to], [[3.0, 0.0], [3.0, gap]]);
    assert_eq!(
        snaps[0].diagnostic().message,
        "a gap of 0.0000004 units from (3, 0) to (3, 0.0000004) was closed"
    );
}

#[test]
fn rounding_is_no_gap() {
    let paths = rounded_rectangle([1e3, 2e3], 40.0, 30.0, 7.3);
    let (outline, snaps) = Outline::of(&strokes(paths), TOLERANCE).expect("a good outline");
    assert_eq!((outline.loops.len(), outline.loops[0].path.curves.len(), snaps.len()), (1, 8, 0));
}

#[test]
fn wide_gaps_leave_the_outline_open() {
    let paths =
        [line([0.0, 0.0], [3.0, 0.0]), line([3.0, 1e-3], [3.0, 4.0]), line([0.0, 0.0], [3.0, 4.0])];
    let error = fault(paths);
    assert_eq!(error.code(), codes::OPEN_OUTLINE);
    assert_eq!(error.entities(), [0, 1]);
    let OutlineError::Open { ends } = &error else { panic!("{error:?}") };
    assert_eq!([ends[0].at, ends[1].at], [[3.0, 0.0], [3.0, 1e-3]]);
    assert_eq!(ends[0].gap, Some(1e-3));
    let diagnostic = error.diagnostic();
    assert_eq!(diagnostic.message, "the outline is open at (3, 0), (3, 0.001)");
    assert_eq!(diagnostic.notes, ["the smallest gap between two open ends is 0.001 units"]);

    // Open strokes next to a closed outline are for the caller to judge.
    let paths = [rectangle([0.0, 0.0], 4.0, 2.0), line([-9.0, 0.0], [9.0, 0.0])];
    let chains = chain(&strokes(paths), TOLERANCE).expect("good strokes");
    assert_eq!((chains.closed.len(), chains.open.len()), (1, 1));
}

#[test]
fn three_ends_are_ambiguous() {
    let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let mut paths: Vec<Path> = (0..4).map(|i| line(square[i], square[(i + 1) % 4])).collect();
    paths.push(line([0.0, 0.0], [2.0, 2.0]));
    let error = fault(paths.clone());
    assert_eq!(error.code(), codes::AMBIGUOUS_ENDS);
    assert_eq!(error.entities(), [0, 3, 4]);
    assert!(matches!(error, OutlineError::Ambiguous { at: [0.0, 0.0], .. }), "{error:?}");

    // A line drawn twice.
    paths[4] = paths[2].reversed();
    assert_eq!(fault(paths).code(), codes::AMBIGUOUS_ENDS);
}

#[test]
fn an_arc_may_close_itself_and_specks_are_left_out() {
    let nearly = arc([0.0, 0.0], 1.0, 0.0, TAU - 1e-8);
    let speck = line([1.0, 0.0], [1.0 + 1e-9, 0.0]);
    let (outline, snaps) = Outline::of(&strokes([nearly, speck]), TOLERANCE).expect("an outline");
    assert_eq!((outline.loops.len(), snaps.len()), (1, 1));
    assert_eq!(snaps[0].entities, [0, 0]);
}

#[test]
fn loops_that_cross_are_refused() {
    let square = |x: f64, y: f64| rectangle([x, y], 2.0, 2.0);
    let crossing: Vec<[Path; 2]> = vec![
        [square(0.0, 0.0), square(1.0, 1.0)],
        // Through corners only, with shared edges.
        [square(0.0, 0.0), square(1.0, 0.0)],
        [rectangle([0.0, 0.0], 6.0, 2.0), rectangle([0.0, 0.0], 2.0, 6.0)],
        [square(0.0, 0.0), Path::circle([1.0, 0.0], 0.5)],
        [Path::circle([0.0, 0.0], 1.0), Path::circle([0.5, 0.0], 1.0)],
        [Path::circle([0.0, 0.0], 1.0), bar([0.0, 0.0], 5.0, 0.5)],
        // A corner just through the other side.
        [square(0.0, 0.0), polygon(&[[0.0, 0.0], [1.001, 0.1], [0.0, 0.2]])],
    ];
    for [a, b] in crossing {
        for pair in [[a.clone(), b.clone()], [b.reversed(), a]] {
            let error = fault(pair.clone());
            assert_eq!(error.code(), codes::CROSSING_OUTLINES, "{pair:?}: {error:?}");
        }
    }
    let bow_tie = polygon(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.5]]);
    let error = fault([bow_tie]);
    assert_eq!(error.code(), codes::CROSSING_OUTLINES, "{error:?}");
    let sharp = arc([0.0, 0.0], 1.0, 0.0, PI);
    let through = [sharp, line([-1.0, 0.0], [1.5, 0.5]), line([1.5, 0.5], [1.0, 0.0])];
    assert_eq!(fault(through).code(), codes::CROSSING_OUTLINES);
}

#[test]
fn loops_that_touch_are_told_apart() {
    let square = rectangle([0.0, 0.0], 4.0, 4.0);
    let touching: Vec<(Path, bool)> = vec![
        // Tangent from inside and from outside.
        (Path::circle([1.0, 0.0], 1.0), true),
        (Path::circle([3.0, 0.0], 1.0), false),
        // A shared edge, from either side.
        (rectangle([1.0, 0.0], 2.0, 2.0), true),
        (rectangle([3.0, 0.0], 2.0, 2.0), false),
        (rectangle([3.0, 0.0], 2.0, 4.0), false),
        // A corner.
        (polygon(&[[2.0, 2.0], [0.5, 0.0], [0.0, 0.5]]), true),
        (polygon(&[[2.0, 2.0], [3.5, 3.0], [3.0, 3.5]]), false),
        // Across by less than the tolerance.
        (Path::circle([1.0 + 1e-7, 0.0], 1.0), true),
    ];
    for (path, is_hole) in touching {
        let found = outline(&strokes([square.clone(), path.clone()]));
        assert_eq!(
            found.loops.iter().map(|part| part.is_hole).collect::<Vec<_>>(),
            [false, is_hole]
        );
        let found = outline(&strokes([path, square.clone()]));
        assert_eq!(
            found.loops.iter().map(|part| part.is_hole).collect::<Vec<_>>(),
            [is_hole, false]
        );
    }
}

#[test]
fn loops_on_each_other_are_refused() {
    let circle = || Path::circle([1.0, 1.0], 2.0);
    assert_eq!(fault([circle(), circle().reversed()]).code(), codes::DOUBLE_OUTLINE);
    let turned = polygon(&[[2.0, 2.0], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0]]);
    let error = fault([rectangle([1.0, 1.0], 2.0, 2.0), Path::circle([1.0, 1.0], 0.5), turned]);
    assert_eq!(error.code(), codes::DOUBLE_OUTLINE);
    assert_eq!(error.entities(), [0, 2]);
}

#[test]
fn outlines_without_area_are_refused() {
    assert_eq!(fault([]).code(), codes::NO_AREA);
    let there_and_back = polygon(&[[0.0, 0.0], [2.0, 2.0], [5.0, 5.0]]);
    assert_eq!(fault([there_and_back]).code(), codes::NO_AREA);
}

#[test]
fn many_holes_and_deep_nests() {
    // A perforated plate of 2500 holes, the plate drawn last.
    let mut paths: Vec<Path> =
        (0..2500).map(|i| Path::circle([f64::from(i % 50), f64::from(i / 50)], 0.4)).collect();
    paths.push(rectangle([24.5, 24.5], 60.0, 60.0));
    let plate = outline(&strokes(paths));
    assert_eq!(plate.loops.iter().filter(|part| part.is_hole).count(), 2500);

    let rings: Vec<Path> = (1..400).map(|i| Path::circle([0.0, 0.0], f64::from(i))).collect();
    let target = outline(&strokes(rings));
    for (i, part) in target.loops.iter().enumerate() {
        // The outermost is the last.
        assert_eq!(part.is_hole, (398 - i) % 2 == 1);
    }
}

#[test]
fn a_hundred_thousand_lines_chain() {
    const N: u32 = 100_000;
    // Teeth of a wheel, every line its own entity, shuffled and turned.
    let corner = |i: u32| -> Point {
        let u = TAU * f64::from(i % N) / f64::from(N);
        let r = if i.is_multiple_of(2) { 100.0 } else { 100.001 };
        [r * u.cos(), r * u.sin()]
    };
    let mut dice = Dice(1);
    let mut paths: Vec<Path> = (0..N)
        .map(|i| line(corner(i), corner(i + 1)))
        .map(|path| if dice.roll() < 0.5 { path.reversed() } else { path })
        .collect();
    dice.shuffle(&mut paths);
    let (wheel, snaps) = Outline::of(&strokes(paths), 1e-7).expect("a good outline");
    assert_eq!((wheel.loops.len(), snaps.len()), (1, 0));
    assert_eq!(wheel.loops[0].entities.len(), N as usize);

    // And as many open ends on one line, all reported.
    let comb = (0..50_000).map(|i| line([0.0, f64::from(i)], [1.0, f64::from(i)]));
    let chains = chain(&strokes(comb), 1e-7).expect("good strokes");
    assert_eq!(chains.open.len(), 50_000);
    let Some(OutlineError::Open { ends }) = chains.open_error() else { panic!("open chains") };
    assert_eq!(ends.len(), 100_000);
    assert!(nest(&chains.closed, 1e-7).is_err());
}

/// Lines in all directions, each with its copy, turned round, or the middle of it; every third is beyond the tolerance.
#[test]
fn lines_on_lines_are_found_among_many_that_cross() {
    let mut dice = Dice(11);
    let mut next = || 1000.0 * dice.roll() - 500.0;
    let mut paths = Vec::new();
    for k in 0_u16..600 {
        // Along the axes too, where the angle is 0 or π.
        let [a, b] = match k % 4 {
            0 => [[next(), 0.1 * f64::from(k)], [next(), 0.1 * f64::from(k)]],
            1 => [[0.1 * f64::from(k), next()], [0.1 * f64::from(k), next()]],
            _ => [[next(), next()], [next(), next()]],
        };
        let off = [0.0, 0.5, 3.0][usize::from(k % 3)] * TOLERANCE;
        let at = |t: f64| [a[0] + t * (b[0] - a[0]) + off, a[1] + t * (b[1] - a[1]) - off];
        paths.push(line(a, b));
        paths.push(if k % 2 == 0 { line(at(1.0), at(0.0)) } else { line(at(0.25), at(0.5)) });
    }
    let is_on = |copy: usize, kept: usize| {
        let ends = [paths[copy].start_point(), paths[copy].end_point()].into_iter().flatten();
        ends.map(|end| paths[kept].distance(end)).fold(0.0, f64::max) <= TOLERANCE
    };
    let expected: Vec<[usize; 2]> =
        (0..600).map(|k| [2 * k, 2 * k + 1]).filter(|&[kept, copy]| is_on(copy, kept)).collect();
    assert!(expected.len() > 350, "{}", expected.len());
    let found = doubled(&strokes(paths.clone()), TOLERANCE);
    let found: Vec<[usize; 2]> = found.iter().map(|it| [it.kept, it.copy]).collect();
    assert_eq!(found, expected);
}
