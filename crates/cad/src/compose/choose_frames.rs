//! Frames of bodies that state none.

use super::bodies::{Bodies, GROUND};
use super::connect::Connection;
use super::frame::Frame;
use crate::geometry::Point;
use crate::geometry::vector::distance;

/// The frame of every body: that of the world for the ground, the stated one, or the natural one.
pub(super) fn choose_frames(
    bodies: &Bodies,
    connections: &[Connection<'_>],
    tolerance: f64,
) -> Vec<Frame> {
    let frame = |(body_idx, stated): (usize, Option<Frame>)| match stated {
        _ if body_idx == GROUND => Frame::default(),
        Some(stated) => stated,
        None => natural_frame(body_idx, connections, tolerance),
    };
    bodies.list.iter().map(|body| body.frame).enumerate().map(frame).collect()
}

/// A frame at a body's first pin, one with the ground if there is one; along its slide on the ground,
/// else towards its next pin.
fn natural_frame(body_idx: usize, connections: &[Connection<'_>], tolerance: f64) -> Frame {
    let mut pins: Vec<(bool, Point)> = Vec::new();
    let mut slides: Vec<(Point, Option<Point>)> = Vec::new();
    for connection in connections {
        for end_idx in 0..2 {
            let other = connection.bodies[1 - end_idx];
            if connection.bodies[end_idx] != body_idx {
                continue;
            }
            let at = connection.at[end_idx];
            match (connection.attachment.kind.name, end_idx) {
                ("prismatic", _) => {
                    let axis = connection.attachment.axis.filter(|_| other == GROUND);
                    slides.push((at, axis));
                }
                // Of a slot, the first body has the slot and the second the pin.
                ("slot", 0) => slides.push((at, None)),
                _ => pins.push((other != GROUND, at)),
            }
        }
    }

    // The sort is stable: within the two groups the order is that of the drawing.
    pins.sort_by_key(|(is_inner, _)| *is_inner);
    let pins: Vec<Point> = pins.into_iter().map(|(_, at)| at).collect();
    let origin = pins.first().or(slides.first().map(|(at, _)| at)).copied();
    // A body without joints has its frame where the world has it.
    let origin = origin.unwrap_or_default();

    let next = pins.iter().find(|at| distance(**at, origin) > tolerance);
    let towards = next.map(|next| [next[0] - origin[0], next[1] - origin[1]]);
    let slide = slides.iter().find_map(|(_, axis)| *axis);
    match slide.or(towards) {
        Some(axis) => Frame::along(origin, axis),
        None => Frame { origin, angle: 0.0 },
    }
}
