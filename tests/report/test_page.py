from __future__ import annotations

import base64
import hashlib
import html as html_module
import re

from gaitflow.report.interactive_map import interactive_map
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


def test_a_page_with_a_map_runs_its_own_script_only(scenario, labels, gaits) -> None:
    """Names that the scenario's checks would refuse, in every place where a name goes."""
    named = labels.assign(**{column: SCRIPT for column in ("gait", "label", "runner_up", "pattern")})
    data = interactive_map(named, [], scenario, gaits, None)
    html = render_page("a map", "what it is", [], [], data)
    assert html.count("<script") == 2 and SCRIPT not in html
    policy = html_module.unescape(re.findall(r'Security-Policy" content="([^"]*)"', html)[0])
    code = re.findall(r"<script>(.*)</script>", html, re.S)[0]
    assert f"script-src 'sha256-{base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()}'" in policy
    assert "default-src 'none'; img-src data:" in policy and "unsafe" not in policy
    assert not re.search(r"\son[a-z]+=|\sstyle=|https?:|@import|url\(|fetch\(", html)


def test_without_a_map_the_page_has_no_script() -> None:
    assert "<script" not in page(Section("none"))
