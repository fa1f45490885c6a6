"""Solutions: arrays, the motion between samples, tables, logs, pictures."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import bksim


@pytest.fixture(scope="module")
def sol() -> bksim.Solution:
    from conftest import EXAMPLES

    return bksim.load(EXAMPLES / "slider-crank" / "model.toml").solve(t_end=1.0)


def test_arrays_are_read_only_views_contiguous_in_time(sol: bksim.Solution) -> None:
    arrays = [sol.t, sol.q, sol.v, sol.a, sol.lam, sol["theta1"], *sol.reactions.values()]
    for array in arrays:
        assert array.dtype == np.float64 and array.flags.c_contiguous
        assert not array.flags.writeable
        assert array.shape[-1] == len(sol)
        with pytest.raises(ValueError):
            array[..., 0] = 1.0
    assert np.shares_memory(sol.q, sol.q) and np.shares_memory(sol["theta1"], sol.q)
    assert all(np.shares_memory(r, sol._table) for r in sol.reactions.values())


def test_names_are_channels_coordinates_and_measures(sol: bksim.Solution) -> None:
    assert np.array_equal(sol["state.theta1"], sol["theta1"])
    assert np.array_equal(sol["theta1_dot"], sol.v[0])
    assert np.allclose(sol["crank.angle"], sol["theta1"])
    assert sol.unit("crank.angle") == "rad" and sol.unit("energy.power") == "W"
    with pytest.raises(KeyError, match="did you mean"):
        sol["theta"]
    with pytest.raises(KeyError):
        sol.reactions["nowhere"]


def test_the_rate_of_a_measure_is_its_slope(sol: bksim.Solution) -> None:
    t = np.linspace(0.2, 0.3, 2001)
    between = sol(t)
    slope = np.gradient(between["rod.x"], t, edge_order=2)
    assert np.allclose(slope[1:-1], between["rod.vx"][1:-1], atol=1e-5)


def test_the_motion_between_samples_is_that_of_a_run_with_more(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    few, many = m.solve(t_end=0.5, every=0.1), m.solve(t_end=0.5, every=0.001)
    between = few(many.t)
    assert np.allclose(between.q, many.q, rtol=0, atol=1e-9)
    for name, reaction in between.reactions.items():
        assert np.allclose(reaction, many.reactions[name], rtol=1e-7, atol=1e-6)
    assert np.isnan(between["energy.work"]).all()


def test_one_instant_has_no_axis_of_time(sol: bksim.Solution) -> None:
    at = sol(0.25)
    assert at["crank.angle"].shape == () and at.q.shape == sol.q.shape[:1]
    with pytest.raises(ValueError, match="outside"):
        sol(1.5)
    with pytest.raises(ValueError, match="outside"):
        sol([0.1, np.nan])


def test_without_dense_only_samples_are_kept(examples: Path) -> None:
    sol = bksim.load(examples / "four-bar" / "model.toml").solve(t_end=0.1, dense=False)
    with pytest.raises(ValueError, match="dense=True"):
        sol(0.05)
    assert sol.plot()._repr_svg_().startswith("<svg")


def test_options_are_checked(examples: Path) -> None:
    m = bksim.load(examples / "four-bar" / "model.toml")
    times = [0.01, 0.025, 0.07]
    assert np.allclose(m.solve(t_end=0.1, times=times).t, [0.0, *times, 0.1])
    for wrong in ({"rtol": 0.0}, {"every": -1.0}, {"step": np.inf}, {"method": "euler"}):
        with pytest.raises(ValueError):
            m.solve(t_end=0.1, **wrong)  # type: ignore[arg-type]


def test_methods_agree(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    radau = m.solve(t_end=0.5, rtol=1e-9, method="radau")
    explicit = m.solve(t_end=0.5, rtol=1e-9, method="explicit")
    assert radau.summary["methods"][0]["method"] == "radau"
    assert np.allclose(radau.q, explicit.q, atol=1e-6)


def test_tables_have_units(sol: bksim.Solution) -> None:
    pytest.importorskip("pandas")
    frame = sol.to_pandas()
    assert frame.index.name == "t" and frame.attrs["units"]["energy.power"] == "W"
    assert np.array_equal(frame["state.theta1"], sol["theta1"])
    pytest.importorskip("xarray")
    dataset = sol.to_xarray()
    assert dataset["energy.power"].attrs["units"] == "W"
    assert float(dataset["state.theta1"].sel(t=sol.t[3])) == sol["theta1"][3]
    pytest.importorskip("pyarrow")
    arrow = sol.to_arrow()
    assert arrow.schema.field("energy.power").metadata[b"unit"] == b"W"
    assert np.array_equal(arrow["t"].to_numpy(), sol.t)


def test_a_log_is_the_solution_again(sol: bksim.Solution, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    sol.save(path)
    again = bksim.open(path)
    assert again.success and again.names == sol.names
    assert np.array_equal(again.t, sol.t) and np.array_equal(again._table, sol._table)
    t = np.linspace(0, 1, 41)
    assert np.allclose(again(t).q, sol(t).q, rtol=0, atol=1e-12)
    again.save(tmp_path / "copy.mcap")
    assert (tmp_path / "copy.mcap").read_bytes() == path.read_bytes()
    assert not list(tmp_path.glob("*.part"))


def test_what_is_no_log_is_a_log_error(tmp_path: Path) -> None:
    path = tmp_path / "no.mcap"
    path.write_bytes(b"nothing")
    with pytest.raises(bksim.LogError, match="no.mcap"):
        bksim.open(path)
    with pytest.raises(FileNotFoundError):
        bksim.open(tmp_path / "none.mcap")


def test_plots_and_pictures(sol: bksim.Solution, tmp_path: Path) -> None:
    for ending, first in (("svg", b"<svg"), ("png", b"\x89PNG"), ("pdf", b"%PDF")):
        path = tmp_path / f"plot.{ending}"
        sol.plot("theta1", "energy.total").save(path)
        assert path.read_bytes().startswith(first)
    with pytest.raises(ValueError, match="must end in"):
        sol.plot().save(tmp_path / "plot.doc")
    assert "<svg" in sol.picture(0.5)._repr_svg_()
    assert "<svg" in sol._repr_html_()


def test_an_animation_is_a_page(sol: bksim.Solution, tmp_path: Path) -> None:
    animation = sol.animate(title="a crank")
    assert "<title>a crank</title>" in animation.html
    assert "<iframe" in animation._repr_html_()
    animation.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size < 2e6


def test_sensitivities_are_the_slopes_of_the_motion(examples, tmp_path):
    def solved(l1, **options):
        m = bksim.load(examples / "slider-crank" / "model.toml")
        m.parameters["l1"] = l1
        return m.solve(t_end=1, rtol=1e-10, atol=1e-12, method="radau", **options)

    step = 1e-5
    sol = solved(1.0, sensitivity=["l1", "l1"])
    assert list(sol.sensitivity) == ["l1"]
    by = sol.sensitivity["l1"]
    high, low = solved(1.0 + step), solved(1.0 - step)
    for found, above, below in [(by.q, high.q, low.q), (by.v, high.v, low.v), (by.a, high.a, low.a)]:
        slope = (above - below) / (2 * step)
        np.testing.assert_allclose(found, slope, atol=2e-5 * np.abs(slope).max())
    assert np.array_equal(by["theta1"], by.q[list(sol.names).index("state.theta1")])
    assert by.lam.shape == sol.lam.shape and sol.unit("sensitivity.l1.theta1_dot") == "rad/s/m"

    for name in ["reactions.B.fx", "energy.kinetic"]:
        slope = (high[name] - low[name]) / (2 * step)
        np.testing.assert_allclose(by[name], slope, atol=2e-5 * np.abs(slope).max())

    sol.save(tmp_path / "run.mcap")
    logged = bksim.open(tmp_path / "run.mcap")
    assert np.array_equal(logged.sensitivity["l1"].a, by.a)
    assert np.array_equal(logged.sensitivity["l1"]["reactions.B.fx"], by["reactions.B.fx"])
    assert "sensitivity.l1.theta1" in sol.to_pandas()
    with pytest.raises(bksim.ModelError, match="S012"):
        solved(1.0, sensitivity="nothing")


BALL = """
[parameters]
h = "1 m"
[bodies.ball]
mass = "2 kg"
[joints.S]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
coordinate = "x"
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[loads.floor]
type = "stop"
joint = "S"
min = 0
restitution = 0.5
[initial]
x = "h"
"""


def test_sensitivities_pass_impacts():
    """x = v₁ (t − t₁)/2 − g (t − t₁)²/2 after the first impact, v₁ = √(2 g h), t₁ = v₁/g."""
    g, h, t = 9.81, 1.0, 0.6
    sol = bksim.loads(BALL).solve(t_end=t, times=[t], rtol=1e-10, atol=1e-12, sensitivity="h")
    v1 = (2 * g * h) ** 0.5
    since, by_v1, by_t1 = t - v1 / g, g / v1, 1 / v1
    expected = by_v1 * since / 2 - (v1 / 2 - g * since) * by_t1
    assert abs(sol.sensitivity["h"]["x"][-1] - expected) < 1e-8
    assert abs(sol.gradient({"x": (sol.t == t).astype(float)})["h"] - expected) < 1e-8
    assert set(sol.sensitivity) == {"h"} and "energy.total" in list(sol.sensitivity["h"])


@pytest.mark.parametrize("name", ["slider-crank", "four-bar", "spring-pendulum"])
def test_a_log_is_shown_as_the_run_it_is_of(name, examples, tmp_path):
    sol = bksim.load(examples / name / "model.toml").solve(t_end=0.2)
    sol.save(tmp_path / "run.mcap")
    logged = bksim.open(tmp_path / "run.mcap")
    assert logged.picture(0.1).svg == sol.picture(0.1).svg
    assert "<html" in logged.animate().html
    assert logged.plot()._repr_svg_() == sol.plot()._repr_svg_()
    told = logged.summary
    assert told.pop("notes") == [] and told["end"].pop("reason")
    assert told == sol.summary and logged.events == sol.events


def test_a_log_tells_what_switched(tmp_path):
    ball = bksim.loads("""
[bodies.ball]
mass = "1 kg"
points = { P = [0, 0] }
[joints.guide]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
coordinate = "y"
[loads]
gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
floor = { type = "stop", joint = "guide", min = "0 m", restitution = 0.5 }
[initial]
y = "1 m"
[solve]
t_end = "1 s"
""")
    sol = ball.solve()
    assert any(event["load"] == "floor" for event in sol.events)
    path = tmp_path / "run.mcap"
    sol.save(path)
    assert bksim.open(path).events == sol.events
    whole = path.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: whole.index(b"bksim.end") - 20])
    cut = bksim.open(tmp_path / "cut.mcap")
    assert cut.summary["end"] is None
    with pytest.raises(bksim.LogError, match="cut short"):
        _ = cut.events


def test_a_log_without_a_sample_is_refused(examples, tmp_path):
    path = tmp_path / "run.mcap"
    bksim.load(examples / "slider-crank" / "model.toml").solve(t_end=0.2).save(path)
    (tmp_path / "cut.mcap").write_bytes(path.read_bytes()[:5000])
    with pytest.raises(bksim.LogError, match="first sample"):
        bksim.open(tmp_path / "cut.mcap")


def test_what_is_not_there_is_said_to_be_not_there(examples, tmp_path):
    m = bksim.load(examples / "slider-crank" / "model.toml")
    sol = m.solve(t_end=0.3, sensitivity="l1")
    for t in (5, float("nan"), -1):
        with pytest.raises(ValueError, match="outside of the motion"):
            sol.picture(t)
    assert sol(0.1 * 3).t == 0.3, "its last digits are those of a sum"
    assert "sensitivity.l1.theta1" in sol(0.1) and np.isnan(sol(0.1)["sensitivity.l1.theta1"])
    assert "sensitivity" in sol.plot("sensitivity.l1.theta1")._repr_svg_()
    assert "theta1" in sol and "crank.angle" in sol and "theta9" not in sol and 3 not in sol
    assert list(sol) == list(sol.names) and np.array_equal(sol["t"], sol.t)
    with pytest.raises(TypeError, match="no name"):
        sol[3]
    with pytest.raises(KeyError, match="reactions.A.fx"):
        sol["reactions.A.fxx"]
    brief = m.solve(t_end=0.1, dense=False)
    for show in (brief.picture, brief.animate):
        with pytest.raises(ValueError, match="dense=True"):
            show()
    with pytest.raises(ValueError, match="must end in .mcap"):
        sol.save(tmp_path / "run.csv")
    with pytest.raises(ValueError, match="must end in .svg"):
        sol.picture().save(tmp_path / "picture.png")
    assert all(len(repr(shown)) < 200 for shown in (sol.picture(), sol.plot(), sol.animate()))
    lines = repr(sol).splitlines()
    assert "bksim.Solution" in lines[0] and "state.theta1" in lines[1] and "[rad]" in lines[2]
    assert lines[3].split()[0] == "0" and "…" in lines[6] and "more columns" in lines[-1]
    assert len(lines) == 10 and max(map(len, lines)) <= 100 and len(repr(sol(0.1)).splitlines()) == 5
    with pytest.raises(ValueError, match="outside of the run"):
        m.solve(t_end=0.1, times=[0.05, 0.2])
    with pytest.raises(TypeError, match="t_end = '1 s'"):
        m.solve(t_end="1 s")


def test_what_a_run_is_worth_is_a_warning(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    with pytest.warns(bksim.WorthWarning) as caught:
        coarse = m.solve(step=0.01, formulation="index3")
    assert [fault.code for fault in coarse.warnings] == ["R010", "R011"]
    assert [str(warning.message) for warning in caught] == [str(f) for f in coarse.warnings]
    assert Path(caught[0].filename) == Path(__file__)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert m.solve(t_end=0.5).warnings == ()


def test_friction_may_follow_the_reaction_of_its_joint() -> None:
    m = bksim.Model("block")
    m.bodies["block"] = bksim.Body(mass="2 kg", inertia=1)
    m.joints["rail"] = bksim.Prismatic("ground", "block", axis=[1, 0])
    m.loads["gravity"] = bksim.Gravity(acceleration=[0, "-10 m/s^2"])
    m.loads["rubbing"] = bksim.Friction(joint="rail", mu=0.25)
    m.initial["rail"] = {"position": 0, "velocity": "5 m/s"}
    sol = m.solve(t_end=1.0, rtol=1e-10)
    assert sol["rail.velocity"][-1] == pytest.approx(2.5, abs=1e-9)


def test_a_report_tells_the_limits_of_the_motion_in_the_units_asked_for(sol: bksim.Solution) -> None:
    report = sol.report("mm, deg")
    assert isinstance(report, bksim.Report)
    (slide,) = (m for m in report["motions"] if m["unit"] == "m")
    fine = sol(np.linspace(*sol.span, 20_001))[slide["name"]]
    assert slide["largest"]["value"] == pytest.approx(fine.max(), abs=1e-7)
    assert slide["least"]["value"] == pytest.approx(fine.min(), abs=1e-7)
    assert f"{slide['stroke'] * 1e3:.6g}"[:5] in str(report) and " mm" in str(report)
    assert "<table>" in report._repr_html_()
    with pytest.raises(ValueError, match="is no unit"):
        sol.report("mm, stone")
