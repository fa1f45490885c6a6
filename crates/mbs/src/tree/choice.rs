//! The choice of coordinates where the author leaves it open: those whose equations are cheaper.

use bksim_model::{Model, Space};

use super::{Branch, Tree};

/// Deepest chain of relative coordinates in the plane: the equations of a chain of N relative angles grow as N³,
/// those of absolute coordinates as N.
const DEEPEST_RELATIVE_CHAIN: usize = 10;

/// Entries of M on and below its diagonal of a body in space by its own coordinates: its mass three times, and the
/// block of its quaternion.
const OF_MOVING_BODY: usize = 13;

/// Entries of G of the length of a quaternion.
const OF_LENGTH: usize = 4;

/// Coordinates of the two bodies of a joint, which its rows depend on.
const OF_TWO_BODIES: usize = 14;

/// Cost of an entry of M in relative coordinates by one of M or G in absolute ones. Measured on hanging chains in space,
/// whole solves of 2 s at 10⁻⁶ in instructions: with ball joints absolute coordinates are cheaper from three bodies
/// on, with revolutes far beyond thirty.
const OF_RELATIVE_ENTRY: usize = 2;

/// True where the equations along a tree are cheaper than those with all of its joints cut.
pub(super) fn is_short(model: &Model, tree: &Tree) -> bool {
    match model.space {
        Space::Planar => tree.depth() <= DEEPEST_RELATIVE_CHAIN,
        Space::Spatial => {
            let [of_relative, of_absolute] = n_entries(model, tree);
            OF_RELATIVE_ENTRY * of_relative <= of_absolute
        }
    }
}

/// Entries of the bodies that joints of the tree carry, in the coordinates of these joints and in those of the bodies:
/// in relative coordinates M couples each of them with all before it.
fn n_entries(model: &Model, tree: &Tree) -> [usize; 2] {
    let mut n_before = vec![0; model.bodies.len()];
    let [mut of_relative, mut of_absolute] = [0, 0];
    for &(body, branch) in &tree.branches {
        let Branch::Joint { joint, parent, .. } = branch else {
            n_before[body.0] = OF_TWO_BODIES / 2;
            continue;
        };
        let kind = &model.joints[joint.0].kind;
        let n_own = kind.motions().len() + usize::from(kind.turns_freely());
        n_before[body.0] = n_before[parent.0] + n_own;
        of_relative += n_own * n_before[parent.0] + n_own * (n_own + 1) / 2;
        let n_rows = usize::try_from(kind.n_taken(Space::Spatial)).unwrap_or(0);
        of_absolute += OF_MOVING_BODY + OF_LENGTH + OF_TWO_BODIES * n_rows;
    }
    [of_relative, of_absolute]
}
