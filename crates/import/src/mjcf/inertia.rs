//! Masses and inertias of bodies: stated, or those of their shapes.

use crate::codes;
use crate::shapes::Solid;
use crate::spatial::{
    Inertia, Pose, Rotation, Tensor, Vector, add, norm, principal_moments, scale, sub, turned,
    with_least_moment,
};

use super::Reader;
use super::bodies::Item;
use super::defaults::ClassId;

/// Density of shapes that state none, kg/m³.
const WATER: f64 = 1000.0;

impl Reader<'_, '_> {
    /// The inertia of a body and the shapes that draw it.
    pub(super) fn inertia_of(&mut self, items: &[Item]) -> (Inertia, Vec<String>) {
        let stated = items.iter().find(|item| self.tree.tag(item.node) == "inertial");
        let stated = stated.map(|item| self.stated(item));
        let uses_shapes = self.compiler.from_geoms.unwrap_or(stated.is_none());
        let (mut parts, mut shapes) = (Vec::new(), Vec::new());
        for item in items {
            if self.tree.tag(item.node) != "geom" {
                continue;
            }
            let class = self.class_of(item.node, item.class, "class");
            let (part, drawn) = self.geom(item, class, uses_shapes);
            parts.extend(part);
            shapes.extend(drawn);
        }
        let inertia = match (uses_shapes, stated) {
            // Without shapes that count, what is stated stays.
            (true, _) if !parts.is_empty() => Inertia::sum(&parts),
            (_, stated) => stated.unwrap_or_default(),
        };
        (self.bounded(inertia), shapes)
    }

    /// Bounds that the compiler sets.
    fn bounded(&self, mut inertia: Inertia) -> Inertia {
        let compiler = &self.compiler;
        inertia.mass = inertia.mass.max(compiler.bound_mass);
        let [least, middle, largest] = principal_moments(inertia.tensor);
        if compiler.is_balanced && least + middle < largest {
            let mean = (least + middle + largest) / 3.0;
            inertia.tensor = [mean, mean, mean, 0.0, 0.0, 0.0];
        }
        if least < compiler.bound_inertia {
            inertia.tensor = with_least_moment(inertia.tensor, compiler.bound_inertia);
        }
        inertia
    }

    fn stated(&mut self, item: &Item) -> Inertia {
        let main = ClassId::MAIN;
        let pose = item.frame.then(self.pose(item.node, main));
        let mass = self.number(item.node, main, "mass").unwrap_or(0.0);
        let mut tensor: Tensor = [0.0; 6];
        if let Some([xx, yy, zz]) = self.vector(item.node, main, "diaginertia") {
            tensor = [xx, yy, zz, 0.0, 0.0, 0.0];
        } else if let Some(found) = self.tree.attribute(item.node, "fullinertia").cloned() {
            let full = self.job.exactly::<6>(&found.value, &found.place, "`fullinertia`");
            let [xx, yy, zz, xy, xz, yz] = full.unwrap_or_default();
            tensor = [xx, yy, zz, xy, yz, xz];
        }
        Inertia { mass, com: pose.at, tensor: turned(pose.turn, tensor) }
    }

    /// The inertia of a shape, if it is asked for, and its drawing.
    fn geom(
        &mut self,
        item: &Item,
        class: ClassId,
        is_needed: bool,
    ) -> (Option<Inertia>, Vec<String>) {
        let kind = self.word(item.node, class, "type");
        let kind = kind.unwrap_or_else(|| "sphere".to_owned());
        let mut pose = item.frame.then(self.pose(item.node, class));
        let size = self.numbers(item.node, class, "size").unwrap_or_default();
        let size = |idx: usize| size.get(idx).copied().unwrap_or(0.0);
        let mut half = size(1);
        let mut is_between = false;
        let ends = self.attribute(item.node, class, "fromto");
        let ends = ends.and_then(|ends| self.job.exactly::<6>(&ends.0, &ends.1, "`fromto`"));
        if let Some([a, b, c, d, e, f]) = ends {
            let (from, to): (Vector, Vector) = ([a, b, c], [d, e, f]);
            let along = sub(from, to);
            half = norm(along) / 2.0;
            let middle = scale(0.5, add(from, to));
            pose = item.frame.then(Pose { at: middle, turn: Rotation::z_to(along) });
            is_between = true;
        }
        let halves = if is_between { [size(0), size(0), half] } else { [0, 1, 2].map(size) };
        let solid = match kind.as_str() {
            "sphere" => Solid::Sphere { radius: size(0) },
            "capsule" => Solid::Capsule { radius: size(0), half },
            "cylinder" => Solid::Cylinder { radius: size(0), half },
            "box" => Solid::Box { half: halves },
            "ellipsoid" => Solid::Ellipsoid { radii: halves },
            "mesh" | "sdf" => {
                let part = if is_needed && self.counts(item, class) {
                    self.mesh_inertia(item, class)
                } else {
                    None
                };
                return (part.map(|part| part.seen(pose)), Vec::new());
            }
            _ => {
                self.leave_out(item.node);
                return (None, Vec::new());
            }
        };
        if !solid.is_solid() {
            let message = format!("{} has no size", self.label(item.node));
            let place = self.tree.place(item.node).clone();
            let help = "give it a `size`, or `fromto`; until then it has no mass";
            self.job.warn(codes::MISSING, message, (&place, ""), help);
            return (None, Vec::new());
        }
        if self.word(item.node, class, "shellinertia").as_deref() == Some("true") {
            let what = format!("shellinertia of {}: taken as solid", self.label(item.node));
            let place = self.tree.place(item.node).clone();
            self.job.leave_out(what, &place);
        }
        let mass = self.mass_of(item, class, solid.volume());
        let counts = is_needed && self.counts(item, class) && mass != 0.0;
        let drawn = solid.drawn(pose);
        (counts.then(|| solid.inertia(mass).seen(pose)), drawn)
    }

    /// True if a shape is of a group that masses follow from.
    fn counts(&mut self, item: &Item, class: ClassId) -> bool {
        let [least, most] = self.compiler.groups;
        let group = self.number(item.node, class, "group").unwrap_or(0.0);
        (least..=most).contains(&group)
    }

    /// Mass of a shape: stated, or by its density.
    fn mass_of(&mut self, item: &Item, class: ClassId, volume: f64) -> f64 {
        let density = self.number(item.node, class, "density").unwrap_or(WATER);
        self.number(item.node, class, "mass").unwrap_or(density * volume)
    }

    /// Inertia of a mesh in its own frame.
    fn mesh_inertia(&mut self, item: &Item, class: ClassId) -> Option<Inertia> {
        let (volume, com, tensor) = self.mesh_moments(item, class)?;
        let mass = self.mass_of(item, class, volume);
        let scale = if volume == 0.0 { 0.0 } else { mass / volume };
        Some(Inertia { mass, com, tensor: tensor.map(|entry| scale * entry) })
    }

    /// Scales all masses where the file states their sum.
    pub(super) fn scale_masses(&mut self) {
        let Some(total) = self.compiler.total_mass else { return };
        let sum: f64 = self.draft.bodies.iter().map(|body| body.inertia.mass).sum();
        if sum <= 0.0 {
            return;
        }
        for body in &mut self.draft.bodies {
            body.inertia.mass *= total / sum;
            body.inertia.tensor = body.inertia.tensor.map(|entry| entry * (total / sum));
        }
    }
}
