from __future__ import annotations

import base64
import re

from gaitflow.report.page import Picture, Section, render_page
from gaitflow.report.tables import Table

SCRIPT = "<script>alert('x')</script>"


def page(*sections: Section) -> str:
    return render_page("a map", "what it is", [("tasks", "84")], sections)


def test_every_text_is_escaped() -> None:
    table = Table((SCRIPT,), ((SCRIPT,),))
    section = Section(SCRIPT, (SCRIPT,), (Picture(b"png", SCRIPT + '"', SCRIPT),), table)
    html = render_page(SCRIPT, SCRIPT, [(SCRIPT, SCRIPT)], [section])
    assert "<script" not in html
    assert html.count("&lt;script&gt;") == 11


def test_nothing_is_loaded_from_elsewhere() -> None:
    html = page(Section("figures", pictures=(Picture(b"\x89PNG", "a figure"),)))
    assert re.findall(r'src="([^"]*)"', html) == ["data:image/png;base64," + base64.b64encode(b"\x89PNG").decode()]
    assert not re.search(r"https?:|<link|<script|@import|url\(", html)


def test_a_marked_row_stands_out_and_a_long_table_is_folded() -> None:
    short = Table(("a", "b"), (("1", "2"), ("3", "4")), marked=1)
    html = page(Section("short", table=short))
    assert '<tr class="marked"><td>3</td><td>4</td></tr>' in html
    assert "<details>" not in html
    long = Table(("a",), tuple((str(i),) for i in range(21)))
    assert "<summary>Show all 21 rows</summary>" in page(Section("long", table=long))


def test_an_empty_table_leaves_no_empty_head() -> None:
    assert "<table>" not in page(Section("none", ("Nothing here.",), table=Table(("a", "b"))))
