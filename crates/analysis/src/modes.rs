//! Modes: frequencies, damping and shapes of small motions about an equilibrium.
//!
//! ```text
//! (M_r s² + C_r s + K_r) y = 0
//! ```
//!
//! Motions without inertia have no frequency: they are taken out before, as y₂ = −K₂₂⁻¹ K₂₁ y₁ where
//! nothing damps them, as ẏ₂ = −C₂₂⁻¹ (…) where something does, and counted as infinite.

use bksim_expr::{Expr, Tape};
use bksim_mbs::inertia::central_inertia;
use bksim_mbs::spatial;
use bksim_model::{BodyId, Model};
use nalgebra::{Complex, DMatrix, DVector};

use crate::balance::Balance;
use crate::equilibrium::Stability;
use crate::error::AnalysisError;
use crate::forces::At;
use crate::linear::{About, pseudo_inverse};
use crate::loaded::Loaded;
use crate::quantity::PoseQuantity;
use crate::table::{Column, Table};

/// One motion y e^{s t}; of a pair of complex ones that with Im s > 0.
#[derive(Clone, PartialEq, Debug)]
pub struct Mode {
    /// s, 1/s: real and imaginary part.
    pub s: [f64; 2],
    /// |s|, rad/s: the angular frequency without damping.
    pub omega: f64,
    /// −Re s/|s|; zero for s = 0.
    pub damping: f64,
    /// Changes of joint positions, body angles and points, real and imaginary parts; the largest of the body
    /// angles, else of all, is 1.
    pub shape: Vec<[f64; 2]>,
    /// Changes of the generalised coordinates to the same scale.
    pub coordinates: Vec<[f64; 2]>,
    /// Part of each body in the kinetic energy of the mode; the ground is left out.
    pub shares: Vec<f64>,
}

/// The modes about an equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct Modes {
    /// Ascending by |s|.
    pub modes: Vec<Mode>,
    /// Number of modes without a finite frequency, of motions without inertia.
    pub n_infinite: usize,
    /// Names and units of the entries of a shape.
    pub quantities: Vec<Column>,
    /// Names of the bodies, for the shares.
    pub bodies: Vec<String>,
    /// Generalised coordinates of the equilibrium.
    pub q: Vec<f64>,
    /// Stability of the equilibrium.
    pub stability: Stability,
    /// Stops and friction that count as constraints.
    pub held: Vec<String>,
}

/// Finds the modes of `model` about the equilibrium nearest to the start, or about the start itself, which
/// must be at rest then.
///
/// # Errors
/// [`AnalysisError`] when there is no equilibrium.
pub fn modes(model: Model, about: About) -> Result<Modes, AnalysisError> {
    modes_of(&Loaded::of(model)?, about)
}

/// The modes of a mechanism whose start is found.
pub(crate) fn modes_of(loaded: &Loaded, about: About) -> Result<Modes, AnalysisError> {
    let mut balance = Balance::of(loaded, &[], &[])?;
    let found = match about {
        About::Static => balance.nearest()?,
        About::Start => balance.equilibrium(&loaded.q)?,
    };
    let lambda: Vec<f64> = loaded.kept.iter().map(|&row| found.lambda[row]).collect();
    let rest = vec![0.0; found.q.len()];
    let at = balance.forces.at(At {
        t: loaded.t,
        q: &found.q,
        v: &rest,
        a: &rest,
        lambda: &lambda,
        p: &[],
    });
    let reduced = balance.reduced(&found.q, &at.jacobian)?;
    let pencil = Pencil {
        mass: reduced.project(&at.mass),
        damping: reduced.project(&at.damping),
        stiffness: reduced.project(&at.stiffness),
    };

    // Finite modes, then shapes of all bodies and shares of energy.
    let (values, n_infinite) = pencil.finite_eigenvalues();
    let vectors = pencil.vectors(&values);
    let mut energies = Energies::compile(loaded)?;
    let mut scalars = loaded.scalars(&loaded.quantities)?;
    let mut modes = Vec::new();
    for (s, y) in values.iter().zip(vectors) {
        let parts = [y.map(|c| c.re), y.map(|c| c.im)].map(|part| &reduced.basis * part);
        let along = parts.each_ref().map(|part| scalars.along(loaded.t, &found.q, part.as_slice()));
        let mut shape: Vec<Complex<f64>> =
            along[0].iter().zip(&along[1]).map(|(re, im)| Complex::new(*re, *im)).collect();
        let unit = unit_of(&shape, &loaded.quantities, loaded.model());
        for c in &mut shape {
            *c /= unit;
        }
        let pairs = parts[0].iter().zip(parts[1].iter());
        let coordinates = pairs.map(|(re, im)| Complex::new(*re, *im) / unit);
        let shares = energies.shares(loaded, &found.q, parts.each_ref().map(DVector::as_slice));
        let omega = s.norm();
        modes.push(Mode {
            s: [s.re, s.im],
            omega,
            damping: if omega > 0.0 { -s.re / omega } else { 0.0 },
            shape: shape.iter().map(|c| [c.re, c.im]).collect(),
            coordinates: coordinates.map(|c| [c.re, c.im]).collect(),
            shares,
        });
    }
    let columns = loaded.quantities.iter().map(|q| Column::new(q.names[0].clone(), q.unit));
    Ok(Modes {
        modes,
        n_infinite,
        quantities: columns.collect(),
        bodies: loaded.model().bodies.iter().skip(1).map(|body| body.name.clone()).collect(),
        stability: found.stability,
        q: found.q,
        held: loaded.held_contacts(),
    })
}

impl Modes {
    /// A row for each mode: s, ω, frequency, damping ratio, shares, shape.
    pub fn table(&self) -> Table {
        let heads = [
            ("re", "1/s"),
            ("im", "1/s"),
            ("omega", "rad/s"),
            ("frequency", "Hz"),
            ("damping", ""),
        ];
        let mut columns: Vec<Column> =
            heads.iter().map(|(name, unit)| Column::new(*name, *unit)).collect();
        columns.extend(self.bodies.iter().map(|body| Column::new(format!("share.{body}"), "")));
        for quantity in &self.quantities {
            for part in ["re", "im"] {
                columns
                    .push(Column::new(format!("{}.{part}", quantity.name), quantity.unit.clone()));
            }
        }
        let row = |mode: &Mode| {
            let first = [
                mode.s[0],
                mode.s[1],
                mode.omega,
                mode.omega / std::f64::consts::TAU,
                mode.damping,
            ];
            first
                .into_iter()
                .chain(mode.shares.iter().copied())
                .chain(mode.shape.iter().flatten().copied())
                .collect()
        };
        Table { columns, rows: self.modes.iter().map(row).collect() }
    }
}

/// M s² + C s + K.
struct Pencil {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

/// Part of the largest mass below which one counts as none.
const NO_MASS: f64 = 1e-13;
/// Part of the largest damping below which one counts as none.
const NO_DAMPING: f64 = 1e-13;

impl Pencil {
    /// Eigenvalues with Im s ≥ 0, ascending by size, and the number of those that are infinite.
    fn finite_eigenvalues(&self) -> (Vec<Complex<f64>>, usize) {
        let n = self.mass.nrows();
        if n == 0 {
            return (Vec::new(), 0);
        }
        let undamped =
            self.damping.norm() <= 1e-14 * (self.mass.norm() * self.stiffness.norm()).sqrt();
        let asymmetry = (&self.stiffness - self.stiffness.transpose()).norm();
        let masses = (&self.mass + self.mass.transpose()) * 0.5;
        let eigen = masses.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(0.0, |a: f64, b| a.max(*b));
        let (heavy, light): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&k| eigen.eigenvalues[k] > NO_MASS * largest);
        // Coordinates in which M is one on `heavy` directions and zero on the others.
        let basis = |which: &[usize], unit: bool| {
            DMatrix::from_fn(n, which.len(), |i, k| {
                let mass = eigen.eigenvalues[which[k]];
                eigen.eigenvectors[(i, which[k])] / if unit { mass.sqrt() } else { 1.0 }
            })
        };
        let (h, l) = (basis(&heavy, true), basis(&light, false));

        // Of the light directions some are damped.
        let (damped, directions) = symmetric(&(l.transpose() * &self.damping * &l));
        let most = self.damping.norm();
        let (slow, idle): (Vec<usize>, Vec<usize>) =
            (0..light.len()).partition(|&k| most > 0.0 && damped[k].abs() > NO_DAMPING * most);
        let pick = |which: &[usize]| {
            DMatrix::from_fn(light.len(), which.len(), |i, k| directions[(i, which[k])])
        };
        let (l1, l2) = (&l * pick(&slow), &l * pick(&idle));

        // Idle directions follow the others: y₂ = −K₂₂⁻¹ K₂ y.
        let k22 = l2.transpose() * &self.stiffness * &l2;
        let follow = |x: &DMatrix<f64>| {
            let pulled = l2.transpose() * &self.stiffness * x;
            x - &l2 * (pseudo_inverse(&k22) * pulled)
        };
        let (h, l1) = (follow(&h), follow(&l1));
        let (nh, n1) = (h.ncols(), l1.ncols());
        let on = |x: &DMatrix<f64>, a: &DMatrix<f64>, y: &DMatrix<f64>| x.transpose() * a * y;
        let k_hh = on(&h, &self.stiffness, &h);
        let mut values: Vec<Complex<f64>> =
            if undamped && n1 == 0 && asymmetry <= 1e-11 * self.stiffness.norm() {
                // ω² are the eigenvalues of a symmetric matrix.
                let (squares, _) = symmetric(&k_hh);
                let size = squares.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                let of = |square: f64| {
                    if square.abs() <= 1e-13 * size {
                        vec![Complex::new(0.0, 0.0)]
                    } else if square > 0.0 {
                        vec![Complex::new(0.0, square.sqrt())]
                    } else {
                        let rate = (-square).sqrt();
                        vec![Complex::new(rate, 0.0), Complex::new(-rate, 0.0)]
                    }
                };
                squares.iter().flat_map(|&square| of(square)).collect()
            } else {
                // x = (y_h, ẏ_h, y_1).
                let size = 2 * nh + n1;
                let mut a = DMatrix::zeros(size, size);
                a.view_mut((0, nh), (nh, nh)).fill_with_identity();
                let c11 = pseudo_inverse(&on(&l1, &self.damping, &l1));
                // ẏ_1 = −C₁₁⁻¹ (K_1h y_h + C_1h ẏ_h + K_11 y_1).
                let rate = [
                    -(&c11 * on(&l1, &self.stiffness, &h)),
                    -(&c11 * on(&l1, &self.damping, &h)),
                    -(&c11 * on(&l1, &self.stiffness, &l1)),
                ];
                let c_h1 = on(&h, &self.damping, &l1);
                let own = [-k_hh, -on(&h, &self.damping, &h), -on(&h, &self.stiffness, &l1)];
                let columns = [0, nh, 2 * nh];
                for ((own, rate), &column) in own.iter().zip(&rate).zip(&columns) {
                    let width = own.ncols();
                    a.view_mut((nh, column), (nh, width)).copy_from(&(own - &c_h1 * rate));
                    a.view_mut((2 * nh, column), (n1, width)).copy_from(rate);
                }
                let all = a.complex_eigenvalues();
                let values: Vec<Complex<f64>> = all.iter().copied().collect();
                values.into_iter().map(|s| self.polished(s)).filter(|s| s.im >= 0.0).collect()
            };
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(a.re.total_cmp(&b.re)));
        (values, light.len())
    }

    fn at(&self, s: Complex<f64>) -> DMatrix<Complex<f64>> {
        let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
        complex(&self.mass) * (s * s) + complex(&self.damping) * s + complex(&self.stiffness)
    }

    /// An eigenvalue after Newton's steps on uᴴ P(s) x = 0, with the singular vectors of P.
    fn polished(&self, s: Complex<f64>) -> Complex<f64> {
        let is_real = s.im == 0.0;
        let mut best = s;
        for _ in 0..3 {
            let svd = self.at(best).svd(true, true);
            let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else { return best };
            let last = least(&svd.singular_values);
            let x = v_t.row(last).adjoint();
            let left = u.column(last).adjoint();
            let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
            let slope = complex(&self.mass) * (best * 2.0) + complex(&self.damping);
            let value = (&left * self.at(best) * &x)[(0, 0)];
            let slope = (&left * slope * &x)[(0, 0)];
            let step = value / slope;
            if !(step.re.is_finite() && step.im.is_finite()) || step.norm() > 1e-4 * best.norm() {
                return best;
            }
            best -= step;
            if is_real {
                best.im = 0.0;
            }
        }
        best
    }

    /// An eigenvector for each eigenvalue; for equal ones, different ones.
    fn vectors(&self, values: &[Complex<f64>]) -> Vec<DVector<Complex<f64>>> {
        let mut met: Vec<Complex<f64>> = Vec::new();
        let vector = |&s: &Complex<f64>| {
            let same = met.iter().filter(|&&other| (other - s).norm() <= 1e-9 * s.norm()).count();
            met.push(s);
            let svd = self.at(s).svd(false, true);
            let Some(v_t) = svd.v_t else { return DVector::zeros(self.mass.nrows()) };
            let mut order: Vec<usize> = (0..svd.singular_values.len()).collect();
            order.sort_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
            v_t.row(order[same.min(order.len() - 1)]).adjoint()
        };
        values.iter().map(vector).collect()
    }
}

/// Eigenvalues and vectors of the symmetric part of a matrix, which may be empty.
fn symmetric(matrix: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    if matrix.is_empty() {
        return (DVector::zeros(0), DMatrix::zeros(0, 0));
    }
    let eigen = ((matrix + matrix.transpose()) * 0.5).symmetric_eigen();
    (eigen.eigenvalues, eigen.eigenvectors)
}

/// The place of the smallest.
fn least(values: &DVector<f64>) -> usize {
    (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// The largest body angle of a shape, or, where no body turns, its largest entry; one where all are zero.
fn unit_of(shape: &[Complex<f64>], quantities: &[PoseQuantity], model: &Model) -> Complex<f64> {
    let is_body_angle = |quantity: &PoseQuantity| {
        model.bodies.iter().any(|body| quantity.names[0] == format!("{}.angle", body.name))
    };
    let largest = |which: &dyn Fn(&PoseQuantity) -> bool| {
        let entries = shape.iter().zip(quantities).filter(|(_, quantity)| which(quantity));
        entries.map(|(c, _)| *c).max_by(|a, b| a.norm().total_cmp(&b.norm()))
    };
    let whole = largest(&|_| true).map_or(0.0, Complex::norm);
    let by_angle = largest(&is_body_angle).filter(|c| c.norm() > 1e-9 * whole);
    let unit = by_angle.or_else(|| largest(&|_| true)).filter(|c| c.norm() > 0.0);
    unit.unwrap_or(Complex::new(1.0, 0.0))
}

/// Kinetic energies of the bodies as functions of q and v.
struct Energies {
    tape: Tape,
}

impl Energies {
    fn compile(loaded: &Loaded) -> Result<Self, AnalysisError> {
        let model = loaded.model();
        let pool = &model.pool;
        let system = loaded.system();
        let kinematics = &system.kinematics;
        let half = pool.rational(1, 2);
        let energy = |id: usize| -> Expr {
            let body = &model.bodies[id];
            let p_world_com = kinematics.position(model, BodyId(id), None);
            let v_world_com = p_world_com.map(|component| kinematics.rate(model, component));
            let pose = &kinematics.poses[id];
            let omega = pose.rotation.apply_inverse(pool, &pose.omega);
            let inertia = central_inertia(model, BodyId(id));
            let spin = inertia.map(|row| spatial::dot(pool, &row, &omega));
            let moving = pool.mul(body.mass, spatial::dot(pool, &v_world_com, &v_world_com));
            pool.mul(half, pool.add(moving, spatial::dot(pool, &spin, &omega)))
        };
        let energies: Vec<Expr> = (1..model.bodies.len()).map(energy).collect();
        let coordinates = system.coordinates();
        let arguments: Vec<_> =
            coordinates.iter().map(|c| c.q).chain(coordinates.iter().map(|c| c.v)).collect();
        let symbols = system.parameters(model);
        Ok(Self { tape: Tape::compile(pool, &energies, &arguments, &symbols)? })
    }

    /// Part of each body in the kinetic energy of velocities with real and imaginary `parts`.
    fn shares(&mut self, loaded: &Loaded, q: &[f64], parts: [&[f64]; 2]) -> Vec<f64> {
        let mut workspace = self.tape.workspace(&loaded.parameters);
        let mut sums = vec![0.0; self.tape.n_outputs()];
        for v in parts {
            let mut energies = vec![0.0; sums.len()];
            self.tape.evaluate(&mut workspace, &[q, v].concat(), &mut energies);
            sums.iter_mut().zip(energies).for_each(|(sum, energy)| *sum += energy);
        }
        let whole: f64 = sums.iter().sum();
        sums.iter().map(|sum| if whole > 0.0 { sum / whole } else { 0.0 }).collect()
    }
}
