//! Curves of the plane cut into pieces, of which some bound a workspace.

use crate::double_points::cross;

/// Critical curves, cut where they cross each other and themselves.
pub(super) fn pieces(critical: &[Vec<[f64; 2]>], size: f64) -> Vec<Vec<[f64; 2]>> {
    let chords: Vec<(usize, usize)> = critical
        .iter()
        .enumerate()
        .flat_map(|(of, way)| (1..way.len()).map(move |k| (of, k - 1)))
        .collect();
    let ends = |&(of, k): &(usize, usize)| [critical[of][k], critical[of][k + 1]];
    let mut cuts: Vec<Vec<(usize, f64, [f64; 2])>> = vec![Vec::new(); critical.len()];
    for (i, a) in chords.iter().enumerate() {
        for b in &chords[i + 1..] {
            let (p, q) = (ends(a), ends(b));
            let is_apart = (0..2).any(|axis| {
                p[0][axis].max(p[1][axis]) < q[0][axis].min(q[1][axis])
                    || q[0][axis].max(q[1][axis]) < p[0][axis].min(p[1][axis])
            });
            let are_neighbours = a.0 == b.0 && a.1.abs_diff(b.1) <= 1;
            if is_apart || are_neighbours || !cross(p, q) {
                continue;
            }
            let [u, v] = [p, q].map(|[a, b]| [b[0] - a[0], b[1] - a[1]]);
            let across = u[0] * v[1] - u[1] * v[0];
            // Curves that lie on each other do not cross.
            if across.abs() < 1e-3 * u[0].hypot(u[1]) * v[0].hypot(v[1]) {
                continue;
            }
            let off = [q[0][0] - p[0][0], q[0][1] - p[0][1]];
            let share = (off[0] * v[1] - off[1] * v[0]) / across;
            let of_other = (off[0] * u[1] - off[1] * u[0]) / across;
            let at = [p[0][0] + share * u[0], p[0][1] + share * u[1]];
            cuts[a.0].push((a.1, share, at));
            cuts[b.0].push((b.1, of_other, at));
        }
    }
    let mut all = Vec::new();
    for (way, mut cuts) in critical.iter().zip(cuts) {
        cuts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut piece: Vec<[f64; 2]> = Vec::new();
        let mut cuts = cuts.into_iter().peekable();
        for (k, &p) in way.iter().enumerate() {
            piece.push(p);
            while let Some((_, _, at)) = cuts.next_if(|cut| cut.0 == k) {
                piece.push(at);
                all.push(std::mem::replace(&mut piece, vec![at]));
            }
        }
        all.push(piece);
    }
    let extent = |piece: &Vec<[f64; 2]>| {
        piece.iter().map(|p| (p[0] - piece[0][0]).hypot(p[1] - piece[0][1])).fold(0.0, f64::max)
    };
    all.retain(|piece| piece.len() > 1 && extent(piece) > 1e-9 * size);
    all
}
