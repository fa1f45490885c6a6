//! Reactions in expressions: heat of friction, impulses and loads that depend on them, in closed form.

use crate::support::{
    Within, close, derive, elements, messages, model, reaction, signal, solve, with_method,
};
use bksim::model::file::{Source, read};

const GRAVITY: f64 = 9.81;

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// A block of 2 kg on a guide along x, with further sections.
fn block(more: &str) -> String {
    format!(
        "[bodies.block]\nmass = \"2 kg\"\n[joints.S]\ntype = \"prismatic\"\n\
         between = [\"ground\", \"block\"]\naxis = [1, 0]\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
         [initial]\nS = {{ position = 0, velocity = \"3 m/s\" }}\n{more}\n\
         [solve]\nt_end = 2\nevery = 0.25\nrtol = 1e-10\natol = 1e-12\n"
    )
}

/// Sliding stops after v/(μ g); until then all motion has become heat.
#[test]
fn the_heat_of_friction_is_the_energy_that_is_lost() {
    let rubbing = "[loads.rubbing]\ntype = \"friction\"\njoint = \"S\"\nmu = 0.2\n\
         [states.heat]\nrate = \"0.2*abs(reactions.S.fy*S.velocity)\"\nstart = \"0 J\"\n\
         [signals.normal]\nvalue = \"reactions.S.fy\"\n";
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(&block(rubbing), method)));
        let motion = solve(&mechanism);
        for sample in &motion.samples {
            let speed = (3.0 - 0.2 * GRAVITY * sample.t).max(0.0);
            let heat = 9.0 - speed * speed;
            close(
                &format!("{method}, normal"),
                signal(&mechanism, sample, "normal"),
                2.0 * GRAVITY,
                within(1e-9),
            );
            let state = mechanism.system.coordinates().iter().position(|c| c.name.contains("heat"));
            let found = sample.v[state.expect("a state")];
            close(&format!("{method}, heat at {} s", sample.t), found, heat, within(1e-7));
        }
    }
}

/// A load that presses the block by half of what its guide bears: N = m g − N/2, and a drag of 0.3 N.
#[test]
fn a_load_may_depend_on_the_reaction_that_it_changes() {
    let pressed = "[loads.wind]\ntype = \"force\"\non = \"block\"\n\
         vector = [\"-0.3*reactions.S.fy_joint\", \"0.5*reactions.S.fy\"]\n";
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(&block(pressed), method)));
        let motion = solve(&mechanism);
        for sample in &motion.samples {
            let normal = 2.0 * GRAVITY / 1.5;
            close("normal", reaction(&mechanism, sample, "S")[1], normal, within(1e-9));
            let x = 3.0 * sample.t - 0.5 * 0.15 * normal * sample.t * sample.t;
            let place = mechanism.system.coordinates().iter().position(|c| c.name.ends_with("_x"));
            close("position", sample.q[place.expect("x")], x, within(1e-9));
        }
    }
}

/// The impulse of a pendulum's pin is the change of momentum and the impulse of the weight.
#[test]
fn the_impulse_of_a_pin() {
    let pendulum = "[bodies.bob]\nmass = \"3 kg\"\ninertia = \"0.2 kg*m^2\"\n\
         points = { O = [\"-0.7 m\", 0] }\n[joints.A]\ntype = \"revolute\"\n\
         between = [\"ground\", \"bob.O\"]\n[loads.gravity]\ntype = \"gravity\"\n\
         acceleration = [0, \"-9.81 m/s^2\"]\n\
         [states.jx]\nrate = \"reactions.A.fx\"\nstart = \"0 N s\"\n\
         [states.jy]\nrate = \"reactions.A.fy\"\nstart = \"0 N s\"\n\
         [initial]\nA = { angle = \"20 deg\", rate = \"1 rad/s\" }\n\
         [solve]\nt_end = 2\nevery = 0.5\nrtol = 1e-11\natol = 1e-13\n";
    let mechanism = derive(model(pendulum));
    let motion = solve(&mechanism);
    let momenta = crate::support::Measures::new(&mechanism, &["bob.px", "bob.py"]);
    let start = momenta.at(&motion.samples[0]);
    for sample in &motion.samples {
        let now = momenta.at(sample);
        let state = |name: &str| {
            let of = mechanism.system.coordinates().iter().position(|c| c.name.contains(name));
            sample.v[of.expect("a state")]
        };
        let at = format!("at {} s", sample.t);
        close(&format!("x {at}"), state("jx"), now[0] - start[0], within(1e-8));
        let weight = 3.0 * GRAVITY * sample.t;
        close(&format!("y {at}"), state("jy"), now[1] - start[1] + weight, within(1e-8));
    }
}

#[test]
fn reactions_are_refused_where_they_cannot_be_known() {
    let fault = |more: &str| messages(&read(&Source::new(&block(more), "block")).diagnostics);
    let refused = [
        "[drives.push]\njoint = \"S\"\nmotion = \"reactions.S.fy*1 m/N\"",
        "[clocks.c]\nevery = \"1 ms\"\n[signals.n]\nclock = \"c\"\nvalue = \"reactions.S.fy\"",
        "[signals.n]\nstart = 0\nwhen = [{ condition = \"reactions.S.fy > 3 N\", value = 1 }]",
        "[signals.n]\nvalue = \"reactions.S.fy\"\n[loads.p]\ntype = \"stop\"\njoint = \"S\"\nmax = \"n*1 m/N\"",
    ];
    for more in refused {
        let found = fault(more);
        assert!(found.contains("reactions.S.fy` ") || found.contains("uses `"), "{more}: {found}");
    }
    assert!(fault("[signals.n]\nvalue = \"reactions.S.fq\"").contains("reactions.S.fq"));
    assert!(fault("[signals.n]\nvalue = \"reactions.T.fx\"").contains("reactions.T.fx"));
    assert_eq!(fault("[signals.n]\nvalue = \"reactions.S.mz\""), "");
}

/// A single-cylinder engine whose piston rubs: what the gas gives is motion, the brake's work and heat.
#[test]
fn the_energy_of_an_engine_is_accounted_for() {
    let audit = "\n[loads.rubbing]\ntype = \"friction\"\njoint = \"guide\"\nmu = 0.08\n\
         [states.gas_work]\nrate = \"-gas(O.angle)*guide.velocity\"\nstart = \"0 J\"\n\
         [states.brake_work]\nrate = \"18 N m*O.rate\"\nstart = \"0 J\"\n\
         [states.heat]\nrate = \"0.08*abs(reactions.guide.fy*guide.velocity)\"\nstart = \"0 J\"\n";
    let engine = elements::text("engine").replace("[solve]", &format!("{audit}\n[solve]"));
    let mechanism = derive(model(&engine));
    let motion = solve(&mechanism);
    let [first, last] = [&motion.samples[0], motion.samples.last().expect("a sample")];
    let state = |name: &str| {
        let of = mechanism.system.coordinates().iter().position(|c| c.name.contains(name));
        last.v[of.expect("a state")]
    };
    let [gas, brake, heat] = ["gas_work", "brake_work", "heat"].map(state);
    let gained = last.energy.kinetic - first.energy.kinetic;
    close("energy", gas - brake - heat, gained, within(1e-6));
    // None of them is nothing.
    assert!(gas > 90.0 && brake > 200.0 && heat > 3.0, "{gas} {brake} {heat}");
}
