//! Files that are written: none is lost, none is corrupt, and two commands that want the same one hear of
//! each other.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

use crate::common::{CRATE, PROGRAM, Scratch, text};

/// A pendulum, with many samples.
const LONG: &str = include_str!("../../../tests/fixtures/long-pendulum.toml");

#[test]
fn of_eight_runs_that_want_one_new_log_each_gets_it_or_is_refused() {
    let model = format!("{CRATE}/../../examples/four-bar/model.toml");
    for force in [false, true] {
        let place = Scratch::new();
        let start = || {
            let mut command = place.bksim();
            command.args(["solve", &model, "-o", "run.mcap"]).args(force.then_some("--force"));
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("bksim starts")
        };
        let children: Vec<_> = (0..8).map(|_| start()).collect();
        let ended: Vec<_> =
            children.into_iter().map(|child| child.wait_with_output().expect("an end")).collect();
        let n_done = ended.iter().filter(|output| output.status.code() == Some(0)).count();
        // One that begins when another one has ended replaces its log.
        assert!(n_done >= 1, "{n_done} logs are written");
        for output in ended.iter().filter(|output| output.status.code() != Some(0)) {
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(4), "{said}");
            assert!(said.contains("`run.mcap` exists"), "{said}");
        }
        // Whoever has written it, it is whole, and nothing else is left.
        let table = place.run("export run.mcap");
        assert_eq!(text(&table.stderr), "");
        assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 1);
    }
}

#[test]
fn a_full_disk_is_told_by_every_command_that_writes() {
    let place = Scratch::new();
    let folder = format!("{CRATE}/../../examples/four-bar");
    assert!(place.run(&format!("solve {folder}/model.toml -o run.mcap")).status.success());
    for arguments in [
        format!("solve {folder}/model.toml -o /dev/full --force"),
        "cad template -o /dev/full --force".to_owned(),
        format!("cad from-toml {folder}/model.toml -o /dev/full --force"),
    ] {
        let output = place.run(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{arguments}: {said}");
        assert!(said.contains("No space left on device"), "{arguments}: {said}");
    }
    // Whatever is printed, too.
    for arguments in ["info run.mcap", "export run.mcap", "explain", "explain --json"] {
        let full = fs::File::options().write(true).open("/dev/full").expect("a device");
        let mut command = place.bksim();
        let output = command.args(arguments.split(' ')).stdout(full).output().expect("an end");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{arguments}: {said}");
        assert!(said.contains("`standard output` cannot be written"), "{arguments}: {said}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_fault() {
    let place = Scratch::new();
    let folder = format!("{CRATE}/../../examples/four-bar");
    assert!(place.run(&format!("solve {folder}/model.toml -o run.mcap")).status.success());
    for arguments in ["info run.mcap", "export run.mcap", "explain", "explain --json"] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = place.bksim();
        let output = command.args(arguments.split(' ')).stdout(writer).output().expect("an end");
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", text(&output.stderr));
        assert_eq!(text(&output.stderr), "", "{arguments}");
    }
}

#[test]
fn a_log_that_may_not_grow_tells_what_can_be_read() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    // In units of 512 bytes.
    let command = format!("ulimit -f 2000; exec {PROGRAM} solve long.toml");
    let mut shell = Command::new("sh");
    shell.args(["-c", &command]).current_dir(place.path()).env("NO_COLOR", "1");
    let output = shell.output().expect("a shell");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    let (_, told) = said.split_once("samples up to t = ").expect(&said);
    let told: f64 = told.split(' ').next().expect("a time").parse().expect(&said);

    let table = place.run("export long.mcap state.A_angle");
    let table = text(&table.stdout);
    let last = table.lines().last().expect("samples").split(',').next().expect("a time");
    assert_eq!(last.parse::<f64>(), Ok(told), "{said}");
    assert!(told > 0.0, "{said}");
}

#[test]
fn a_log_is_never_written_over_its_model() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    let at = |name: &str| place.path().join(name);
    fs::hard_link(at("long.toml"), at("hard.mcap")).expect("a link");
    symlink(at("long.toml"), at("soft.mcap")).expect("a link");
    for name in ["long.toml", "hard.mcap", "soft.mcap"] {
        let output = place.run(&format!("solve long.toml --t-end 1 --force -o {name}"));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{said}");
        assert!(said.contains("is the model itself and would be overwritten"), "{said}");
    }
    assert_eq!(fs::read_to_string(at("long.toml")).expect("a model"), LONG);
}

#[test]
fn a_log_that_is_replaced_stays_until_the_new_one_is_whole() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    assert!(place.run("solve long.toml --t-end 1").status.success());
    let before = fs::read(place.path().join("long.mcap")).expect("a log");
    let command = format!("ulimit -f 2000; exec {PROGRAM} solve long.toml --force");
    let mut shell = Command::new("sh");
    let output = shell.args(["-c", &command]).current_dir(place.path()).output().expect("a shell");
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    assert_eq!(fs::read(place.path().join("long.mcap")).expect("a log"), before);
}

#[test]
fn a_file_that_a_killed_command_left_is_named_by_the_next_one() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    place.write(".long.mcap.Ab12cd.part", "what was written");
    place.write(".other.mcap.Ab12cd.part", "what was written");
    let output = place.run("solve long.toml --t-end 1");
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("`.long.mcap.Ab12cd.part` (16 bytes)"), "{said}");
    assert!(said.contains("bksim solve --resume .long.mcap.Ab12cd.part"), "{said}");
    assert!(!said.contains(".other.mcap"), "{said}");
    // What another command is writing is not.
    fs::remove_file(place.path().join(".long.mcap.Ab12cd.part")).expect("it was there");
    let output = place.run("solve long.toml --t-end 1");
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn a_log_stops_at_its_limit_and_goes_on_when_that_is_raised() {
    let place = Scratch::new();
    place.write("long.toml", LONG.replace("1e6 s", "100 s"));
    let output = place.run("solve long.toml --log-limit 500kB");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("error[R024]: the log has reached its limit of 500 kB at t = "),
        "{said}"
    );
    // What the help says.
    let resume = said.split("`bksim ").nth(1).and_then(|rest| rest.split('`').next());
    let resume = resume.unwrap_or_else(|| panic!("{said}"));
    assert!(resume.starts_with("solve --resume long.mcap --log-limit 5MB"), "{said}");
    // The first part counts, too: what is whole needs more than that.
    let resumed = place.run(&resume.replace("5MB", "100MB"));
    assert!(resumed.status.success(), "{}", text(&resumed.stderr));
    let size = |name: &str| fs::metadata(place.path().join(name)).expect("a log").len();
    assert!((500_000..2_500_000).contains(&size("long.mcap")), "{}", size("long.mcap"));
    assert!(place.run("solve long.toml -o whole.mcap").status.success());
    let table = |log: &str| text(&place.run(&format!("export {log} state.A_angle")).stdout);
    assert!(table("long-resumed.mcap") == table("whole.mcap"), "other samples");
    let output = place.run("solve long.toml --log-limit 12");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
}

/// Loads and outputs with poles, overflows and roots of nothing, in every command that prints numbers: none of them is one.
#[test]
fn no_command_prints_what_is_no_number() {
    let model = |load: &str, output: &str| {
        format!(
            "[parameters]\nm = 1\n[bodies.arm]\nmass = \"m\"\ninertia = 0.1\ncom = [0.5, 0]\npoints = {{ tip = [1, 0] }}\n\
             [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             k = {{ type = \"torsion\", joint = \"O\", stiffness = 20 }}\n\
             u = {{ type = \"torque\", on = \"arm\", value = \"0.5 N m*({load})\" }}\n\
             [initial]\nO = {{ angle = 0.2 }}\n[outputs]\nh = \"{output}\"\n[solve]\nt_end = 0.1\nevery = 0.05\n"
        )
    };
    let pole = "1/(O.angle/(1 rad) - 0.2)";
    let cases = [
        model(pole, "arm.tip.y"),
        model("exp(5000*O.angle/(1 rad))", "arm.tip.y"),
        model("sqrt(O.angle/(1 rad) - 0.2)", "arm.tip.y"),
        model("1", pole),
    ];
    let commands = [
        "solve M --force",
        "export M",
        "report M",
        "verify M",
        "assemble M",
        "static M",
        "static M --over m=1:2:3",
        "static M --solve m",
        "modes M",
        "modes M --at start",
        "linearize M --output h",
        "linearize M --at start --output h",
        "bode M --at start --input O --output h",
        "code M --part linear --at start --force -o c",
        "inverse M --motion O.angle=0.2-0.3*t --times 0:0.5:3",
        "gradient M --of energy.total",
        "kinematics M --drive O.angle=0.1:0.3:3",
        "kinematics M --limits",
        "curves M",
        "polygons M --drive O.angle=0.2",
        "doctor M",
    ];
    for (k, case) in cases.iter().enumerate() {
        let place = Scratch::new();
        place.write("m.toml", case);
        let mut n_refused = 0;
        for command in commands {
            let output = place.run(&command.replace(" M", " m.toml"));
            let (out, said) = (text(&output.stdout), text(&output.stderr));
            let mut words = out.split(|c: char| !(c.is_alphanumeric() || c == '.'));
            let bad = words.find(|word| ["nan", "inf"].contains(&word.to_lowercase().as_str()));
            assert!(bad.is_none(), "case {k}, {command}: {out}");
            if !output.status.success() {
                n_refused += 1;
                assert!(said.contains("error["), "case {k}, {command}: {said}");
            }
        }
        assert!(n_refused > 3, "case {k}: {n_refused} refused");
    }
}
