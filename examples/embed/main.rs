//! bksim inside another program: a model as text, its equations, its motion.
//!
//! Run it with `cargo run --example embed`.

use std::error::Error;
use std::io::{self, Write};

use bksim::Mechanism;

/// A pendulum whose bob slides along a massless rod and hangs on a spring.
const MODEL: &str = r#"
[parameters]
m = "0.5 kg"
k = "50 N/m"
l = "0.4 m"

[bodies.rod]
mass = 0
inertia = 0

[bodies.bob]
mass = "m"
inertia = 0

[joints.pivot]
type = "revolute"
between = ["ground", "rod"]
coordinate = "phi"

[joints.sleeve]
type = "prismatic"
between = ["rod", "bob"]
axis = [0, -1]
coordinate = "r"

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[loads.spring]
type = "spring"
between = ["ground", "bob"]
stiffness = "k"
length = "l"

[initial]
pivot = { angle = "40 deg", rate = 0 }
sleeve = { position = "0.5 m", velocity = 0 }

[solve]
t_end = "2 s"
every = "0.25 s"
rtol = 1e-9
atol = 1e-11
"#;

fn main() -> Result<(), Box<dyn Error>> {
    report(&mut io::stdout().lock())
}

/// Everything that is printed.
pub(crate) fn report(out: &mut dyn Write) -> Result<(), Box<dyn Error>> {
    let pendulum = Mechanism::from_toml(MODEL, "elastic pendulum")?;
    let equations = pendulum.equations();
    writeln!(out, "T = {}", equations.kinetic_energy)?;
    writeln!(out, "V = {}", equations.potential_energy)?;
    for equation in &equations.equations {
        writeln!(out, "0 = {equation}")?;
    }

    let motion = pendulum.solve()?;
    writeln!(out, "\n{:>6}  {:>10}  {:>10}  {:>12}", "t, s", "phi, rad", "r, m", "energy, J")?;
    for sample in &motion.samples {
        let energy = sample.energy.kinetic + sample.energy.potential;
        let [phi, r] = [sample.q[0], sample.q[1]];
        writeln!(out, "{:>6.2}  {phi:>10.6}  {r:>10.6}  {energy:>12.6}", sample.t)?;
    }
    Ok(())
}
