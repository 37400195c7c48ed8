"""One self-contained HTML page: nothing loaded from elsewhere, every text escaped, an interactive map if there is one.

Without JavaScript the page has everything else.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gaitflow.report.animation import PLAYER
from gaitflow.report.inline import packaged, policy, template
from gaitflow.report.tables import Table

SCRIPTS = (*PLAYER, "task_panel.js", "interactive_map.js")
STYLES = ("page.css", "player.css", "interactive_map.css")


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
    title: str,
    description: str,
    highlights: Sequence[tuple[str, str]],
    sections: Sequence[Section],
    interactive: Mapping[str, Any] | None = None,
) -> str:
    """The page as HTML. `highlights` are (name, value) pairs shown large at the top.

    `interactive` is what `interactive_map` gives, None for a page without a script.
    """
    script = "" if interactive is None else "".join(map(packaged, SCRIPTS))
    style = "".join(map(packaged, STYLES if interactive is not None else STYLES[:1]))
    return template("page.html.jinja").render(
        title=title,
        description=description,
        highlights=highlights,
        sections=sections,
        map=interactive,
        script=script,
        style=style,
        policy=policy(script, style),
    )
