//! The geometry of one entity.

use acadrust::entities::mtext_format::parse_mtext;
use acadrust::entities::{
    Arc, BoundaryEdge, BoundaryPath, Circle, Ellipse, Hatch, LwPolyline, Polyline2D, Polyline3D,
    Solid, Spline as SplineEntity, VertexFlags,
};
use acadrust::{EntityType, Vector2, Vector3};

use super::plane::planar;
use crate::drawing::{Shape, Unread};
use crate::geometry::{Affine, Curve, Path, Point, Spline, Vertex};

const TURN: f64 = std::f64::consts::TAU;

/// The geometry of an entity other than an insert, in the axes it is defined in: those of the world
/// or, inside of a block, of the block.
pub(super) fn shape(entity: &EntityType) -> Shape {
    let path = match entity {
        EntityType::Point(point) => return Shape::Point(flat(point.location)),
        EntityType::Text(text) => {
            let at =
                planar(text.normal).map_or([0.0; 2], |ocs| ocs.point(flat(text.insertion_point)));
            return Shape::Text { at, text: text.value.clone() };
        }
        EntityType::MText(text) => {
            let words = parse_mtext(&text.value, true).to_plain_text();
            return Shape::Text { at: flat(text.insertion_point), text: words };
        }
        EntityType::Hatch(hatch) => return hatch_shape(hatch),
        EntityType::Line(line) => {
            let curve = Curve::Segment { from: flat(line.start), to: flat(line.end) };
            Ok(Path { curves: vec![curve], is_closed: false })
        }
        EntityType::Circle(circle) => circle_path(circle),
        EntityType::Arc(arc) => arc_path(arc),
        EntityType::Ellipse(ellipse) => ellipse_path(ellipse),
        EntityType::Spline(spline) => spline_path(spline),
        EntityType::LwPolyline(polyline) => lwpolyline_path(polyline),
        EntityType::Polyline2D(polyline) => polyline_path(polyline),
        EntityType::Polyline(polyline) => {
            let corners = polyline.vertices.iter().map(|vertex| vertex.location);
            corner_path(&corners.collect::<Vec<_>>(), polyline.flags.is_closed())
        }
        EntityType::Polyline3D(polyline) => match spatial_path(polyline) {
            Some(path) => path,
            None => return Shape::Other,
        },
        EntityType::Solid(solid) => return filled_shape(solid_path(solid)),
        EntityType::Face3D(face) => {
            let corners = [face.first_corner, face.second_corner, face.third_corner];
            return filled_shape(corner_path(&four(corners, face.fourth_corner), true));
        }
        _ => return Shape::Other,
    };
    // A path without curves is no geometry; neither are numbers that are none.
    let checked = path.and_then(|path| path.check().map(|()| path).map_err(Unread::NoCurve));
    match checked {
        Ok(path) => Shape::Path(path),
        Err(why) => Shape::Unread { why, block: None },
    }
}

/// A point of a curve, for messages: the centre where there is one.
pub(super) fn anchor_of(curve: &Curve) -> Point {
    match curve {
        Curve::Segment { from, .. } => *from,
        Curve::Arc { centre, .. } | Curve::Ellipse { centre, .. } => *centre,
        Curve::Spline(spline) => spline.control.first().copied().unwrap_or_default(),
    }
}

fn flat(p: Vector3) -> Point {
    [p.x, p.y]
}

fn flat2(p: Vector2) -> Point {
    [p.x, p.y]
}

/// The axes of an entity in the plane.
fn ocs(normal: Vector3) -> Result<Affine, Unread> {
    planar(normal).ok_or(Unread::OutOfPlane)
}

fn circle_path(circle: &Circle) -> Result<Path, Unread> {
    let curve =
        Curve::Arc { centre: flat(circle.center), radius: circle.radius, start: 0.0, sweep: TURN };
    let path = Path { curves: vec![curve], is_closed: true };
    Ok(path.transformed(&ocs(circle.normal)?))
}

/// The way from one angle to another, counter-clockwise, greater than zero and at most a turn.
fn sweep(from: f64, to: f64) -> f64 {
    let sweep = (to - from).rem_euclid(TURN);
    if sweep <= f64::EPSILON * TURN { TURN } else { sweep }
}

fn arc_path(arc: &Arc) -> Result<Path, Unread> {
    let sweep = sweep(arc.start_angle, arc.end_angle);
    let (centre, radius) = (flat(arc.center), arc.radius);
    let curve = Curve::Arc { centre, radius, start: arc.start_angle, sweep };
    let path = Path { curves: vec![curve], is_closed: sweep == TURN };
    Ok(path.transformed(&ocs(arc.normal)?))
}

/// Ellipses are in world coordinates, and run counter-clockwise about their normal.
fn ellipse_path(ellipse: &Ellipse) -> Result<Path, Unread> {
    let side = ocs(ellipse.normal)?.x[0] * ellipse.minor_axis_ratio;
    let major = flat(ellipse.major_axis);
    let (start, end) = (ellipse.start_parameter, ellipse.end_parameter);
    let sweep = sweep(start, end);
    let minor = [-major[1] * side, major[0] * side];
    let curve = Curve::Ellipse { centre: flat(ellipse.center), major, minor, start, sweep };
    Ok(Path { curves: vec![curve], is_closed: sweep == TURN })
}

fn spline_path(entity: &SplineEntity) -> Result<Path, Unread> {
    let control: Vec<Point> = entity.control_points.iter().map(|p| flat(*p)).collect();
    let spline = if control.is_empty() {
        let points: Vec<Point> = entity.fit_points.iter().map(|p| flat(*p)).collect();
        let tangent = |v: Vector3| Some(flat(v)).filter(|t| *t != [0.0; 2]);
        Spline::through(&points, [tangent(entity.begin_tangent), tangent(entity.end_tangent)])
    } else {
        // A negative degree is as bad as none.
        let degree = usize::try_from(entity.degree).unwrap_or(0);
        Spline::new(degree, entity.knots.clone(), control, entity.weights.clone())
    };
    Ok(whole(Curve::Spline(spline.map_err(Unread::NoCurve)?)))
}

/// A path of one curve, closed if its ends meet.
fn whole(curve: Curve) -> Path {
    let is_closed = curve.start_point() == curve.end_point();
    Path { curves: vec![curve], is_closed }
}

fn lwpolyline_path(polyline: &LwPolyline) -> Result<Path, Unread> {
    let corners: Vec<Vertex> = polyline
        .vertices
        .iter()
        .map(|vertex| Vertex { at: flat2(vertex.location), bulge: vertex.bulge })
        .collect();
    let path = Path::from_bulges(&corners, polyline.is_closed).map_err(Unread::NoCurve)?;
    Ok(path.transformed(&ocs(polyline.normal)?))
}

fn polyline_path(polyline: &Polyline2D) -> Result<Path, Unread> {
    // Control points of a spline-fit polyline do not lie on the curve.
    let is_control = |flags: VertexFlags| flags.bits() & VertexFlags::SPLINE_CONTROL.bits() != 0;
    let corners: Vec<Vertex> = polyline
        .vertices
        .iter()
        .filter(|vertex| !is_control(vertex.flags))
        .map(|vertex| Vertex { at: flat(vertex.location), bulge: vertex.bulge })
        .collect();
    let path = Path::from_bulges(&corners, polyline.flags.is_closed()).map_err(Unread::NoCurve)?;
    Ok(path.transformed(&ocs(polyline.normal)?))
}

/// Largest difference of heights of points in one plane, as a part of their largest coordinate.
const LEVEL: f64 = 1e-9;

/// Straight lines from corner to corner, all at one height.
fn corner_path(corners: &[Vector3], is_closed: bool) -> Result<Path, Unread> {
    let heights = corners.iter().map(|corner| corner.z);
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    let high = heights.fold(f64::NEG_INFINITY, f64::max);
    let size =
        corners.iter().flat_map(|it| [it.x, it.y]).fold(1.0, |size: f64, x| size.max(x.abs()));
    if high - low > LEVEL * size {
        return Err(Unread::OutOfPlane);
    }
    let corners: Vec<Vertex> =
        corners.iter().map(|corner| Vertex { at: flat(*corner), bulge: 0.0 }).collect();
    Path::from_bulges(&corners, is_closed).map_err(Unread::NoCurve)
}

/// A polyline whose corners have heights of their own; `None` of a mesh, which is none.
fn spatial_path(polyline: &Polyline3D) -> Option<Result<Path, Unread>> {
    let flags = &polyline.flags;
    if flags.is_3d_mesh || flags.is_polyface_mesh {
        return None;
    }
    // Control points of a spline-fit polyline do not lie on the curve.
    let is_control = |flags: i32| flags & i32::from(VertexFlags::SPLINE_CONTROL.bits()) != 0;
    let vertices = polyline.vertices.iter().filter(|vertex| !is_control(vertex.flags));
    let corners: Vec<Vector3> = vertices.map(|vertex| vertex.position).collect();
    Some(corner_path(&corners, flags.closed))
}

/// Three corners, and a fourth unless it repeats the third.
fn four(first: [Vector3; 3], fourth: Vector3) -> Vec<Vector3> {
    let mut corners = first.to_vec();
    if fourth != first[2] {
        corners.push(fourth);
    }
    corners
}

/// The border of a filled area: its third and fourth corner are stated crosswise.
fn solid_path(solid: &Solid) -> Result<Path, Unread> {
    let map = ocs(solid.normal)?;
    let mut corners =
        four([solid.first_corner, solid.second_corner, solid.third_corner], solid.fourth_corner);
    if corners.len() == 4 {
        corners.swap(2, 3);
    }
    Ok(corner_path(&corners, true)?.transformed(&map))
}

/// A filled area, which is read as a hatch is.
fn filled_shape(border: Result<Path, Unread>) -> Shape {
    let checked = border.and_then(|path| path.check().map(|()| path).map_err(Unread::NoCurve));
    match checked {
        Ok(path) => Shape::Hatch(vec![path]),
        Err(why) => Shape::Unread { why, block: None },
    }
}

fn hatch_shape(hatch: &Hatch) -> Shape {
    let map = match ocs(hatch.normal) {
        Ok(map) => map,
        Err(why) => return Shape::Unread { why, block: None },
    };
    let drawn: Vec<Path> = hatch
        .paths
        .iter()
        .filter_map(boundary_path)
        .map(|path| path.transformed(&map))
        .filter(|path| !path.curves.is_empty())
        .collect();
    let first_fault = drawn.iter().find_map(|path| path.check().err());
    let paths: Vec<Path> = drawn.into_iter().filter(|path| path.check().is_ok()).collect();
    match (paths.is_empty(), first_fault) {
        (false, _) => Shape::Hatch(paths),
        (true, Some(fault)) => Shape::Unread { why: Unread::NoCurve(fault), block: None },
        (true, None) => Shape::Other,
    }
}

/// One boundary of a hatch; its edges follow one another.
fn boundary_path(boundary: &BoundaryPath) -> Option<Path> {
    let mut curves = Vec::new();
    for edge in &boundary.edges {
        match edge {
            BoundaryEdge::Line(line) => {
                curves.push(Curve::Segment { from: flat2(line.start), to: flat2(line.end) });
            }
            BoundaryEdge::CircularArc(arc) => {
                let angles = [arc.start_angle, arc.end_angle];
                let (start, sweep) = edge_angles(angles, arc.counter_clockwise);
                let (centre, radius) = (flat2(arc.center), arc.radius);
                curves.push(Curve::Arc { centre, radius, start, sweep });
            }
            BoundaryEdge::EllipticArc(arc) => {
                let major = flat2(arc.major_axis_endpoint);
                let ratio = arc.minor_axis_ratio;
                let minor = [-major[1] * ratio, major[0] * ratio];
                let angles = [arc.start_angle, arc.end_angle];
                let (start, sweep) = edge_angles(angles, arc.counter_clockwise);
                curves.push(Curve::Ellipse {
                    centre: flat2(arc.center),
                    major,
                    minor,
                    start,
                    sweep,
                });
            }
            BoundaryEdge::Spline(edge) => {
                // The third number of a control point is its weight.
                let control = edge.control_points.iter().map(|p| flat(*p)).collect();
                let weights = if edge.rational {
                    edge.control_points.iter().map(|p| p.z).collect()
                } else {
                    Vec::new()
                };
                let degree = usize::try_from(edge.degree).ok()?;
                let spline = Spline::new(degree, edge.knots.clone(), control, weights).ok()?;
                curves.push(Curve::Spline(spline));
            }
            BoundaryEdge::Polyline(polyline) => {
                // The third number of a vertex is its bulge.
                let corner = |p: &Vector3| Vertex { at: flat(*p), bulge: p.z };
                let corners: Vec<Vertex> = polyline.vertices.iter().map(corner).collect();
                return Path::from_bulges(&corners, true).ok();
            }
        }
    }
    Some(Path { curves, is_closed: true })
}

/// Start and sweep of an edge between two angles; clockwise edges are written with the angles of their
/// mirror image.
fn edge_angles(angles: [f64; 2], is_counter_clockwise: bool) -> (f64, f64) {
    if is_counter_clockwise {
        let [start, end] = angles;
        (start, sweep(start, end))
    } else {
        let [start, end] = angles.map(|angle| -angle);
        (start, -sweep(end, start))
    }
}
