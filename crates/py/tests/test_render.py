"""Pictures and films, and the command that the package brings."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import bksim


@pytest.fixture(scope="module")
def sol() -> bksim.Solution:
    examples = Path(__file__).parents[3] / "examples"
    return bksim.load(examples / "slider-crank" / "model.toml").solve(t_end=0.5)


def command(*arguments: Any) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", "bksim", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("ending", "first"),
    [
        ("png", b"\x89PNG"),
        ("svg", b"<svg"),
        ("gif", b"GIF89a"),
        ("apng", b"\x89PNG"),
        ("mp4", b"\x00\x00\x00"),
    ],
)
def test_a_file_is_what_its_name_says(
    sol: bksim.Solution, ending: str, first: bytes, tmp_path: Path
) -> None:
    path = tmp_path / f"seen.{ending}"
    of_film: dict[str, Any] = {} if ending in ("png", "svg") else {"fps": 10, "speed": 0.5}
    sol.render(path, size=(160, 120), background="#203040", **of_film)
    assert path.read_bytes().startswith(first)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_a_film_is_that_of_the_command(sol: bksim.Solution, tmp_path: Path) -> None:
    run = tmp_path / "run.mcap"
    sol.save(run)
    sol.render(
        tmp_path / "here.gif",
        span=(0.1, 0.4),
        fps=20,
        size=(200, 150),
        trails="B",
        arrows=["reactions", "velocities"],
        labels=True,
        ghosts=3,
        past=0.1,
        background="dark",
    )
    options = "--from 0.1 --to 0.4 --fps 20 --size 200x150 --trail B --arrows reactions,velocities"
    options += " --labels --ghosts 3 --past 0.1 --background dark --json"
    done = command("render", run, "-o", tmp_path / "there.gif", *options.split())
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frames"] == 6
    films = [(tmp_path / f"{place}.gif").read_bytes() for place in ("here", "there")]
    # The command adds, ahead of the last byte, what it is of.
    assert films[1].startswith(films[0][:-1])
    reopened = bksim.open(run)
    reopened.render(tmp_path / "picture.svg", at=0.2)
    assert (tmp_path / "picture.svg").read_text() == sol.picture(0.2).svg


def test_a_section_leaves_out_what_lies_beyond_it(tmp_path: Path) -> None:
    sol = bksim.example("differential").solve(t_end=0.1)
    seen = []
    for section in (None, "x < 0 mm", "x > 9 m"):
        sol.render(tmp_path / "seen.svg", view="isometric", labels=True, section=section)
        seen.append((tmp_path / "seen.svg").read_text())
    assert all(name in seen[0] for name in ("left.wheel", "right.wheel"))
    assert "left.wheel" in seen[1]
    assert "right.wheel" not in seen[1]
    assert "wheel" not in seen[2]


@pytest.mark.parametrize(
    ("name", "options", "match"),
    [
        ("seen.doc", {}, "must end in"),
        ("seen.png", {"at": 7.0}, "outside of the motion"),
        ("seen.png", {"at": float("nan")}, "outside of the motion"),
        ("seen.png", {"speed": 0.5}, "one instant"),
        ("seen.gif", {"at": 0.1}, "more than the instant"),
        ("seen.gif", {"span": (0.1, 7.0)}, "`to` = 7"),
        ("seen.gif", {"fps": 0.0}, "`fps`"),
        ("seen.gif", {"fps": float("nan")}, "`fps`"),
        ("seen.gif", {"fps": 1e6, "speed": 1e-6}, "frames"),
        ("seen.svg", {"size": (1, 1)}, "`size`"),
        ("seen.svg", {"density": 1e9}, "`density`"),
        ("seen.svg", {"ghosts": 1000}, "`ghosts`"),
        ("seen.svg", {"view": (10.0, 20.0)}, "planar"),
        ("seen.svg", {"section": "x = 0"}, "`section` is for spatial"),
        ("seen.svg", {"section": "x = 1 s"}, "x = 20 mm"),
        ("seen.svg", {"trails": "nowhere"}, "nowhere"),
        ("seen.svg", {"arrows": "moments"}, "moments"),
        ("seen.svg", {"background": "pink"}, "#fff8e7"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_words(
    sol: bksim.Solution, name: str, options: dict[str, Any], match: str, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=match):
        sol.render(tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_ends_a_film_and_leaves_the_old_one(sol: bksim.Solution, tmp_path: Path) -> None:
    path = tmp_path / "seen.gif"
    path.write_text("an older film")
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            sol.render(path, fps=10_000, speed=0.01, size=(64, 48))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert path.read_text() == "an older film"
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_the_command_is_the_command_line(tmp_path: Path, examples: Path) -> None:
    assert command("--version").stdout.split() == ["bksim", bksim.__version__]
    model = examples / "slider-crank" / "model.toml"
    solved = command("solve", model, "--t-end", "0.1", "-o", tmp_path / "run.mcap", "--json")
    assert solved.returncode == 0, solved.stderr
    assert json.loads(solved.stdout)["command"] == "solve"
    assert bksim.open(tmp_path / "run.mcap").span == (0.0, 0.1)
    wrong = command("check", tmp_path / "none.toml")
    assert wrong.returncode != 0 and "none.toml" in wrong.stderr and not wrong.stdout
    assert command("nothing").returncode == 2


def test_the_command_hears_ctrl_c(tmp_path: Path, examples: Path) -> None:
    model = examples / "slider-crank" / "model.toml"
    words = [sys.executable, "-m", "bksim", "solve", str(model), "--t-end", "1e6"]
    words += ["-o", str(tmp_path / "run.mcap")]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        while not (tmp_path / "run.mcap").exists():
            assert run.poll() is None, "it has ended"
            time.sleep(0.05)
        time.sleep(0.5)
        run.send_signal(signal.SIGINT)
        _, err = run.communicate(timeout=60)
    assert run.returncode == 130 and "Traceback" not in err
    assert len(bksim.open(tmp_path / "run.mcap")) > 1
