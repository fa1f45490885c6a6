"""A mechanism under the hand, in the cell of a notebook."""

from __future__ import annotations

import importlib.util
import os
from functools import cache
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _bksim

if TYPE_CHECKING:
    from ._model import Model

MODULE = "bksim_live.wasm"
"""The file of the module: next to this one, or where ``BKSIM_LIVE`` says."""

SCRIPT = """
export default {
  render({ model, el }) {
    const frame = document.createElement('iframe');
    frame.srcdoc = model.get('page');
    frame.style.cssText = `width: 100%; height: ${model.get('height')}px; border: 0`;
    let told = model.get('text');
    const take = ({ source, data }) => {
      if (source !== frame.contentWindow || !data?.bksim) return;
      told = data.bksim.text;
      for (const key of ['text', 'time', 'selected']) model.set(key, data.bksim[key]);
      model.save_changes();
    };
    const tell = () => {
      const text = model.get('text');
      if (text !== told) frame.contentWindow.postMessage({ bksim: { text } }, '*');
      told = text;
    };
    window.addEventListener('message', take);
    model.on('change:text', tell);
    el.append(frame);
    return () => {
      window.removeEventListener('message', take);
      model.off('change:text', tell);
    };
  },
};
"""
"""Puts the page into a frame; texts go both ways, the time and the chosen body come back."""


class LivePage:
    """A live page as HTML, for notebooks that have no ``anywidget``."""

    def __init__(self, html: str, height: int) -> None:
        self.html = html
        self.height = height

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {self.height}px; border: 0"
        return f'<iframe srcdoc="{escape(self.html, quote=True)}" style="{style}"></iframe>'

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page, which any browser opens."""
        Path(path).expanduser().write_text(self.html, encoding="utf-8")


def live(model: Model, *, height: int = 640, title: str | None = None) -> Any:
    """A page in which the model is dragged, slid, drawn and solved.

    With the package ``anywidget`` it is a widget: ``text`` is the model as the hand has changed it, ``time`` the
    instant that is shown, s, and ``selected`` the body that was held last; a new ``text`` changes the page.
    ``bksim.loads(widget.text)`` goes on from there. Without it, the page is shown, and nothing comes back.

    Raises ``FileNotFoundError`` where the module of live pages is missing: ``docs/seeing/live.md`` says how to
    have it.
    """
    text, name = model.text, model._engine().name
    html = _bksim.live_page(text, name, name if title is None else title, _module())
    if importlib.util.find_spec("anywidget") is None:
        return LivePage(html, height)
    return _widget()(page=html, height=height, text=text)


def module_path() -> Path:
    """The module of live pages, whether it is there or not."""
    named = os.environ.get("BKSIM_LIVE")
    return Path(named) if named else Path(__file__).with_name(MODULE)


def _module() -> bytes:
    path = module_path()
    if not path.is_file():
        raise FileNotFoundError(
            f"the module of live pages, {MODULE}, is not here: the wheel of a release has it; with a clone, build it by "
            "`rustup target add wasm32-unknown-unknown` and `cargo build -p bksim-live --profile live --target "
            "wasm32-unknown-unknown`, and name it in BKSIM_LIVE"
        )
    return path.read_bytes()


@cache
def _widget() -> Any:
    import anywidget
    import traitlets

    class Live(anywidget.AnyWidget):
        """A live page that its notebook can read and change."""

        _esm = SCRIPT
        page = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int(640).tag(sync=True)
        text = traitlets.Unicode().tag(sync=True)
        time = traitlets.Float(0.0).tag(sync=True)
        selected = traitlets.Unicode("").tag(sync=True)

    return Live
