//! `bksim equations` in every format: what is written can be typeset, fits, and says the same.

use std::path::PathBuf;

use crate::common::{CRATE, Scratch, text};
use bksim::expr::{Expr, Pool, SymbolId};
use serde_json::Value;

fn examples() -> Vec<PathBuf> {
    let folder = PathBuf::from(CRATE).join("../../examples");
    let mut models: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("examples")
        .map(|entry| entry.expect("an entry").path().join("model.toml"))
        .filter(|model| model.is_file())
        .collect();
    models.sort();
    assert!(models.len() >= 6, "{models:?}");
    models
}

/// Output of `bksim equations MODEL …`.
fn printed(model: &std::path::Path, arguments: &str) -> String {
    let output = Scratch::new()
        .bksim()
        .arg("equations")
        .arg(model)
        .args(arguments.split_whitespace())
        .output()
        .expect("bksim starts");
    assert!(output.status.success(), "{}: {}", model.display(), text(&output.stderr));
    text(&output.stdout)
}

fn balance(source: &str, open: char, close: char) -> i64 {
    source.chars().map(|c| i64::from(c == open) - i64::from(c == close)).sum()
}

#[test]
fn documents_are_well_formed() {
    for model in examples() {
        let latex = printed(&model, "--format latex --document").replace(r"\{", "");
        assert_eq!(balance(&latex, '{', '}'), 0, "{latex}");
        for word in ["longtable", "align*", "cases", "document"] {
            let n = |what: &str| latex.matches(&format!(r"\{what}{{{word}}}")).count();
            assert_eq!(n("begin"), n("end"), "{word} in {latex}");
        }
        let html = printed(&model, "--format mathml --document");
        let html = html.strip_prefix("<!DOCTYPE html>").expect("a page of HTML");
        let page = roxmltree::Document::parse(html).unwrap_or_else(|e| panic!("{e}: {html}"));
        let n_math = page.descendants().filter(|node| {
            node.tag_name().name() == "math"
                && node.tag_name().namespace() == Some("http://www.w3.org/1998/Math/MathML")
        });
        assert!(n_math.count() > 5, "{html}");
        // Letters and digits stand in elements of their own, never loose in a row.
        let loose = page.descendants().filter(|node| {
            let parent = node.parent().map(|parent| parent.tag_name().name().to_owned());
            node.is_text()
                && !node.text().unwrap_or_default().trim().is_empty()
                && parent
                    .is_some_and(|name| ["mrow", "mtd", "math", "msup"].contains(&name.as_str()))
        });
        let loose: Vec<_> = loose.filter_map(|node| node.text()).collect();
        assert!(loose.is_empty(), "{loose:?}");
        let typst = printed(&model, "--format typst --document");
        assert_eq!(typst.matches('$').count() % 2, 0, "{typst}");
        let plain = printed(&model, "--document");
        // Bodies that only touch have no joints.
        let text = std::fs::read_to_string(&model).expect("a model");
        let has_joints = text.contains("joints");
        let titles = ["bodies", "coordinates", "equations of motion", "certificate"];
        for title in titles.into_iter().chain(has_joints.then_some("joints")) {
            assert!(plain.lines().any(|line| line == title), "no `{title}` in {plain}");
        }
    }
}

#[test]
fn letters_of_the_model_are_not_those_of_the_energies() {
    let scratch = Scratch::new();
    let model = r#"
        [parameters]
        T = "1 m"
        V = "1 kg"
        L = "2 m"
        g = "9.81 m/s^2"
        [bodies.rod]
        mass = "V"
        com = ["L/2", 0]
        inertia = "V*L^2/12"
        [joints.A]
        type = "revolute"
        between = ["ground", "rod"]
        [joints.B]
        type = "link"
        between = ["ground.B", "rod"]
        length = "T"
        [ground]
        points = { B = ["T", 0] }
        [loads.gravity]
        type = "gravity"
        acceleration = [0, "-g"]
    "#;
    scratch.write("letters.toml", model);
    let path = scratch.path().join("letters.toml");
    let text = printed(&path, "--steps");
    for name in
        ["T_total = ", "V_total = ", "L_total = ", "d/dt ∂L_total/∂A_angle_dot", "∂g_k/∂A_angle"]
    {
        assert!(text.contains(name), "no {name} in {text}");
    }
    assert!(!text.contains(" T = ") && !text.contains(" V = "), "{text}");
    assert!(printed(&path, "--steps --format latex").contains(r"{\partial L_{\mathrm{total}}}"));
}

#[test]
fn aligned_lines_keep_to_the_width() {
    // Calls with several arguments do not break, nor do quotients and products with long names, as the quick return,
    // the eccentric press, the engine, the Geneva wheel and mechanisms in space have them.
    let long = [
        "quick-return",
        "eccentric-press",
        "engine",
        "geneva",
        "cardan-shaft",
        "double-wishbone",
        "robot-arm",
        "spatial-four-bar",
        "stewart-platform",
        "flexible-arm",
        "billiards",
    ];
    let breaks = |model: &PathBuf| !long.iter().any(|name| model.to_string_lossy().contains(name));
    for model in examples().into_iter().filter(breaks) {
        for arguments in ["--width 100", "--width 100 --unicode", "--width 140 --groups off"] {
            let lines = printed(&model, &format!("--format aligned {arguments}"));
            let limit = if arguments.contains("140") { 140 } else { 100 };
            let is_formula = |line: &&str| line.starts_with("  ") && !line.contains(" random ");
            // The laws of contacts are a table, whose formulas stand in columns.
            let sections = lines.split("\n\n").filter(|section| !section.starts_with("contacts"));
            for line in sections.flat_map(str::lines).filter(is_formula) {
                let width = line.chars().filter(|c| !['\u{307}', '\u{308}'].contains(c)).count();
                assert!(width <= limit, "{width} characters: {line}");
            }
        }
    }
}

/// Formulas of a JSON object in a pool of their own.
struct Formulas {
    all: Vec<Expr>,
}

impl Formulas {
    fn of(pool: &Pool, object: &Value, names: &[(SymbolId, Expr)]) -> Self {
        let parse = |text: &Value| {
            let text = text.as_str().expect("a formula");
            pool.substitute(pool.parse(text).unwrap_or_else(|e| panic!("{e}: {text}")), names)
        };
        let list = |key: &str| object[key].as_array().expect("a list").iter().map(parse);
        let all = [parse(&object["kinetic_energy"]), parse(&object["potential_energy"])];
        Self { all: all.into_iter().chain(list("equations")).chain(list("constraints")).collect() }
    }
}

/// Makes the tables, laws and paths of an object known to a pool, of one argument each.
fn define_functions(pool: &Pool, object: &Value) {
    let pieces = object["functions"].as_array().expect("pieces");
    for pieces in pieces.chunk_by(|one, next| one["call"] == next["call"]) {
        let text = |value: &Value| value.as_str().expect("a text").to_owned();
        let call = text(&pieces[0]["call"]);
        let (name, argument) = call.trim_end_matches(')').split_once('(').expect("a call");
        let last = pieces.last().map(|piece| text(&piece["formula"])).expect("a piece");
        let body = pieces.iter().rev().skip(1).fold(last, |rest, piece| {
            format!("if(lt({argument}, {}), {}, {rest})", piece["to"][0], text(&piece["formula"]))
        });
        let symbol = pool.symbol_id(pool.symbol(argument)).expect("a symbol");
        pool.define(name, &[symbol], pool.parse(&body).expect("a formula"));
    }
}

#[test]
fn the_reading_form_with_its_names_put_back_is_what_is_solved() {
    for model in examples() {
        let printed = printed(&model, "--json");
        let object: Value = serde_json::from_str(&printed).expect("one object");
        let pool = Pool::new();
        define_functions(&pool, &object);
        let mut names = Vec::new();
        for name in object["reading"]["names"].as_array().expect("names") {
            let definition = name["definition"].as_str().expect("a definition");
            let definition = pool.substitute(pool.parse(definition).expect("a formula"), &names);
            let symbol = pool.symbol(name["name"].as_str().expect("a name"));
            names.push((pool.symbol_id(symbol).expect("a symbol"), definition));
        }
        // Those of a recursion have its names in every form.
        let plain = Formulas::of(&pool, &object, &names).all;
        let reading = Formulas::of(&pool, &object["reading"], &names).all;
        assert_eq!(plain.len(), reading.len());
        for (&a, &b) in plain.iter().zip(&reading) {
            let certificate = pool.certificate(a, b);
            // Constants of beams are printed with 16 digits, and read back as if they were exact.
            let is_rounded = model.to_string_lossy().contains("flexible-arm");
            let is_equal = certificate.is_equal()
                || is_rounded && certificate.n_points > 0 && certificate.worst_extended < 1e-12;
            assert!(is_equal, "{certificate:?}: {}", pool.to_text(b));
        }
        for key in ["derivation", "reading"] {
            assert_eq!(object["certificate"][key]["equal"], Value::Bool(true), "{key}");
        }
        let total = |form: &str, counted: &str| {
            object["operations"][form][counted]["total"].as_u64().expect("a number")
        };
        // A recursion lives of what it shares; of many massless links, or of outlines that touch, what is shorter to read may
        // share a little less.
        let derived = total("derived", "shared");
        assert!(total("simplified", "shared") <= derived + derived / 5, "{printed}");
        // Sums that are grouped for the eye may cost an operation or two.
        let [reading, simplified] =
            ["reading", "simplified"].map(|form| total(form, "written_out"));
        assert!(reading <= simplified + 3 + simplified / 20, "{printed}");
    }
}

#[test]
fn a_two_link_arm_has_the_constants_of_the_textbook() {
    let place = Scratch::new();
    let link = |n: usize, before: &str| {
        format!(
            "[bodies.b{n}]\nmass = \"m{n}\"\ninertia = \"I{n}\"\ncom = [\"a{n}\", 0]\n\
             points = {{ O = [0, 0], E = [\"l{n}\", 0] }}\n[joints.j{n}]\ntype = \"revolute\"\n\
             between = [\"{before}\", \"b{n}.O\"]\ncoordinate = \"q{n}\"\n"
        )
    };
    let parameters: Vec<String> = (1..=2)
        .map(|n| format!("m{n} = \"1 kg\"\nI{n} = \"0.1 kg*m^2\"\na{n} = 0.5\nl{n} = \"1 m\"\n"))
        .collect();
    // A parameter called J2 keeps its name.
    let parameters =
        format!("[parameters]\ng = \"9.81 m/s^2\"\nJ2 = \"7 kg\"\n{}", parameters.concat());
    let gravity = "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-g\"]\n";
    let model = [&parameters, gravity, &link(1, "ground"), &link(2, "b1.E")].map(String::from);
    place.write("arm.toml", model.concat().replace("a1 = 0.5", "a1 = \"J2*0.5 m/(7 kg)\""));
    let output = place.run("equations arm.toml");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    for line in [
        "J1 = I1 + a1^2*m1 + I2 + m2*(a2^2 + l1^2)    (1.7 kg m²)",
        "J3 = a2*l1*m2    (0.5 kg m²)",
        "J4 = I2 + a2^2*m2    (0.35 kg m²)",
        "q2:  (J3*cos(q2) + J4)*q1_ddot + J4*q2_ddot + J3*sin(q2)*q1_dot^2 + W2*cos(q1 + q2) = 0",
    ] {
        assert!(printed.lines().any(|l| l.trim() == line), "no `{line}` in\n{printed}");
    }
}

#[test]
fn a_document_needs_a_format_that_has_one() {
    let place = Scratch::new();
    let output = place.run("equations none.toml --document --format json");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
}

/// The left sides below a heading, with their names.
fn rows(printed: &str, heading: &str) -> Vec<(String, String)> {
    let lines = printed.lines().skip_while(|line| *line != heading).skip(1);
    let lines = lines.take_while(|line| !line.is_empty());
    let row = |line: &str| {
        let (name, formula) = line.trim().split_once(':').expect("a name");
        (name.to_owned(), formula.trim().trim_end_matches("= 0").trim().to_owned())
    };
    lines.map(row).collect()
}

#[test]
fn the_effort_of_a_drive_is_that_of_the_motion() {
    let place = Scratch::new();
    let model = PathBuf::from(CRATE).join("../../examples/four-bar/model.toml");
    let model = std::fs::read_to_string(model).expect("an example");
    place.write("four.toml", model.replace("speed*t", "speed*t + 3 rad/s^2*t^2"));
    let run = |arguments: &str| {
        let output = place.run(arguments);
        assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    run("solve four.toml --t-end 0.3 --every 0.1 --rtol 1e-10 --atol 1e-12");
    let table = run("export four.mcap state acceleration multipliers.ld3");
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heads = lines.next().expect("headings");
    let formulas = run("equations four.toml --effort --groups off");
    let velocities = rows(&formulas, "velocities by that of the drive");
    let [(name, effort)] = &rows(&formulas, "effort of the drive")[..] else {
        panic!("one effort: {formulas}")
    };
    assert_eq!((velocities.len(), name.as_str()), (2, "ld3"), "{formulas}");
    assert!(!effort.contains("ld1") && !effort.contains("ld2"), "{effort}");
    let parameters = [("a", 0.1), ("b", 0.3), ("c", 0.25), ("d", 0.3), ("g", 9.81)];
    for cells in lines {
        let logged = heads.iter().zip(&cells).map(|(head, cell)| {
            let name = head.rsplit('.').next().expect("a name");
            (name.to_owned(), cell.parse::<f64>().expect("a number"))
        });
        let known = parameters.iter().map(|&(name, value)| (name.to_owned(), value));
        let mut values: Vec<(String, f64)> = logged.chain(known).collect();
        let left_side = |formula: &str, values: &[(String, f64)]| {
            let pool = Pool::new();
            let e = pool.parse(formula).expect("a formula");
            let symbol = |name: &str| pool.symbol_id(pool.symbol(name)).expect("a symbol");
            let known: Vec<_> = values.iter().map(|(name, x)| (symbol(name), *x)).collect();
            let value = |of| known.iter().find(|(symbol, _)| *symbol == of).map(|(_, x)| *x);
            pool.evaluate(e, &value).expect("a value")
        };
        for (name, formula) in &velocities {
            values.push((name.clone(), 0.0));
            let rate = -left_side(formula, &values);
            values.last_mut().expect("the rate").1 = rate;
            // As fast as in the run.
            let of = |name: &str| values.iter().find(|(known, _)| known == name).expect(name).1;
            let own = of(&format!("{}_dot", &name[2..])) / of("A_angle_dot");
            assert!((rate - own).abs() < 1e-6, "{name}: {rate} for {own}");
        }
        let left = left_side(effort, &values);
        let size = values.iter().find(|(name, _)| name == "ld3").expect("an effort").1;
        assert!(left.abs() < 1e-6 * (1.0 + size.abs()), "{left} of {size}");
    }
    // A mechanism without a drive has none.
    let output =
        place.run(&format!("equations {CRATE}/../../examples/slider-crank/model.toml --effort"));
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
}
