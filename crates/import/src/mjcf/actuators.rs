//! Actuators as loads whose controls are parameters.
//!
//! ```text
//! force = g u + b0 + b1 l + b2 l'       l = gear q, or the length of a tendon; the joint takes gear times it
//! ```

use crate::draft::{Parameter, number, signed};
use crate::job::suggestion;
use crate::xml::NodeId;

use super::defaults::ClassId;
use super::{MadeJoint, Reader};

/// Gain g and bias b0, b1, b2 of an actuator.
struct Law {
    gain: f64,
    bias: [f64; 3],
}

impl Reader<'_, '_> {
    pub(super) fn all_actuators(&mut self, root: NodeId) {
        for section in self.tree.all(root, "actuator") {
            for node in self.tree.children(section) {
                let class = self.class_of(node, ClassId::MAIN, "class");
                self.actuator(node, class);
            }
        }
    }

    fn actuator(&mut self, node: NodeId, class: ClassId) {
        let Some(law) = self.law(node, class) else { return self.leave_out(node) };
        let gear = self.number(node, class, "gear").unwrap_or(1.0);
        let key = ["joint", "jointinparent", "tendon"]
            .into_iter()
            .find(|key| self.tree.attribute(node, key).is_some());
        let Some(key) = key else { return self.leave_out(node) };
        let Some(found) = self.tree.attribute(node, key).cloned() else { return };
        let parts: Vec<(MadeJoint, f64)> = if key == "tendon" {
            match self.tendons.get(&found.value) {
                Some(tendon) => tendon.parts.clone(),
                None => return self.leave_out(node),
            }
        } else if let Some(joint) = self.joints.get(&found.value) {
            vec![(joint.clone(), 1.0)]
        } else {
            let help = suggestion(&found.value, self.joints.keys().map(String::as_str));
            return self.unknown("joint", &found.value, &found.place, &help);
        };
        if parts.iter().any(|(joint, _)| !matches!(joint.kind.as_str(), "hinge" | "slide")) {
            return self.leave_out(node);
        }

        // The control.
        let tag = self.tree.tag(node).to_owned();
        let label = self.tree.value(node, "name").map(str::to_owned);
        let label = label.unwrap_or_else(|| format!("{tag}_{}", parts[0].0.name));
        let input = self.names.take("parameter", &format!("{label}_ctrl"));
        self.names.renamed.retain(|renamed| renamed.to != input);
        let range = self
            .word(node, class, "ctrlrange")
            .map_or(String::new(), |range| format!(", range {range}"));
        let note = format!("control of {tag} {label}{range}");
        self.draft.parameters.push(Parameter { name: input.clone(), value: "0".to_owned(), note });
        self.draft.inputs.push(input.clone());

        // Its force, by the length of the transmission.
        let length = sum(&parts, gear, |joint| {
            if joint.kind == "hinge" {
                format!("{}.angle", joint.name)
            } else {
                format!("{}.position/(1 m)", joint.name)
            }
        });
        let rate = sum(&parts, gear, |joint| {
            if joint.kind == "hinge" {
                format!("{}.rate*(1 s)", joint.name)
            } else {
                format!("{}.velocity/(1 m/s)", joint.name)
            }
        });
        let mut force = format!("{}*{input}", number(law.gain));
        for (c, what) in law.bias.into_iter().zip(["", &length, &rate]) {
            if c != 0.0 {
                let times = if what.is_empty() { String::new() } else { format!("*{what}") };
                force = format!("{force} {}{times}", signed(c));
            }
        }
        let limit = self
            .word(node, class, "forcerange")
            .map_or(String::new(), |range| format!("force range {range} of the file is left out"));
        for (joint, coefficient) in &parts {
            let factor = gear * coefficient;
            let unit = if joint.kind == "hinge" { "1 N m" } else { "1 N" };
            self.joint_load(
                &label,
                joint,
                &format!("{unit}*({})*({force})", number(factor)),
                &limit,
            );
        }
    }

    /// The law of an actuator; `None` of those with states of their own or that push elsewhere.
    fn law(&mut self, node: NodeId, class: ClassId) -> Option<Law> {
        let of = |reader: &mut Self, key: &str, default: f64| {
            reader.number(node, class, key).unwrap_or(default)
        };
        let dynamics = self.word(node, class, "dyntype");
        if dynamics.is_some_and(|kind| kind != "none") {
            return None;
        }
        match self.tree.tag(node) {
            "motor" => Some(Law { gain: 1.0, bias: [0.0; 3] }),
            "position" => {
                let kp = of(self, "kp", 1.0);
                let kv = of(self, "kv", 0.0);
                if self.tree.attribute(node, "dampratio").is_some()
                    || of(self, "timeconst", 0.0) != 0.0
                {
                    return None;
                }
                Some(Law { gain: kp, bias: [0.0, -kp, -kv] })
            }
            "velocity" => {
                let kv = of(self, "kv", 1.0);
                Some(Law { gain: kv, bias: [0.0, 0.0, -kv] })
            }
            "general" => {
                let gain_kind =
                    self.word(node, class, "gaintype").unwrap_or_else(|| "fixed".to_owned());
                let bias_kind =
                    self.word(node, class, "biastype").unwrap_or_else(|| "none".to_owned());
                if gain_kind != "fixed" || !matches!(bias_kind.as_str(), "none" | "affine") {
                    return None;
                }
                let gain = self
                    .numbers(node, class, "gainprm")
                    .and_then(|prm| prm.first().copied())
                    .unwrap_or(1.0);
                let prm = self.numbers(node, class, "biasprm").unwrap_or_default();
                let prm = |idx: usize| {
                    if bias_kind == "affine" { prm.get(idx).copied().unwrap_or(0.0) } else { 0.0 }
                };
                Some(Law { gain, bias: [prm(0), prm(1), prm(2)] })
            }
            _ => None,
        }
    }
}

/// gear Σ c q of some joints.
fn sum(parts: &[(MadeJoint, f64)], gear: f64, of: impl Fn(&MadeJoint) -> String) -> String {
    let terms: Vec<String> = parts
        .iter()
        .map(|(joint, c)| {
            let factor = gear * c;
            if factor == 1.0 { of(joint) } else { format!("{}*{}", number(factor), of(joint)) }
        })
        .collect();
    format!("({})", terms.join(" + ").replace("+ -", "- "))
}
