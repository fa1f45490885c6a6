//! Turns of vectors and of tensors of inertia between two frames, by an angle or by a matrix.

use bksim_expr::{Expr, Pool};
use bksim_model::Vector;

use crate::spatial;

/// A turn of an inner frame against an outer one.
#[derive(Clone, Debug)]
pub(super) enum LinkTurn {
    /// About an axis that both share.
    About { axis: TurnAxis, cos: Expr, sin: Expr },
    /// By the rows of R.
    Matrix([Vector; 3]),
}

#[derive(Clone, Debug)]
pub(super) enum TurnAxis {
    /// x, y or z.
    Coordinate(usize),
    /// A unit vector.
    Other(Vector),
}

impl LinkTurn {
    /// The turn by `angle`, rad, about the unit vector `axis`.
    pub(super) fn about(pool: &Pool, axis: &Vector, angle: Expr) -> Self {
        let along = |sign: Expr| {
            let others_vanish = |k: usize| (0..3).all(|i| i == k || pool.is_zero(axis[i]));
            (0..3).find(|&k| axis[k] == sign && others_vanish(k))
        };
        let (axis, angle) = match (along(pool.one()), along(pool.int(-1))) {
            (Some(k), _) => (TurnAxis::Coordinate(k), angle),
            (_, Some(k)) => (TurnAxis::Coordinate(k), pool.neg(angle)),
            _ => (TurnAxis::Other(*axis), angle),
        };
        Self::About { axis, cos: pool.cos(angle), sin: pool.sin(angle) }
    }

    /// No turn.
    pub(super) fn none(pool: &Pool) -> Self {
        Self::About { axis: TurnAxis::Coordinate(2), cos: pool.one(), sin: pool.zero() }
    }

    /// R u: a vector of the inner frame, in the outer one.
    pub(super) fn to_outer(&self, pool: &Pool, u: &Vector) -> Vector {
        match self {
            Self::About { axis, cos, sin } => turned(pool, axis, u, [*cos, *sin]),
            Self::Matrix(rows) => rows.map(|row| spatial::dot(pool, &row, u)),
        }
    }

    /// Rᵀ u: a vector of the outer frame, in the inner one.
    pub(super) fn to_inner(&self, pool: &Pool, u: &Vector) -> Vector {
        match self {
            Self::About { axis, cos, sin } => turned(pool, axis, u, [*cos, pool.neg(*sin)]),
            Self::Matrix(rows) => {
                std::array::from_fn(|j| spatial::dot(pool, &rows.map(|row| row[j]), u))
            }
        }
    }

    /// R J Rᵀ: a symmetric tensor of the inner frame, in the outer one.
    pub(super) fn tensor_to_outer(&self, pool: &Pool, tensor: &[Vector; 3]) -> [Vector; 3] {
        if let Self::About { axis: TurnAxis::Coordinate(k), cos, sin } = self {
            return plane_to_outer(pool, tensor, *k, [*cos, *sin]);
        }
        let columns = tensor.map(|column| self.to_outer(pool, &column));
        let rows = std::array::from_fn(|i| columns.map(|column| column[i]));
        rows.map(|row| self.to_outer(pool, &row))
    }
}

/// About z, with w = s (J_yy − J_xx) − 2 c J_xy:
/// J_xx + s w, J_yy − s w, −J_xy − c w; (J_xz, J_yz) turns as a vector.
fn plane_to_outer(pool: &Pool, tensor: &[Vector; 3], k: usize, [c, s]: [Expr; 2]) -> [Vector; 3] {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let difference = pool.sub(tensor[j][j], tensor[i][i]);
    let doubled = pool.mul(pool.int(2), tensor[i][j]);
    let w = pool.sub(pool.mul(s, difference), pool.mul(c, doubled));
    let mut outer = *tensor;
    outer[i][i] = pool.add(tensor[i][i], pool.mul(s, w));
    outer[j][j] = pool.sub(tensor[j][j], pool.mul(s, w));
    outer[i][j] = pool.neg(pool.add(tensor[i][j], pool.mul(c, w)));
    outer[i][k] = pool.sub(pool.mul(c, tensor[i][k]), pool.mul(s, tensor[j][k]));
    outer[j][k] = pool.add(pool.mul(s, tensor[i][k]), pool.mul(c, tensor[j][k]));
    for (a, b) in [(i, j), (i, k), (j, k)] {
        outer[b][a] = outer[a][b];
    }
    outer
}

fn turned(pool: &Pool, axis: &TurnAxis, u: &Vector, [c, s]: [Expr; 2]) -> Vector {
    match axis {
        TurnAxis::Coordinate(k) => {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let mut turned = *u;
            turned[i] = pool.sub(pool.mul(c, u[i]), pool.mul(s, u[j]));
            turned[j] = pool.add(pool.mul(s, u[i]), pool.mul(c, u[j]));
            turned
        }
        // Rodrigues' formula: c u + s n × u + (1 − c) (n · u) n.
        TurnAxis::Other(n) => {
            let along = pool.mul(pool.sub(pool.one(), c), spatial::dot(pool, n, u));
            let across = spatial::scale(pool, s, &spatial::cross(pool, n, u));
            let turned = spatial::add(pool, &spatial::scale(pool, c, u), &across);
            spatial::add(pool, &turned, &spatial::scale(pool, along, n))
        }
    }
}
