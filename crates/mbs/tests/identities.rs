//! Identities of mechanics that the equations of any mechanism fulfil, at random states.
//!
//! Derivatives on the other side of an identity are central differences of values, so that no
//! derivative of the pool is compared with itself.

use std::ops::Range;

use bksim_expr::{Expr, Tape};
use bksim_mbs::assemble::assemble_by;
use bksim_mbs::constraint::Source as RowSource;
use bksim_mbs::force::Wrench;
use bksim_mbs::levels::constraint_gamma;
use bksim_mbs::system::{Derivation, SymbolicSystem};
use bksim_model::file::{Source, read};
use bksim_model::{CoordinatePolicy, Model};

/// Two bars on skew axes, the second also sliding, closed by a link and driven.
const SPATIAL_LOOP: &str = include_str!("../../../tests/fixtures/spatial-loop.toml");

/// A pendulum of three bars about unlike axes, with springs in its joints.
const SPATIAL_CHAIN: &str = include_str!("../../../tests/fixtures/spatial-chain.toml");

/// A free body with two others on ball joints, and a loop over two of these: quaternions.
const TUMBLING_ARM: &str = include_str!("../../../tests/fixtures/tumbling-arm.toml");
const SPATIAL_FOUR_BAR: &str = include_str!("../../../tests/fixtures/spatial-four-bar.toml");

/// Wheels on a carrier, a rack, a screw and a belt, all of them moving; and bevel gears in space.
const PLANETARY_GEAR: &str = include_str!("../../../tests/fixtures/planetary-gear.toml");
const DIFFERENTIAL: &str = include_str!("../../../tests/fixtures/elements/differential.toml");

/// States that are looked at for each mechanism.
const N_STATES: usize = 4;
/// Step of the central differences.
const STEP: f64 = 1e-5;

#[test]
fn the_mass_matrix_is_symmetric_and_definite_and_gives_the_kinetic_energy() {
    for mechanism in mechanisms() {
        for state in mechanism.states() {
            let at = mechanism.at(&state);
            let nq = mechanism.nq;
            for (i, j) in pairs(nq) {
                let [m, transposed] = [at.mass[i * nq + j], at.mass[j * nq + i]];
                mechanism.close("M − Mᵀ", m, transposed, 0.0);
            }
            // A point mass with an angle of its own has a row of zeros.
            let with_inertia: Vec<usize> = (0..nq).filter(|i| at.mass[i * nq + i] != 0.0).collect();
            let pivot = smallest_pivot(&at.mass, nq, &with_inertia);
            assert!(pivot > 0.0, "{}: pivot {pivot}", mechanism.name);
            for (i, j) in pairs(nq).filter(|(i, _)| !with_inertia.contains(i)) {
                mechanism.close("a row without inertia", at.mass[i * nq + j], 0.0, 0.0);
            }
            let doubled: f64 =
                pairs(nq).map(|(i, j)| at.mass[i * nq + j] * state.v[i] * state.v[j]).sum();
            mechanism.close("T − ½ vᵀ M v", at.kinetic_energy, 0.5 * doubled, 1e-10);
        }
    }
}

#[test]
fn the_bias_is_that_of_the_christoffel_sums_and_does_no_work_beyond_the_mass_matrix() {
    for mechanism in mechanisms() {
        for state in mechanism.states() {
            let (at, nq) = (mechanism.at(&state), mechanism.nq);
            // ∂M/∂q_k by differences.
            let slopes: Vec<Vec<f64>> =
                (0..nq).map(|k| mechanism.slope(&state.along_q(k), |at| at.mass.clone())).collect();
            let slope = |i: usize, j: usize, k: usize| slopes[k][i * nq + j];
            // C_ij = ½ Σ_k (∂M_ij/∂q_k + ∂M_ik/∂q_j − ∂M_jk/∂q_i) v_k.
            let c = |i: usize, j: usize| -> f64 {
                let term = |k| (slope(i, j, k) + slope(i, k, j) - slope(j, k, i)) * state.v[k];
                0.5 * (0..nq).map(term).sum::<f64>()
            };
            for i in 0..nq {
                let h: f64 = (0..nq).map(|j| c(i, j) * state.v[j]).sum();
                mechanism.close("h − C v", at.bias[i], h, 1e-6);
            }
            // vᵀ (Ṁ − 2 C) v = 0 with C v from the equations and Ṁ by a difference along v.
            let turned = mechanism.slope(&state.along(&state.v, 0.0), |at| at.mass.clone());
            let power: f64 =
                pairs(nq).map(|(i, j)| turned[i * nq + j] * state.v[i] * state.v[j]).sum();
            let bias: f64 = at.bias.iter().zip(&state.v).map(|(h, v)| h * v).sum();
            mechanism.close("vᵀ Ṁ v − 2 vᵀ h", power, 2.0 * bias, 1e-6);
            for (i, j) in pairs(nq) {
                let [one, other] =
                    [(i, j), (j, i)].map(|(i, j)| turned[i * nq + j] - 2.0 * c(i, j));
                mechanism.close("Ṁ − 2 C is skew", one, -other, 1e-6);
            }
        }
    }
}

#[test]
fn the_potential_gradient_is_the_slope_of_the_potential() {
    for mechanism in mechanisms() {
        for state in mechanism.states() {
            let at = mechanism.at(&state);
            for k in 0..mechanism.nq {
                let slope = mechanism.slope(&state.along_q(k), |at| vec![at.potential_energy])[0];
                // Differences of V lose the digits that V has more than its slope.
                let scale = 1.0 + at.potential_energy.abs();
                mechanism.close("∂V/∂q", at.potential_gradient[k] / scale, slope / scale, 1e-7);
            }
        }
    }
}

#[test]
fn multipliers_act_as_the_wrenches_of_their_rows() {
    for mechanism in mechanisms() {
        for state in mechanism.states() {
            let (at, nq) = (mechanism.at(&state), mechanism.nq);
            // ∂r/∂q and ∂ω/∂v of the bodies, by differences.
            let bodies = mechanism.model.bodies.len();
            for i in 0..nq {
                let shift = mechanism.slope(&state.along_q(i), |at| at.positions.clone());
                let turn = mechanism.slope(&state.along_v(i), |at| at.omegas.clone());
                assert_eq!((shift.len(), turn.len()), (3 * bodies, 3 * bodies));
                let mut first = 0;
                for (row, constraint) in mechanism.system.constraints.iter().enumerate() {
                    // No wrench keeps the length of a quaternion.
                    if let RowSource::Quaternion(_) = constraint.source {
                        continue;
                    }
                    // Power of the wrenches per rate of q_i.
                    let power = |(k, wrench): (usize, &Wrench)| {
                        let [force, moment, point] =
                            [0, 1, 2].map(|part| three(&at.wrenches, 3 * (first + k) + part));
                        let body = wrench.body.0;
                        let arm = minus(point, three(&at.positions, body));
                        let omega = three(&turn, body);
                        let velocity = plus(three(&shift, body), cross(omega, arm));
                        dot(force, velocity) + dot(moment, omega)
                    };
                    let work: f64 = constraint.wrenches.iter().enumerate().map(power).sum();
                    first += constraint.wrenches.len();
                    mechanism.close(
                        &format!("−Gᵀ λ, row {row}, q {i}"),
                        -at.jacobian[row * nq + i],
                        work,
                        1e-6,
                    );
                }
            }
        }
    }
}

#[test]
fn rates_of_the_constraints_follow_along_the_motion() {
    for mechanism in mechanisms() {
        for state in mechanism.states() {
            let at = mechanism.at(&state);
            let way = state.along(&state.v, 1.0);
            let rates = mechanism.slope(&way, |at| at.constraints.clone());
            let second = mechanism.slope(&way, |at| at.velocities.clone());
            for (row, constraint) in mechanism.system.constraints.iter().enumerate() {
                // Of wheels G is the gradient and rows of cut joints, which are not at rest here.
                let is_coupling = matches!(constraint.source, RowSource::Coupling(_));
                if is_coupling && !mechanism.system.tree.cuts.is_empty() {
                    continue;
                }
                mechanism.close("G v + ∂g/∂t", at.velocities[row], rates[row], 1e-6);
                mechanism.close("γ", at.gamma[row], second[row], 1e-6);
            }
        }
    }
}

/// A model, its equations, and one tape for all their values.
struct Mechanism {
    name: String,
    model: Model,
    system: SymbolicSystem,
    tape: Tape,
    nq: usize,
}

#[derive(Clone)]
struct State {
    t: f64,
    q: Vec<f64>,
    v: Vec<f64>,
}

/// A straight line of states.
struct Way {
    start: State,
    towards: State,
}

/// The values of the equations at one state; matrices row by row.
struct At {
    kinetic_energy: f64,
    potential_energy: f64,
    mass: Vec<f64>,
    bias: Vec<f64>,
    potential_gradient: Vec<f64>,
    constraints: Vec<f64>,
    jacobian: Vec<f64>,
    /// G v + ∂g/∂t.
    velocities: Vec<f64>,
    gamma: Vec<f64>,
    /// Of a point of each body, and angular velocity.
    positions: Vec<f64>,
    omegas: Vec<f64>,
    /// Of each constraint: force, moment, joint point on the successor.
    wrenches: Vec<f64>,
}

/// Open and closed, planar and spatial mechanisms, most of them in two sets of coordinates, all derived
/// in both ways.
fn mechanisms() -> Vec<Mechanism> {
    let example = |name: &str| {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
        std::fs::read_to_string(format!("{root}/{name}/model.toml")).expect("an example")
    };
    // Of a crank in the slider-crank example no real body has the moments: its M is not definite.
    let [four_bar, quick_return, spring_pendulum, governor] =
        ["four-bar", "quick-return", "spring-pendulum", "governor"].map(example);
    let (relative, absolute) = (CoordinatePolicy::Relative, CoordinatePolicy::Absolute);
    let mechanisms = |derivation| {
        let mechanism = |name, text, policy| mechanism(name, text, policy, derivation);
        vec![
            mechanism("four-bar", &four_bar, relative),
            mechanism("four-bar", &four_bar, absolute),
            mechanism("quick-return", &quick_return, relative),
            mechanism("quick-return", &quick_return, absolute),
            mechanism("spring-pendulum", &spring_pendulum, relative),
            mechanism("spring-pendulum", &spring_pendulum, absolute),
            mechanism("governor", &governor, relative),
            mechanism("spatial loop", SPATIAL_LOOP, relative),
            mechanism("spatial loop", SPATIAL_LOOP, absolute),
            mechanism("spatial chain", SPATIAL_CHAIN, relative),
            mechanism("spatial chain", SPATIAL_CHAIN, absolute),
            mechanism("tumbling arm", TUMBLING_ARM, relative),
            mechanism("spatial four-bar", SPATIAL_FOUR_BAR, relative),
            mechanism("planetary gear", PLANETARY_GEAR, relative),
            mechanism("planetary gear", PLANETARY_GEAR, absolute),
            mechanism("differential", DIFFERENTIAL, relative),
        ]
    };
    [Derivation::Lagrange, Derivation::Recursion].into_iter().flat_map(mechanisms).collect()
}

fn mechanism(
    name: &str,
    text: &str,
    policy: CoordinatePolicy,
    derivation: Derivation,
) -> Mechanism {
    let reading = read(&Source::new(text, name));
    let faults = reading.diagnostics;
    let mut model = reading.model.unwrap_or_else(|| panic!("{name}: {faults:?}"));
    model.coordinates = policy;
    let system = assemble_by(&model, derivation);
    let tape = tape(&model, &system);
    let nq = system.coordinates().len();
    Mechanism { name: format!("{name}, {policy:?}, {derivation:?}"), model, system, tape, nq }
}

/// All outputs in the order of the fields of [`At`].
fn tape(model: &Model, system: &SymbolicSystem) -> Tape {
    let pool = &model.pool;
    let dense = |matrix: &bksim_mbs::sparse::SparseMatrix| {
        let cells = (0..matrix.n_rows()).flat_map(|i| (0..matrix.n_columns()).map(move |j| (i, j)));
        cells.map(|(i, j)| matrix.get(i, j).unwrap_or(pool.zero())).collect::<Vec<Expr>>()
    };
    let coordinates = system.coordinates();
    let mut outputs = vec![system.kinetic_energy, system.potential_energy];
    outputs.extend(dense(&system.mass_matrix));
    outputs.extend(&system.bias);
    outputs.extend(&system.potential_gradient);
    outputs.extend(system.constraints.iter().map(|c| c.expression));
    outputs.extend(dense(&system.constraint_jacobian));
    let velocity = |row: usize| {
        let terms = system.constraint_jacobian.row(row).iter();
        let terms = terms.map(|&(i, g)| pool.mul(g, pool.symbol_expr(coordinates[i].v)));
        pool.sum(terms.chain([system.constraint_rate[row]]).collect::<Vec<_>>())
    };
    let rows = 0..system.constraints.len();
    outputs.extend(rows.clone().map(velocity));
    outputs.extend(rows.map(|row| constraint_gamma(model, system, row)));
    outputs.extend(system.kinematics.poses.iter().flat_map(|pose| pose.anchor_world));
    outputs.extend(system.kinematics.poses.iter().flat_map(|pose| pose.omega));
    for wrench in system.constraints.iter().flat_map(|constraint| &constraint.wrenches) {
        outputs.extend([wrench.force, wrench.moment, wrench.at].concat());
    }
    let values = coordinates.iter().map(|c| c.q);
    let inputs = [model.time].into_iter().chain(values).chain(coordinates.iter().map(|c| c.v));
    let parameters: Vec<_> = model.parameters.iter().map(|p| p.symbol).collect();
    Tape::compile(pool, &outputs, &inputs.collect::<Vec<_>>(), &parameters).expect("a tape")
}

impl Mechanism {
    fn at(&self, state: &State) -> At {
        let parameters: Vec<f64> = self.model.parameters.iter().map(|p| p.value).collect();
        let mut out = vec![0.0; self.tape.n_outputs()];
        let inputs = [&[state.t][..], &state.q, &state.v].concat();
        self.tape.evaluate(&mut self.tape.workspace(&parameters), &inputs, &mut out);
        assert!(out.iter().all(|value| value.is_finite()), "{}: {out:?}", self.name);
        let (nq, nc, nb) = (self.nq, self.system.constraints.len(), self.model.bodies.len());
        let n_wrenches = self.system.constraints.iter().map(|c| c.wrenches.len()).sum::<usize>();
        let mut rest = out.into_iter();
        let mut take = |n: usize| rest.by_ref().take(n).collect::<Vec<f64>>();
        let energies = take(2);
        At {
            kinetic_energy: energies[0],
            potential_energy: energies[1],
            mass: take(nq * nq),
            bias: take(nq),
            potential_gradient: take(nq),
            constraints: take(nc),
            jacobian: take(nc * nq),
            velocities: take(nc),
            gamma: take(nc),
            positions: take(3 * nb),
            omegas: take(3 * nb),
            wrenches: take(9 * n_wrenches),
        }
    }

    /// The central difference of a function of the state along a way.
    fn slope(&self, way: &Way, of: impl Fn(&At) -> Vec<f64>) -> Vec<f64> {
        let [ahead, back] = [STEP, -STEP].map(|step| of(&self.at(&way.state(step))));
        ahead.iter().zip(&back).map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
    }

    /// Random states in which the joints hold.
    fn states(&self) -> Vec<State> {
        let mut random = Random(20_240_229);
        let mut states = Vec::new();
        for _ in 0..50 {
            let mut next = |n: usize| (0..n).map(|_| random.next()).collect::<Vec<f64>>();
            let mut state = State { t: 0.37, q: next(self.nq), v: next(self.nq) };
            if self.close_joints(&mut state) {
                states.push(state);
            }
            if states.len() == N_STATES {
                return states;
            }
        }
        panic!("{}: only {} states in which the joints hold", self.name, states.len());
    }

    /// Gauss–Newton steps onto g = 0 of the rows that always hold; false when they do not get there.
    fn close_joints(&self, state: &mut State) -> bool {
        let (nq, rows) = (self.nq, 0..self.system.n_bilateral());
        for _ in 0..60 {
            let at = self.at(state);
            let gap = rows.clone().map(|row| at.constraints[row].abs()).fold(0.0, f64::max);
            if gap < 1e-12 {
                return true;
            }
            let change = smallest_step(&at.jacobian, &at.constraints, nq, rows.clone());
            let length = change.iter().map(|x| x.abs()).fold(0.0, f64::max);
            let factor = if length > 0.3 { 0.3 / length } else { 1.0 };
            state.q.iter_mut().zip(change).for_each(|(q, change)| *q -= factor * change);
        }
        false
    }

    fn close(&self, what: &str, value: f64, expected: f64, tolerance: f64) {
        let gap = (value - expected).abs();
        let bound = tolerance * (1.0 + value.abs() + expected.abs());
        assert!(gap <= bound, "{}: {what}: {value} against {expected}", self.name);
    }
}

impl State {
    fn along(&self, rate: &[f64], time: f64) -> Way {
        let rest = vec![0.0; self.v.len()];
        Way { start: self.clone(), towards: State { t: time, q: rate.to_vec(), v: rest } }
    }

    fn along_q(&self, k: usize) -> Way {
        let mut unit = vec![0.0; self.q.len()];
        unit[k] = 1.0;
        self.along(&unit, 0.0)
    }

    fn along_v(&self, k: usize) -> Way {
        let mut way = self.along_q(k);
        std::mem::swap(&mut way.towards.q, &mut way.towards.v);
        way
    }
}

impl Way {
    fn state(&self, s: f64) -> State {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + s * b).collect();
        let (start, towards) = (&self.start, &self.towards);
        State {
            t: start.t + s * towards.t,
            q: sum(&start.q, &towards.q),
            v: sum(&start.v, &towards.v),
        }
    }
}

/// A congruential generator: numbers between −1 and 1 from a fixed seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        #[expect(clippy::cast_precision_loss, reason = "the upper 53 bits are a number of f64")]
        let unit = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        2.0 * unit - 1.0
    }
}

/// Gᵀ (G Gᵀ + ε)⁻¹ g of some rows: ε lets rows depend on others.
fn smallest_step(jacobian: &[f64], g: &[f64], nq: usize, rows: Range<usize>) -> Vec<f64> {
    let n = rows.len();
    let row = |k: usize| &jacobian[(rows.start + k) * nq..(rows.start + k + 1) * nq];
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut matrix: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let mut line: Vec<f64> = (0..n).map(|j| product(row(i), row(j))).collect();
            line[i] += 1e-10;
            line.push(g[rows.start + i]);
            line
        })
        .collect();
    // Symmetric and positive definite: elimination needs no pivots.
    for i in 0..n {
        for k in 0..n {
            if k != i {
                let factor = matrix[k][i] / matrix[i][i];
                for j in i..=n {
                    matrix[k][j] -= factor * matrix[i][j];
                }
            }
        }
    }
    let weights: Vec<f64> = (0..n).map(|i| matrix[i][n] / matrix[i][i]).collect();
    (0..nq).map(|j| (0..n).map(|k| row(k)[j] * weights[k]).sum()).collect()
}

/// The smallest pivot of L D Lᵀ of some rows and columns: positive when that matrix is definite.
fn smallest_pivot(matrix: &[f64], n: usize, rows: &[usize]) -> f64 {
    let mut rest = matrix.to_vec();
    let mut smallest = f64::INFINITY;
    for (at, &i) in rows.iter().enumerate() {
        let pivot = rest[i * n + i];
        smallest = smallest.min(pivot);
        for &k in &rows[at + 1..] {
            for &j in &rows[at + 1..] {
                rest[k * n + j] -= rest[k * n + i] * rest[i * n + j] / pivot;
            }
        }
    }
    smallest
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)))
}

fn three(values: &[f64], k: usize) -> [f64; 3] {
    [values[3 * k], values[3 * k + 1], values[3 * k + 2]]
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
