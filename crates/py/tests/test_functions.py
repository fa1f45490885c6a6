"""The compiled functions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bksim


def test_the_functions_hold_along_a_motion(example: Path) -> None:
    m = bksim.load(example)
    sol, f = m.solve(t_end=0.2), m.compile()
    q, v, a, lam = sol.q.T, sol.v.T, sol.a.T, sol.lam.T
    assert f.mass_matrix(q, sol.t).shape == (len(sol), f.nq, f.nq)
    text = example.read_text()
    if any(f'type = "{contact}"' in text for contact in ("friction", "stop")) or "backlash" in text or "[contacts" in text:
        pytest.skip("modes of contacts change the equations")
    # A start may lie where an expression jumps, as the engine's does in its dead centre: last digits choose the side there.
    residual = f.residual(sol.t, q, v, a, lam)[1:]
    size = np.abs(f.forces(sol.t, q, v)).max() + np.abs(lam).max(initial=0.0) + 1.0
    assert np.abs(residual).max() < 1e-8 * size


def test_a_batch_is_its_rows(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    sol, f = m.solve(t_end=0.2), m.compile()
    q, v = np.ascontiguousarray(sol.q.T), np.ascontiguousarray(sol.v.T)
    a, lam = f.accelerations_and_multipliers(sol.t, q, v)
    for k in (0, 17, len(sol) - 1):
        assert np.array_equal(f.mass_matrix(q)[k], f.mass_matrix(q[k]))
        assert np.array_equal(f.constraint_jacobian(q)[k], f.constraint_jacobian(q[k]))
        assert np.array_equal(a[k], f.accelerations(sol.t[k], q[k], v[k]))
    assert np.allclose(a, sol.a.T, rtol=1e-9, atol=1e-9)
    assert np.allclose(lam, sol.lam.T, rtol=1e-7, atol=1e-7)


def test_the_mass_matrix_gives_the_kinetic_energy(example: Path) -> None:
    m = bksim.load(example)
    sol, f = m.solve(t_end=0.2), m.compile()
    mass = f.mass_matrix(sol.q.T, sol.t)
    # A state has one where others have a mass, and no energy.
    moving = np.array([not name.endswith("_integral") for name in m.coordinates])
    v = np.where(moving, sol.v.T, 0.0)
    energy = 0.5 * np.einsum("ki,kij,kj->k", v, mass, v)
    assert np.allclose(energy, sol.energy["kinetic"], rtol=1e-10, atol=1e-12)
    assert np.array_equal(mass, np.swapaxes(mass, 1, 2))


def test_the_jacobian_is_the_slope_of_the_constraints(examples: Path) -> None:
    f = bksim.load(examples / "four-bar" / "model.toml").compile()
    q = np.linspace(0.2, 0.9, f.nq)
    h = 1e-6
    for k in range(f.nq):
        step = h * np.eye(f.nq)[k]
        slope = (f.constraints(0.0, q + step) - f.constraints(0.0, q - step)) / (2 * h)
        assert np.allclose(slope, f.constraint_jacobian(q)[:, k], atol=1e-8)


def test_shapes_are_checked(examples: Path) -> None:
    f = bksim.load(examples / "four-bar" / "model.toml").compile()
    with pytest.raises(ValueError, match="is needed"):
        f.mass_matrix(np.zeros(f.nq + 1))
    with pytest.raises(ValueError):
        f.forces(np.zeros(3), np.zeros((2, f.nq)), np.zeros((2, f.nq)))


def test_one_state_stands_for_a_batch_and_results_are_the_callers_own(example):
    f = bksim.load(example).compile()
    q, v = np.zeros((4, f.nq)), np.zeros((1, f.nq))
    assert f.forces(0.0, q, v).shape == (4, f.nq)
    mass = f.mass_matrix(q)
    mass += 1.0
    with pytest.raises(ValueError, match="batches of 4, 3"):
        f.forces(0.0, q, np.zeros((3, f.nq)))
    with pytest.raises(ValueError, match=r"or \(batch, "):
        f.mass_matrix(np.zeros((2, 3, f.nq)))


def test_a_body_that_turns_by_a_quaternion(tmp_path: Path) -> None:
    file = tmp_path / "rod.toml"
    file.write_text(
        'space = "spatial"\n[bodies.rod]\nmass = 2\ninertia = [0.2, 0.3, 0.4]\nfree = true\n'
        '[initial]\nrod = { rpy = [0.3, -0.2, 0.1], w = [1, 2, 3], frame = "body" }\n'
        "[solve]\nt_end = 1\n",
        encoding="utf-8",
    )
    m = bksim.load(file)
    sol, f = m.solve(), m.compile()
    assert f.nq == 7
    mass = f.mass_matrix(sol.q.T, sol.t)
    energy = 0.5 * np.einsum("ki,kij,kj->k", sol.v.T, mass, sol.v.T)
    assert np.allclose(energy, sol.energy["kinetic"], rtol=1e-12)
    # Euler's equation about the first axis, and the momentum, which stays.
    moment = 0.2 * sol["rod.alx_body"] + (0.4 - 0.3) * sol["rod.wy_body"] * sol["rod.wz_body"]
    assert np.abs(moment).max() < 1e-9
    assert np.allclose(sol["rod.lz"], sol["rod.lz"][0], rtol=1e-5)
    assert sol.unit("rod.alx") == "rad/s^2" and sol.unit("rod.pitch") == "rad"
    assert np.array_equal(mass, np.swapaxes(mass, 1, 2))
    assert np.linalg.eigvalsh(mass).min() > 0.1
    assert np.allclose(np.linalg.norm(sol.q[3:], axis=0), 1.0, atol=1e-9)
    assert np.abs(sol.lam).max() < 1e-9
    residual = f.residual(sol.t, sol.q.T, sol.v.T, sol.a.T, sol.lam.T)
    assert np.abs(residual).max() < 1e-9


def test_reactions_in_the_axes_of_a_joint() -> None:
    m = bksim.loads(
        """
        [ground]
        points = { O = { at = [0, 0, 0], rpy = ["30 deg", 0, 0] } }
        [bodies.rod]
        mass = 2
        inertia = [0.2, 0.1, 0.15]
        com = [0.5, 0, 0.1]
        [joints.A]
        type = "revolute"
        between = ["ground.O", "rod"]
        [loads.gravity]
        type = "gravity"
        acceleration = [0, "-9.81 m/s^2", 0]
        [solve]
        t_end = 1
        """
    )
    sol = m.solve(progress=False)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    expected = c * sol["reactions.A.fy"] + s * sol["reactions.A.fz"]
    assert np.allclose(sol["reactions.A.fy_joint"], expected, atol=1e-12)
    assert np.allclose(sol["reactions.A.mz_joint"], 0, atol=1e-12)
    assert sol.unit("reactions.A.mz_joint") == "N m"
