//! Play of pins: a virtual link from the centre of the hole to that of the pin, in any direction and at most as long as
//! the play.

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::suggest;
use bksim::model::{Model, Parameter, Point, PointId, Space};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::base::Quantity;
use crate::codes;
use crate::error::DesignError;
use crate::spec::located;

/// A pin with play.
pub(super) struct Play {
    /// The joint.
    pub(super) name: String,
    /// Place of the first of both components among the parameters of the model.
    pub(super) place: usize,
    /// Largest distance of both centres, m.
    pub(super) reach: f64,
}

impl Play {
    /// Any place in the hole, all alike, in parts of the reach.
    pub(super) fn sample(rng: &mut Pcg64Mcg) -> [f64; 2] {
        loop {
            let at = [0; 2].map(|_| 2.0 * rng.random::<f64>() - 1.0);
            if at[0].hypot(at[1]) <= 1.0 {
                return at;
            }
        }
    }
}

/// Gives the model two more parameters for each pin with play: the components by which its hole is aside.
pub(super) fn added(
    model: &mut Model,
    wish: &[(String, String)],
    text: &str,
) -> Result<Vec<Play>, DesignError> {
    let one = |(name, size): &(String, String)| {
        let fault = |code, message: String, help: String| {
            located(DesignError::from(Diagnostic::error(code, message).help(help)), text, name)
        };
        let Some(joint) = model.joints.iter().position(|joint| joint.name == *name) else {
            let known: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
            let message = format!("the model has no joint `{name}` to have play");
            return Err(fault(codes::UNKNOWN_QUANTITY, message, suggest(name, &known)));
        };
        let is_length = |size: &Quantity| size.fits("m") && !size.unit.is_empty();
        let reach = Quantity::read(size).filter(is_length).map_or(0.0, |size| size.value);
        if reach <= 0.0 {
            let message = format!("`{size}` is no play of `{name}`");
            let help =
                format!("write half of the difference of both diameters: `{name} = \"0.02 mm\"`");
            return Err(fault(codes::BAD_QUESTION, message, help));
        }
        // The end on a rigid body moves.
        let joint = &mut model.joints[joint];
        let ends = [&mut joint.predecessor, &mut joint.successor];
        let rigid = ends.into_iter().find(|end| model.bodies[end.body.0].flexible.is_none());
        let end = match rigid {
            Some(end) if model.space == Space::Planar && joint.kind.is_pin() => end,
            _ => {
                let message = format!("`{name}` is no pin between rigid bodies in a plane");
                let help = "give play to revolute joints of planar mechanisms alone".to_owned();
                return Err(fault(codes::BAD_QUESTION, message, help));
            }
        };
        let (pool, place) = (&model.pool, model.parameters.len());
        let components = ["x", "y"].map(|axis| {
            let expr = pool.symbol(&format!("play of {name} along {axis}"));
            let symbol = pool.symbol_id(expr).expect("a symbol");
            model.parameters.push(Parameter {
                name: format!("play of {name} along {axis}"),
                symbol,
                definition: pool.zero(),
                value: 0.0,
                unit: "m".to_owned(),
                span: joint.span.clone(),
            });
            expr
        });
        let points = &mut model.bodies[end.body.0].points;
        let mut point = match end.point {
            Some(point) => points[point.0].clone(),
            None => {
                Point { name: String::new(), position: [pool.zero(); 3], orientation: Vec::new() }
            }
        };
        point.name = format!("hole of {name}");
        for (position, component) in point.position.iter_mut().zip(components) {
            *position = pool.add(*position, component);
        }
        end.point = Some(PointId(points.len()));
        points.push(point);
        Ok(Play { name: name.clone(), place, reach })
    };
    wish.iter().map(one).collect()
}
