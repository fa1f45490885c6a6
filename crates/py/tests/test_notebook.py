"""The notebooks of the examples, run as a reader runs them."""

from __future__ import annotations

from pathlib import Path

import bksim
import pytest

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")

NOTEBOOKS = sorted((Path(__file__).parents[3] / "examples" / "notebook").glob("*.ipynb"))


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: str(path.stem))
def test_a_notebook_runs_and_shows_what_it_promises(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    resources = {"metadata": {"path": str(path.parent)}}
    nbclient.NotebookClient(notebook, timeout=120, resources=resources).execute()
    outputs = [out for cell in notebook.cells for out in cell.get("outputs", [])]
    shown = {kind for out in outputs for kind in out.get("data", {})}
    assert {"text/html", "text/latex", "image/svg+xml"} <= shown
    assert not [out for out in outputs if out.output_type in ("error", "stream")]


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "module.wasm"
    path.write_bytes(b"\0asm\1\0\0\0")
    monkeypatch.setenv("BKSIM_LIVE", str(path))
    return path


def test_a_live_page_is_a_widget_with_the_text_of_the_model(module: Path) -> None:
    model = bksim.example("four-bar")
    model.parameters["a"] = 0.09
    widget = bksim.live(model, height=500, title="four <bars>")
    assert widget.text == model.text and widget.height == 500
    assert "four &lt;bars>" in widget.page or "four &lt;bars&gt;" in widget.page
    # What the hand changes there is a model here.
    widget.text = widget.text.replace("0.09", "0.08")
    assert bksim.loads(widget.text).parameters["a"] == pytest.approx(0.08)


def test_a_live_page_without_widgets_is_a_frame(module: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    page = bksim.live(bksim.example("four-bar"))
    assert isinstance(page, bksim.LivePage)
    assert page._repr_html_().startswith("<iframe srcdoc=")
    page.save(module.with_name("page.html"))
    assert module.with_name("page.html").read_text("utf-8") == page.html


def test_the_module_of_the_package_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    from bksim import _live

    monkeypatch.delenv("BKSIM_LIVE", raising=False)
    assert _live.module_path() == Path(bksim.__file__).with_name("bksim_live.wasm")


def test_a_missing_module_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BKSIM_LIVE", "/nowhere/module.wasm")
    with pytest.raises(FileNotFoundError, match="BKSIM_LIVE"):
        bksim.live(bksim.example("four-bar"))
