//! Starts that are hard to find, turns of angles, and what is said of starts that there are none of.

use std::f64::consts::TAU;

use crate::support::{Within, close, coordinate, derive, model, solve};

use bksim::Mechanism;
use bksim::model::diagnostic::Diagnostic;
use bksim::sim::fault::{diagnose_guesses, diagnose_turns};
use bksim::sim::start::Start;

/// A four-bar of these lengths, with what follows its joints.
fn four_bar([a, b, c, d]: [f64; 4], rest: &str) -> String {
    format!(
        r#"
        [ground]
        points = {{ A = [0, 0], D = [{d}, 0] }}
        [bodies]
        crank = {{ mass = 1, points = {{ A = [0, 0], B = [{a}, 0] }} }}
        coupler = {{ mass = 1, inertia = 0.01, points = {{ B = [0, 0], C = [{b}, 0] }} }}
        rocker = {{ mass = 1, inertia = 0.01, points = {{ D = [0, 0], C = [{c}, 0] }} }}
        [joints]
        A = {{ type = "revolute", between = ["ground.A", "crank.A"] }}
        B = {{ type = "revolute", between = ["crank.B", "coupler.B"] }}
        C = {{ type = "revolute", between = ["coupler.C", "rocker.C"] }}
        D = {{ type = "revolute", between = ["ground.D", "rocker.D"] }}
        {rest}
        "#
    )
}

/// A crank, a rod as a body or as a link, and a ram.
fn slider_crank(rod: f64, as_link: bool, initial: &str) -> String {
    let joint = if as_link {
        format!(r#"rod = {{ type = "link", between = ["crank.B", "ram"], length = {rod} }}"#)
    } else {
        r#"B = { type = "revolute", between = ["crank.B", "rod.B"] }
           C = { type = "revolute", between = ["rod.C", "ram"] }"#
            .to_owned()
    };
    let body =
        format!("rod = {{ mass = 1, inertia = 0.01, points = {{ B = [0, 0], C = [{rod}, 0] }} }}");
    let body = if as_link { "" } else { &body };
    format!(
        r#"
        [bodies]
        crank = {{ mass = 1, inertia = 0.01, points = {{ A = [0, 0], B = [0.2, 0] }} }}
        ram = {{ mass = 1 }}
        {body}
        [joints]
        A = {{ type = "revolute", between = ["ground", "crank.A"] }}
        guide = {{ type = "prismatic", between = ["ground", "ram"], axis = [1, 0] }}
        {joint}
        [initial]
        {initial}
        "#
    )
}

fn start(text: &str) -> Result<(Mechanism, Start), Diagnostic> {
    let mechanism = Mechanism::from_toml(text, "start").expect("a sound model");
    match mechanism.start() {
        Ok(start) => Ok((mechanism, start)),
        Err(rejected) => Err(rejected.0.into_iter().next().expect("a fault")),
    }
}

/// Code and message, then notes and help.
fn said(fault: &Diagnostic) -> String {
    let mut lines = vec![format!("{}: {}", fault.code.0, fault.message)];
    lines.extend(fault.notes.iter().cloned());
    lines.extend(fault.help.iter().cloned());
    lines.join("\n")
}

fn fault(text: &str) -> String {
    said(&start(text).expect_err("no start"))
}

#[track_caller]
fn assert_says(said: &str, words: &[&str]) {
    for words in words {
        assert!(said.contains(words), "`{words}` is not in:\n{said}");
    }
}

/// A value as `[initial]` has it, and as the start has it.
fn found(start: &Start, name: &str) -> (f64, f64) {
    let moved = start.moved.iter().find(|m| m.name == name).expect("an initial value");
    (moved.stated, moved.found)
}

#[test]
fn four_bars_leave_the_pose_in_which_all_links_are_in_line() {
    let lengths: [f64; 4] = [0.1, 0.2, 0.3, 0.35];
    let mut n = 0;
    for k in 0..256_usize {
        let links = [k % 4, k / 4 % 4, k / 16 % 4, k / 64].map(|i| lengths[i]);
        for degrees in [0.0, 180.0] {
            let [a, b, c, d] = links;
            let apart = if degrees == 0.0 { (d - a).abs() } else { d + a };
            // Those that close, dead centres aside.
            if !((b - c).abs() + 1e-6..b + c - 1e-6).contains(&apart) {
                continue;
            }
            n += 1;
            let text = four_bar(links, &format!("[initial]\nA = {{ angle = \"{degrees} deg\" }}"));
            let (_, start) = start(&text).unwrap_or_else(|f| panic!("{links:?}: {}", said(&f)));
            assert!(start.position_residual < 1e-12, "{links:?} at {degrees}°");
        }
    }
    assert!(n > 81, "{n} four-bars");
}

#[test]
fn slider_cranks_start_with_the_crank_across() {
    for (as_link, degrees) in [(false, 90), (false, -90), (true, 90), (true, -90)] {
        let text = slider_crank(0.4, as_link, &format!("A = {{ angle = \"{degrees} deg\" }}"));
        let (_, start) = start(&text).unwrap_or_else(|f| panic!("{degrees}°: {}", said(&f)));
        let reach = start.q[1].abs() - f64::sqrt(0.4 * 0.4 - 0.2 * 0.2);
        assert!(reach.abs() < 1e-12, "{:?} at {degrees}°", start.q);
    }
}

#[test]
fn a_link_opens_where_its_ends_are_guessed_together() {
    let initial = "A = { angle = 0 }\nguide = { guess = { position = 0.2 } }";
    let (_, start) = start(&slider_crank(0.3, true, initial)).expect("it closes");
    let ends = (start.q[1] - 0.2).abs();
    assert!((ends - 0.3).abs() < 1e-12, "{:?}", start.q);
}

#[test]
fn angles_keep_the_turn_that_they_were_written_with() {
    const LINKS: [f64; 4] = [0.1, 0.3, 0.25, 0.3];
    let at = |initial: &str| {
        let (_, start) =
            start(&four_bar(LINKS, &format!("[initial]\n{initial}"))).expect("it closes");
        start
    };
    let plain =
        at("A = { angle = 1 }\nD = { guess = { angle = 1.5 } }\nC = { guess = { angle = 1 } }");
    let [d, c] = ["D.angle", "C.angle"].map(|name| found(&plain, name).1);
    for n in [-1.0, 1.0, 2.0] {
        // A coordinate that is stated, one that is guessed, and a sum of coordinates.
        let start = at(&format!(
            "A = {{ angle = {} }}\nD = {{ guess = {{ angle = {} }} }}\nC = {{ angle = {} }}",
            1.0 + n * TAU,
            d - n * TAU,
            c + 3.0 * n * TAU
        ));
        for name in ["A.angle", "D.angle", "C.angle"] {
            let (written, found) = found(&start, name);
            assert!((found - written).abs() < 1e-9, "{name}: {found} for {written}");
        }
        assert_eq!(start.q[0], 1.0 + n * TAU, "what is stated holds to the last digit");
    }
}

#[test]
fn a_link_that_is_too_short_is_named_with_the_length_it_needs() {
    let said = fault(&four_bar([0.1, 0.2, 0.2, 0.9], ""));
    assert_says(
        &said,
        &[
            "S001: the loop of joints",
            "cannot close: the smallest gap is 0.4 m between",
            "`ground` is 0.9 m between its joints, all other links together 0.5 m",
            "make `ground` shorter than 0.5 m",
        ],
    );
}

#[test]
fn a_link_joint_says_how_far_its_ends_are_from_its_length() {
    // 0.4 m above the line of the guide, and two ends that reach 0.3 m.
    let text = slider_crank(0.1, true, "")
        .replace(r#"between = ["ground", "ram"], axis"#, r#"between = ["ground.G", "ram"], axis"#);
    let said = fault(&format!("[ground]\npoints = {{ G = [0, 0.4] }}\n{text}"));
    assert_says(&said, &["S001", "0.1 m", "0.4 m from the next joint", "together are 0.3 m"]);
}

#[test]
fn a_drive_out_of_reach_is_named_with_what_it_can_reach() {
    let drive = "[drives.motor]\njoint = \"guide\"\nmotion = \"0.7 m - 0.1 m/s*t\"";
    let said = fault(&format!("{}{drive}", slider_crank(0.3, true, "")));
    assert_says(
        &said,
        &[
            "S016: drive `motor` starts out of reach: it puts `guide` at 0.7 m",
            "the nearest position where the mechanism was found to close is 0.5 m",
            "`ground` and `ram` are 0.7 m apart there, beyond the reach of",
            "0.5 m",
        ],
    );
}

#[test]
fn a_ram_that_leaves_its_reach_stops_the_run_at_its_dead_centre() {
    let text = r#"
        [ground]
        points = { O = [0, 0], P = [1, 0] }
        [bodies]
        arm = { mass = 10, inertia = 1, points = { O = [0, 0], C = [0.5, 0] } }
        barrel = { mass = 0 }
        rod = { mass = 0 }
        [joints]
        O = { type = "revolute", between = ["ground.O", "arm.O"] }
        foot = { type = "revolute", between = ["ground.P", "barrel"] }
        cyl = { type = "prismatic", between = ["barrel", "rod"], axis = [1, 0] }
        eye = { type = "revolute", between = ["rod", "arm.C"] }
        [drives.cyl]
        joint = "cyl"
        motion = "0.9 m - 0.4 m/s*t"
        [initial]
        O = { guess = { angle = "60 deg" } }
        [solve]
        t_end = "2 s"
        "#;
    let rejected = Mechanism::from_toml(text, "ram").expect("a model").solve().expect_err("stops");
    assert_says(
        &said(&rejected.0[0]),
        &[
            "R001: drive `cyl` cannot pass cyl = about 0.5 m at t = 1 s",
            "`barrel` and `rod` are 0.5 m apart there; the reach of",
            "is from 0.5 m to 1.5 m",
        ],
    );
}

#[test]
fn stated_values_that_exclude_each_other_do_not_name_themselves_as_the_cure() {
    let initial = "A = { angle = \"90 deg\" }\nguide = { position = 0.3 }";
    let said = fault(&slider_crank(0.3, true, initial));
    assert_says(
        &said,
        &[
            "S002: the stated positions of `A.angle` and `guide.position` exclude each other",
            "`guide.position` would be 0.223607 m",
            "beyond the reach of `rod`: 0.3 m",
        ],
    );
}

#[test]
fn axes_that_miss_being_parallel_are_named_with_their_angle() {
    let text = r#"
        space = "spatial"
        [ground]
        points = { A = [0, 0, 0], D = [0.3, 0, 0] }
        [bodies]
        crank = { mass = 1, inertia = [0.01, 0.01, 0.01], points = { A = [0, 0, 0], B = [0.1, 0, 0] } }
        coupler = { mass = 1, inertia = [0.01, 0.01, 0.01], points = { B = [0, 0, 0], C = [0.3, 0, 0] } }
        rocker = { mass = 1, inertia = [0.01, 0.01, 0.01], points = { D = [0, 0, 0], C = [0.25, 0, 0] } }
        [joints]
        A = { type = "revolute", between = ["ground.A", "crank.A"], axis = [0, 0, 1] }
        B = { type = "revolute", between = ["crank.B", "coupler.B"], axis = [0, 0, 1] }
        C = { type = "revolute", between = ["coupler.C", "rocker.C"], axis = [0, "sin(2 deg)", "cos(2 deg)"] }
        D = { type = "revolute", between = ["ground.D", "rocker.D"], axis = [0, 0, 1] }
        [initial]
        A = { guess = { angle = "60 deg" } }
        "#;
    let said = fault(text);
    assert_says(&said, &["S001: no position was found that closes the loop of joints", "2° apart"]);
}

#[test]
fn a_guess_that_was_moved_far_is_a_warning_with_both_values() {
    const LINKS: [f64; 4] = [0.1, 0.3, 0.25, 0.3];
    let warnings = |guess: &str| {
        let rest = format!(
            "[initial]\nA = {{ angle = \"60 deg\" }}\nD = {{ guess = {{ angle = \"{guess}\" }} }}"
        );
        let (mechanism, start) = start(&four_bar(LINKS, &rest)).expect("it closes");
        diagnose_guesses(&mechanism.model, &mechanism.system, &start)
            .iter()
            .map(said)
            .collect::<Vec<_>>()
    };
    let far = warnings("200 deg");
    assert_eq!(far.len(), 1, "{far:?}");
    assert_says(
        &far[0],
        &["S014: the guess `D.angle` = 3.49066 rad (200°) was moved by", "(232.154°)"],
    );
    assert!(warnings("230 deg").is_empty());
    // Between 89.6° and 232.2°.
    let between = warnings("160 deg").join("\n");
    assert_says(&between, &["S014", "S015: another assembly is nearly as near to the guesses"]);
}

/// With the crank in line with the ground the two assemblies mirror each other; without a guess neither is
/// nearer, and the guess that the help gives settles it.
#[test]
fn mirror_images_are_a_warning_that_a_guess_settles() {
    const LINKS: [f64; 4] = [0.1, 0.3, 0.25, 0.3];
    let warnings = |initial: &str| {
        let (mechanism, start) = start(&four_bar(LINKS, initial)).expect("it closes");
        let diagnosed = diagnose_guesses(&mechanism.model, &mechanism.system, &start);
        diagnosed.iter().map(said).collect::<Vec<_>>()
    };
    for crank in ["0 deg", "180 deg"] {
        let stated = format!("[initial]\nA = {{ angle = \"{crank}\" }}\n");
        let found = warnings(&stated);
        assert_eq!(found.len(), 1, "{crank}: {found:?}");
        assert_says(&found[0], &["S015: the joints close in two ways", "could be", "guess one"]);
        let (_, example) = found[0].split_once("for example `").expect("an example");
        let (example, _) = example.split_once('`').expect("its end");
        assert!(warnings(&(stated + example)).is_empty(), "{example}");
    }
    assert!(warnings("[initial]\nA = { angle = \"60 deg\" }\n").is_empty());
}

/// The rod of a slider-crank in its dead centre hangs at −180° from the crank, which is 180°.
#[test]
fn a_whole_turn_is_no_mirror_image() {
    let text = "[bodies.crank]\nmass = \"1 kg\"\npoints = { B = [\"60 mm\", 0] }\n\
                [bodies.rod]\nmass = \"1 kg\"\npoints = { C = [\"400 mm\", 0] }\n\
                [bodies.ram]\nmass = \"1 kg\"\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"rod\"] }\n\
                C = { type = \"revolute\", between = [\"rod.C\", \"ram\"] }\n\
                guide = { type = \"prismatic\", between = [\"ground\", \"ram\"], axis = [0, -1] }\n\
                [initial]\nA = { angle = \"90 deg\" }\nguide = { position = \"340 mm\" }\n";
    let (mechanism, start) = start(text).expect("it closes");
    let diagnosed = diagnose_guesses(&mechanism.model, &mechanism.system, &start);
    assert!(diagnosed.is_empty(), "{diagnosed:?}");
}

/// Rates that follow from one another, one and the same for all sizes of the parts.
#[test]
fn a_crank_with_a_gear_and_a_screw_starts_at_its_stated_rate() {
    for (first, second, lead) in [(0.098_148_39, 0.122_872_207, 0.0098), (0.1, 0.05, 0.01)] {
        let text = format!(
            "[ground]\npoints = {{ W = [{}, 0] }}\n[bodies]\ncrank = {{ mass = 3, inertia = 0.1 }}\n\
             wheel = {{ mass = 2, inertia = 0.03 }}\nbob = {{ mass = 2, inertia = 1, free = true }}\n\
             nut = {{ mass = 2 }}\n[joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
             W = {{ type = \"revolute\", between = [\"ground.W\", \"wheel\"] }}\n\
             Z = {{ type = \"prismatic\", between = [\"ground\", \"nut\"], axis = [0, 1] }}\n[couplings]\n\
             gear = {{ type = \"gear\", between = [\"A\", \"W\"], radii = [{first}, {second}] }}\n\
             screw = {{ type = \"screw\", between = [\"A\", \"Z\"], lead = {lead} }}\n[initial]\n\
             A = {{ angle = 1, rate = -0.67 }}\n",
            first + second
        );
        let (mechanism, start) = start(&text).unwrap_or_else(|fault| panic!("{}", said(&fault)));
        let rates = [-0.67, 0.67 * first / second, -0.67 * lead / TAU];
        for (name, expected) in ["A_angle", "W_angle", "Z_position"].into_iter().zip(rates) {
            let rate = start.v[coordinate(&mechanism, name)];
            assert!((rate - expected).abs() < 1e-14, "{name}: {rate} is not {expected}");
        }
    }
}

#[test]
fn angles_of_cut_joints_in_space_are_stated_within_half_a_turn_and_loads_by_them_are_warned_of() {
    // The linkage that the page of the warning shows.
    let page = include_str!("../../docs/diagnostics/S025.md");
    let (_, block) = page.split_once("```toml linkage.toml\n").expect("a model");
    let (text, _) = block.split_once("```").expect("its end");
    let stated = |angle: &str| {
        let guess = r#"pivot = { guess = { angle = "-90 deg" } }"#;
        assert!(text.contains(guess));
        text.replace(guess, &format!("pivot = {{ angle = \"{angle}\" }}"))
    };
    let (mechanism, _) = start(&stated("-90 deg")).expect("a start");
    let warnings = |mechanism: &Mechanism| diagnose_turns(&mechanism.model, &mechanism.system);
    let found = warnings(&mechanism);
    let [warning] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(warning.code.0, "S025");
    assert_eq!(warning.message, "load `return` goes by `pivot.angle`, which jumps at ±180 deg");
    for (angle, within) in [("270 deg", "-90"), ("-450 deg", "-90"), ("990 deg", "-90")] {
        let fault = start(&stated(angle)).expect_err("beyond half a turn");
        assert_eq!(fault.code.0, "S002", "{fault:#?}");
        let help = format!("write `angle = \"{within} deg\"`, which is the same position");
        assert_eq!(fault.help.as_deref(), Some(help.as_str()));
    }
    // A coordinate counts its turns.
    let (mechanism, found) = start(&stated("270 deg").replace("cut = true", "")).expect("a start");
    assert!(warnings(&mechanism).is_empty());
    let coordinates = mechanism.system.coordinates();
    let pivot = coordinates.iter().position(|c| c.name == "pivot_angle").expect("a coordinate");
    assert!((found.q[pivot] - 0.75 * TAU).abs() < 1e-12);
}

/// Friction that slides at the start: on a slope, in a pin, and under a box.
#[test]
fn multipliers_of_a_start_are_those_of_its_first_sample() {
    let gravity =
        "[loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n[solve]\nt_end = 0.01\n";
    let slope = "[bodies.b]\nmass = 3\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\n\
                 axis = [\"cos(20 deg)\", \"sin(20 deg)\"]\n\
                 [loads.f]\ntype = \"friction\"\njoint = \"S\"\nmu = 0.3\n[initial]\nS = { velocity = 2 }\n";
    let pin = "[bodies.b]\nmass = 2\ninertia = 0.1\ncom = [0.3, 0]\n\
               [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\n\
               [loads.f]\ntype = \"friction\"\njoint = \"A\"\nmu = 0.1\nradius = 0.01\n[initial]\nA = { rate = 3 }\n";
    let case = "[ground]\npoints = { A = [-5, 0], B = [5, 0] }\n\
                [bodies.b]\nmass = 3\ninertia = 0.1\nfree = true\npoints = { a = [-0.2, -0.1], b = [0.2, -0.1], c = [0, 0.1] }\n\
                [contacts.floor]\nbetween = [{ line = [\"ground.A\", \"ground.B\"] }, { outline = [\"b.a\", \"b.b\", \"b.c\"] }]\nmu = 0.25\n\
                [initial]\nb = { x = 0, y = 0.1, vx = 1 }\n";
    let weight = 3.0 * 9.81;
    let on_slope = -0.3 * weight * 20f64.to_radians().cos();
    // The force of the pin follows from its friction, which follows from it.
    let cases = [(slope, Some(on_slope)), (pin, None), (case, Some(-0.25 * weight))];
    for (text, expected) in cases {
        let mechanism = derive(model(&format!("{text}{gravity}")));
        let motion = solve(&mechanism);
        let found = motion.start.sampled_multipliers(&mechanism.compiled, &mechanism.parameters);
        assert_eq!(found, motion.samples[0].lambda, "{text}");
        let friction = found.last().copied().expect("a multiplier");
        assert!(friction < -1e-3, "it acts against the motion: {friction}\n{text}");
        let expected = expected.unwrap_or(friction);
        close("friction", friction, expected, Within { relative: 1e-12, absolute: 0.0 });
    }
}

/// A condition on a rate that is zero and stays so is as written; one that the motion makes true at once holds.
#[test]
fn conditions_on_rates_at_rest() {
    let cases = [
        ("if(S.velocity > 0, 10, 0)", 0.0),
        ("if(S.velocity >= 0, 10, 0)", 10.0),
        ("if(S.velocity < 0, -10, 0)", 0.0),
        ("if(S.velocity <= 0, -10, 0)", -10.0),
        ("if(0 < S.velocity, 10, 0)", 0.0),
        ("if(S.velocity > 0, 5, -5)", -5.0),
        ("if(S.velocity > 0, 10, 1)", 10.0),
        ("if(S.velocity < 0, -10, 1)", 1.0),
        ("if(b.vx > 0 and S.position < 1, 10, 0)", 0.0),
        ("if(t > 0, 10, 0)", 10.0),
        // Each of two conditions on one rate is as it is written.
        ("if(S.velocity < 0, 1, 0) + if(S.velocity > 0, 1, 0)", 0.0),
        ("if(S.velocity >= 0, 2, 0) + if(S.velocity > 0, 1, 0) - 2", 0.0),
        ("if(S.velocity > 0, 1, 0) + if(S.velocity >= 0, 2, 0) - 2", 0.0),
    ];
    for (force, expected) in cases {
        let text = format!(
            "[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n\
             [loads.f]\ntype = \"force\"\non = \"b\"\nvector = [\"{force}\", 0]\n[solve]\nt_end = 0.1\n"
        );
        let mechanism = derive(model(&text));
        let start = mechanism.start().expect("a start");
        close(force, start.a[0], expected, Within { relative: 1e-12, absolute: 1e-12 });
        if expected == 0.0 {
            let end = solve(&mechanism).samples.last().expect("a sample").q[0];
            close("stays", end, 0.0, Within { relative: 0.0, absolute: 1e-12 });
        }
    }
}
