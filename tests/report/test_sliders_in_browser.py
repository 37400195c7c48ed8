"""The report of a map over four axes whose tasks lie anywhere, in a real browser: two sliders go through its slices."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browser import PROGRAM, Page, chromium

from gaitflow.report.interactive_map import interactive_map
from gaitflow.report.page import render_page

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(200),
    pytest.mark.skipif(PROGRAM is None, reason="needs the browser chromium or google-chrome"),
]
SLIDERS = "[...document.querySelectorAll('#sliders output')].map((each) => each.textContent)"
TITLES = "[...document.querySelectorAll('#map .task')].map((mark) => mark.ariaLabel)"
REGIONS = "[...document.querySelectorAll('#map g path')].map((path) => path.getAttribute('d')).join()"


@pytest.fixture(scope="module")
def page(turning, turning_labels, gaits, turning_select, tmp_path_factory) -> Iterator[Page]:
    folder = tmp_path_factory.mktemp("four_axes")
    # The map has no task to the far right, so that slices there are without one.
    labels = turning_labels[(turning_labels["yaw_rate"] > -0.4) | (turning_labels["lateral_speed"] > -0.3)]
    data = interactive_map(labels, [], turning, gaits, turning_select)
    (folder / "index.html").write_text(render_page("four axes", "", [], [], data), encoding="utf-8")
    with chromium(folder / "browser") as page:
        page.open((folder / "index.html").as_uri())
        yield page
        assert page.complaints == [] and page.requests == [(folder / "index.html").as_uri()]


def slide(page: Page, slider: int, place: int) -> list[str]:
    """Move a slider; the values that both then tell."""
    page.evaluate(
        f"(() => {{ const slider = document.querySelectorAll('#sliders input')[{slider}]; slider.value = {place}; "
        "slider.dispatchEvent(new Event('input')); })()"
    )
    return list(page.evaluate(SLIDERS))


def value(title: str, symbol: str) -> float:
    return float(title.split(f"{symbol} = ")[1].split(" ")[0])


def test_two_sliders_lead_to_every_slice_and_to_every_task(page: Page, turning_labels) -> None:
    shown, pictures = [], set()
    for place, lateral in enumerate(("-0.4", "-0.2", "0", "0.2", "0.4")):
        for further, yaw in enumerate(("-0.6", "-0.2", "0.2", "0.6")):
            slide(page, 0, place)
            assert slide(page, 1, further) == [f"{lateral} m/s", f"{yaw} rad/s"]
            titles = page.evaluate(TITLES)
            assert all(abs(value(title, "v_y") - float(lateral)) <= 0.1 + 1e-6 for title in titles)
            assert all(abs(value(title, "yaw rate") - float(yaw)) <= 0.2 + 1e-6 for title in titles)
            shown += titles
            pictures.add(page.evaluate(REGIONS))
    missing = (turning_labels["yaw_rate"] <= -0.4) & (turning_labels["lateral_speed"] <= -0.3)
    assert len(shown) == (~missing).sum() > 300 and len(pictures) > 6


def test_searched_tasks_are_circles_and_held_out_ones_diamonds(page: Page, turning_labels) -> None:
    text = page.evaluate("document.querySelector('#explorer p').textContent")
    assert "circles are searched tasks" in text and "each in the slice nearest to it" in text
    slide(page, 0, 2)
    slide(page, 1, 2)
    here = turning_labels[(turning_labels["lateral_speed"].abs() < 0.1) & turning_labels["yaw_rate"].between(0, 0.4)]
    count = "document.querySelectorAll('#map .task {0}').length"
    held_out = (here["split"] == "held_out").sum()
    assert page.evaluate(count.format("circle:not(.halo, .tied)")) == len(here) - held_out
    assert page.evaluate(count.format("path")) == held_out > 0


def test_a_slice_without_a_task_says_so_and_shows_its_regions(page: Page) -> None:
    slide(page, 0, 0)
    slide(page, 1, 0)
    assert page.evaluate(TITLES) == [] and page.evaluate(REGIONS)
    assert page.evaluate("document.querySelector('#pointed').textContent") == "No task in this slice."
    slide(page, 1, 2)
    assert "v_y = -0." in page.evaluate("document.querySelector('#title').textContent")
