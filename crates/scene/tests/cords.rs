//! Ropes and belts are laid around what they go over where that is now.

use std::f64::consts::TAU;

use bksim_scene::{Attached, Cord, CordPlace};
use bksim_sim::pose::Pose;

/// A string from a point over a post of radius 0.1 at the origin to a weight.
fn string() -> Cord {
    let place = |body: usize, position: [f64; 3], radius: f64| CordPlace {
        at: Attached { body, position },
        radius,
        leaves: radius != 0.0,
        first: None,
    };
    let places =
        vec![place(0, [-1.0, -0.1, 0.0], 0.0), place(0, [0.0; 3], 0.1), place(1, [0.0; 3], 0.0)];
    Cord { name: "string".into(), places, is_closed: false }
}

fn poses(weight: [f64; 2]) -> [Pose; 2] {
    let [x, y] = weight;
    [Pose::default(), Pose { origin: [x, y, 0.0], ..Pose::default() }]
}

fn length(line: &[[f64; 3]]) -> f64 {
    line.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum()
}

#[test]
fn a_string_is_bent_around_a_post_until_it_leaves_it() {
    // Up beside the post at x = 0.1: a quarter turn about it between 1 m and 2 m.
    let string = string();
    let bent = string.line(&poses([0.1, 2.0])).expect("a way");
    let quarter = 0.1 * TAU / 4.0;
    assert!((length(&bent) - (3.0 + quarter)).abs() < 1e-4, "{}", length(&bent));
    // Below the line along which it comes it has left the post.
    let straight = string.line(&poses([2.0, -0.5])).expect("a way");
    assert_eq!(straight, [[-1.0, -0.1, 0.0], [2.0, -0.5, 0.0]]);
}

#[test]
fn a_string_is_wound_around_a_post_by_more_than_half_a_turn() {
    let mut string = string();
    string.begin(&poses([0.1, 2.0]));
    // On around it, by 260 degrees in all, and 2 m to the weight.
    let turn = 260_f64.to_radians();
    let (sin, cos) = turn.sin_cos();
    let wound = string.line(&poses([0.1 * sin + 2.0 * cos, -0.1 * cos + 2.0 * sin]));
    let found = length(&wound.expect("a way"));
    assert!((found - (3.0 + 0.1 * turn)).abs() < 2e-4, "{found}");
}

#[test]
fn a_belt_is_closed_and_follows_its_wheels() {
    let wheel = |body: usize, radius: f64| CordPlace {
        at: Attached { body, position: [0.0; 3] },
        radius,
        leaves: false,
        first: None,
    };
    let mut belt =
        Cord { name: "belt".into(), places: vec![wheel(0, 0.1), wheel(1, 0.1)], is_closed: true };
    belt.begin(&poses([1.0, 0.0]));
    for distance in [1.0, 1.5] {
        let line = belt.line(&poses([0.0, distance])).expect("a way");
        assert_eq!(line.first(), line.last());
        let expected = 2.0 * distance + 0.1 * TAU;
        assert!((length(&line) - expected).abs() < 4e-4, "{}", length(&line));
    }
}
