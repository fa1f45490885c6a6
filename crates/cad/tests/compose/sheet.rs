//! Drawings under construction.

use bksim_cad::attach::attachments;
use bksim_cad::compose::{ComposeOptions, Composition, compose};
use bksim_cad::drawing::{Attribute, Drawing, Entity, Handle, Insert, LengthUnit, Location, Shape};
use bksim_cad::excerpt::Excerpts;
use bksim_cad::geometry::{Path, Point, Vertex};

/// A drawing in millimetres under construction.
#[derive(Default)]
pub(crate) struct Sheet {
    entities: Vec<Entity>,
}

impl Sheet {
    pub(crate) fn add(&mut self, kind: &str, layer: &str, at: Point, shape: Shape) -> &mut Entity {
        let handle = Some(Handle(0x20 + self.entities.len() as u64));
        let location = Location { kind: kind.into(), handle, layer: layer.into(), at, lines: None };
        self.entities.push(Entity { location, shape, xdata: Vec::new() });
        self.entities.last_mut().expect("one was just added")
    }

    pub(crate) fn circle(&mut self, layer: &str, centre: Point, radius: f64) -> &mut Entity {
        self.add("CIRCLE", layer, centre, Shape::Path(Path::circle(centre, radius)))
    }

    pub(crate) fn polygon(&mut self, layer: &str, corners: &[(Point, f64)]) -> &mut Entity {
        let corners: Vec<Vertex> =
            corners.iter().map(|&(at, bulge)| Vertex { at, bulge }).collect();
        let path = Path::from_bulges(&corners, true).expect("a closed path");
        self.add("LWPOLYLINE", layer, corners[0].at, Shape::Path(path))
    }

    pub(crate) fn rectangle(&mut self, layer: &str, [x0, y0]: Point, [x1, y1]: Point) {
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        self.polygon(layer, &corners.map(|at| (at, 0.0)));
    }

    /// A rounded bar around two points, with a hole at each.
    pub(crate) fn bar(&mut self, layer: &str, a: Point, b: Point, radius: f64) -> &mut Entity {
        self.circle(layer, a, radius / 3.0);
        self.circle(layer, b, radius / 3.0);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let n = [-(b[1] - a[1]) / length * radius, (b[0] - a[0]) / length * radius];
        let across = |p: Point, side: f64| [p[0] + side * n[0], p[1] + side * n[1]];
        let corners = [
            (across(a, -1.0), 0.0),
            (across(b, -1.0), 1.0),
            (across(b, 1.0), 0.0),
            (across(a, 1.0), 1.0),
        ];
        self.polygon(layer, &corners)
    }

    pub(crate) fn insert(&mut self, block: &str, at: Point, angle: f64, values: &[(&str, &str)]) {
        let location = |kind: &str| Location {
            kind: kind.into(),
            handle: None,
            layer: "0".into(),
            at,
            lines: None,
        };
        let attribute = |&(tag, value): &(&str, &str)| Attribute {
            tag: tag.into(),
            value: value.into(),
            location: location("ATTRIB"),
        };
        let attributes = values.iter().map(attribute).collect();
        let (sin, cos) = angle.sin_cos();
        let insert = Insert { block: block.into(), at, x: [cos, sin], y: [-sin, cos], attributes };
        self.add("INSERT", "0", at, Shape::Insert(insert));
    }

    pub(crate) fn compose(self, options: ComposeOptions<'_>) -> Composition {
        let mut extent = [[f64::MAX; 2], [f64::MIN; 2]];
        for point in self.entities.iter().map(|entity| entity.location.at) {
            for axis in 0..2 {
                extent[0][axis] = extent[0][axis].min(point[axis]);
                extent[1][axis] = extent[1][axis].max(point[axis]);
            }
        }
        let unit = LengthUnit { name: "mm", metres: 1e-3 };
        let drawing = Drawing { unit, entities: self.entities, extent };
        let excerpts = Excerpts::default();
        let (attached, faults) = attachments(&drawing, &excerpts);
        assert!(faults.is_empty(), "{faults:#?}");
        compose(&drawing, &attached, &excerpts, options)
    }

    pub(crate) fn compose_with(self, sidecar: &str) -> Composition {
        self.compose(ComposeOptions { sidecar: Some(sidecar), ..ComposeOptions::default() })
    }
}

/// Ground, crank and rod on layers, with circles and texts for the joints A and B.
pub(crate) fn two_bars() -> Sheet {
    let mut sheet = Sheet::default();
    sheet.circle("BK_GROUND", [0.0, 0.0], 20.0);
    sheet.bar("BK_BODY_crank", [0.0, 0.0], [80.0, 60.0], 10.0);
    sheet.bar("BK_BODY_rod", [80.0, 60.0], [300.0, 60.0], 8.0);
    for (name, at) in [("A", [0.0, 0.0]), ("B", [80.0, 60.0])] {
        sheet.circle("BK_JOINTS", at, 4.0);
        let text = Shape::Text { at: [at[0] + 6.0, at[1]], text: name.to_owned() };
        sheet.add("TEXT", "BK_JOINTS", at, text);
    }
    sheet
}
