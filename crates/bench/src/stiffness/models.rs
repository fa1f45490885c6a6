//! The models: examples, and pendulums with something stiff on them.

/// A model and the end of its run, s.
pub(super) struct StiffModel {
    pub(super) name: &'static str,
    pub(super) text: String,
    pub(super) t_end: f64,
}

const LINK: &str = "mass = 1\ncom = [0.5, 0]\ninertia = \"1 kg m^2/12\"\n\
    points = { A = [0, 0], B = [1, 0] }\n";
const GRAVITY: &str = "[loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n";

/// A link on a pin, coordinate `th`.
fn pendulum() -> String {
    format!(
        "[bodies.b]\n{LINK}[joints.j]\ntype = \"revolute\"\nbetween = [\"ground\", \"b.A\"]\n\
         coordinate = \"th\"\n{GRAVITY}"
    )
}

/// The pendulum with another torque on it.
fn with_torque(law: &str, start: &str) -> String {
    format!(
        "{}[loads.t]\ntype = \"torque\"\non = \"b\"\nvalue = \"{law}\"\n[initial]\n{start}",
        pendulum()
    )
}

/// A mass that slides along the pendulum behind a spring and a damper.
fn with_spring(stiffness: &str, damping: &str) -> String {
    format!(
        "{}[bodies.m]\nmass = 1\ninertia = 0.1\n[joints.s]\ntype = \"prismatic\"\n\
         between = [\"b.B\", \"m\"]\naxis = [1, 0]\ncoordinate = \"s\"\n[loads.k]\ntype = \"force\"\n\
         between = [\"b.A\", \"m\"]\nvalue = \"-{stiffness}*s - {damping}*s_dot\"\n\
         [initial]\nth = 0\ns = 0\n",
        pendulum()
    )
}

/// The pendulum's pin in a bushing of this stiffness, N/m, and damping, N s/m.
fn with_bushing(stiffness: &str, damping: &str) -> String {
    let carriage = "mass = 0.5\ninertia = 0.01\n";
    format!(
        "[bodies.b]\n{LINK}{GRAVITY}[bodies.h]\n{carriage}[bodies.h2]\n{carriage}\
         [joints.hx]\ntype = \"prismatic\"\nbetween = [\"ground\", \"h\"]\naxis = [1, 0]\n\
         coordinate = \"hx\"\n[joints.hy]\ntype = \"prismatic\"\nbetween = [\"h\", \"h2\"]\n\
         axis = [0, 1]\ncoordinate = \"hy\"\n[joints.r]\ntype = \"revolute\"\n\
         between = [\"h2\", \"b.A\"]\ncoordinate = \"th\"\n\
         [loads.bx]\ntype = \"force\"\non = \"h\"\n\
         vector = [\"-{stiffness}*hx - {damping}*hx_dot\", 0]\n\
         [loads.by]\ntype = \"force\"\non = \"h2\"\n\
         vector = [0, \"-{stiffness}*hy - {damping}*hy_dot\"]\n\
         [initial]\nth = 0\nhx = 0\nhy = 0\n"
    )
}

/// Two links, whose second pin rubs.
fn double(damping: &str) -> String {
    format!(
        "{}[bodies.c]\n{LINK}[joints.k]\ntype = \"revolute\"\nbetween = [\"b.B\", \"c.A\"]\n\
         coordinate = \"ph\"\n[loads.d]\ntype = \"torque\"\non = \"c\"\n\
         value = \"-{damping}*ph_dot\"\n[initial]\nth = 0.5\nph = 0.3\n",
        pendulum()
    )
}

/// A pendulum behind a motor whose current follows within `time`, s.
fn with_motor(time: &str) -> String {
    format!(
        "[states]\ni = {{ rate = \"(1 - i - 0.5*th_dot)/({time})\", start = 0 }}\n{}",
        with_torque("10*i - th_dot", "th = 0\nth_dot = 0\n")
    )
}

/// Examples with runs long enough to be timed.
macro_rules! example {
    ($name:literal, $t_end:expr) => {
        StiffModel {
            name: $name,
            text: include_str!(concat!("../../../../examples/", $name, "/model.toml")).to_owned(),
            t_end: $t_end,
        }
    };
}

/// All of them.
pub(super) fn all() -> Vec<StiffModel> {
    let own = |name, text, t_end| StiffModel { name, text, t_end };
    let at_rest = "th = 0\nth_dot = 0\n";
    vec![
        example!("governor", 10.0),
        example!("five-link", 10.0),
        example!("four-bar", 10.0),
        example!("slider-crank", 10.0),
        example!("spring-pendulum", 10.0),
        example!("winch", 3.0),
        own("pendulum", format!("{}[initial]\n{at_rest}", pendulum()), 20.0),
        own("double pendulum", double("0"), 20.0),
        own("double, pin 1e2 N m s", double("1e2"), 10.0),
        own("double, pin 1e4 N m s", double("1e4"), 10.0),
        own("bushing 1e5 N/m", with_bushing("1e5", "3e2"), 10.0),
        own("bushing 1e7 N/m", with_bushing("1e7", "3e3"), 10.0),
        own("bushing 1e9 N/m", with_bushing("1e9", "3e4"), 10.0),
        own("damped spring 1e6 N/m", with_spring("1e6", "6e2"), 10.0),
        own("damped spring 1e9 N/m", with_spring("1e9", "2e4"), 10.0),
        own("undamped spring 1e6 N/m", with_spring("1e6", "0"), 1.0),
        own("Van der Pol 5 N m s", with_torque("5*(1-th^2)*th_dot", "th = -1\nth_dot = 0\n"), 20.0),
        own(
            "Van der Pol 200 N m s",
            with_torque("200*(1-th^2)*th_dot", "th = -1\nth_dot = 0\n"),
            20.0,
        ),
        own("smoothed friction 1e-3 rad/s", with_torque("-2*tanh(th_dot/1e-3)", at_rest), 20.0),
        own("motor 1 ms", with_motor("1e-3"), 10.0),
        own("motor 10 us", with_motor("1e-5"), 10.0),
    ]
}
