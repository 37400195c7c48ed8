"""One self-contained HTML page: no script, nothing loaded from elsewhere, every text escaped."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

from jinja2 import Environment, StrictUndefined

from gaitflow.report.tables import Table


@dataclass(frozen=True)
class Picture:
    """A PNG inlined into the page; `alt` is read out where it cannot be seen, `caption` is printed below it."""

    png: bytes
    alt: str
    caption: str = ""

    @property
    def base64(self) -> str:
        """The bytes as a data URL carries them."""
        return base64.b64encode(self.png).decode("ascii")


@dataclass(frozen=True)
class Section:
    """A heading with paragraphs, pictures and a table below it; a long table is folded away."""

    title: str
    text: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    table: Table | None = None


def render_page(
    title: str, description: str, highlights: Sequence[tuple[str, str]], sections: Sequence[Section]
) -> str:
    """The page as HTML. `highlights` are (name, value) pairs shown large at the top."""
    source = files("gaitflow.report").joinpath("page.html.jinja").read_text(encoding="utf-8")
    template = Environment(autoescape=True, undefined=StrictUndefined).from_string(source)
    return template.render(title=title, description=description, highlights=highlights, sections=sections)
