"""The report of the published map with three axes, in a real browser: clicked, tapped, walked through by keys."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from browser import PROGRAM, Page, chromium

from gaitflow.publishing.find import dataset_of_map, version_folder
from gaitflow.report.published import write_map_report

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(400),
    pytest.mark.skipif(PROGRAM is None, reason="needs the browser chromium or google-chrome"),
]
CHOSEN = "#map .task[aria-pressed=true]"
OTHER = "#map .task[aria-label^='v = 0.375 m/s, T = 1 s, slope = 0°']"
TITLE = "document.querySelector('#title').textContent"
PHONE = 390  # px


@pytest.fixture(scope="module")
def file(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    model = version_folder(checkout / "models/half-cheetah-exact-slopes/1.1.0")  # searched on a grid
    write_map_report(folder, model, dataset_of_map(model, checkout / "datasets"))
    return folder / "index.html"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with chromium(tmp_path_factory.mktemp("browser")) as page:
        yield page


@pytest.fixture
def page(browser: Page, file: Path) -> Iterator[Page]:
    """The report, opened anew; whatever a test does there, nothing is complained of and nothing is asked for."""
    browser.complaints.clear()
    browser.requests.clear()
    browser.open(file.as_uri())
    yield browser
    assert browser.complaints == []
    assert {address for address in browser.requests if not address.startswith("data:image/png;")} == {file.as_uri()}


def seen(page: Page) -> np.ndarray:
    return matplotlib.image.imread(io.BytesIO(page.picture()))[..., :3]


def test_a_page_that_complains_or_asks_would_be_noticed(tmp_path: Path) -> None:
    loud = tmp_path / "loud.html"
    loud.write_text("<script>console.warn('one'); fetch('data.json'); missing.field;</script>", encoding="utf-8")
    with chromium(tmp_path / "browser") as page:
        page.open(loud.as_uri())
        assert any("one" in text for text in page.complaints)
        assert any("ReferenceError" in text for text in page.complaints)
        assert (tmp_path / "data.json").as_uri() in page.requests


def test_it_is_small_enough_to_send(file: Path) -> None:
    assert file.stat().st_size < 10_000_000


def test_a_clicked_task_is_told_and_its_motion_plays(page: Page) -> None:
    before = page.evaluate(TITLE)
    page.click(OTHER)
    assert page.evaluate(TITLE) == "v = 0.375 m/s, T = 1 s, slope = 0°" != before
    assert page.evaluate("document.querySelector('#gait').textContent") == "gallop-walk"
    assert page.evaluate("document.querySelector('#pointed').textContent").endswith("slope = 0°: gallop-walk")
    facts = page.evaluate("[...document.querySelectorAll('#facts dt')].map((name) => name.textContent)")
    assert {"cost", "margin", "cost error", "the map's choice", "pattern"} <= set(facts)
    assert page.evaluate("document.querySelectorAll('#rivals tbody tr').length") == 8
    page.wait_for("Number(document.querySelector('#time').value) > 0")
    page.click("#play")
    assert page.evaluate("document.querySelector('#play').textContent") == "Play"
    at = page.evaluate("document.querySelector('#view').toDataURL()")
    page.evaluate("document.querySelector('#view').focus()")
    page.press("ArrowRight")  # the robot is planar: nothing turns
    assert page.evaluate("document.querySelector('#view').toDataURL()") == at


def test_a_task_between_the_slices_can_be_chosen(page: Page) -> None:
    held_out = "[...document.querySelectorAll('#map .task')].findIndex((mark) => !/= 0°:/.test(mark.ariaLabel))"
    place = page.evaluate(held_out)
    page.evaluate(
        f"document.querySelectorAll('#map .task')[{place}].dispatchEvent(new MouseEvent('click', {{ bubbles: true }}))"
    )
    assert "slope = 0°" not in page.evaluate(TITLE)
    assert page.evaluate("document.querySelector('#facts dd').textContent") == "held-out"


def test_the_slider_goes_to_another_slope(page: Page) -> None:
    regions = "[...document.querySelectorAll('#map g path')].map((path) => path.getAttribute('d')).join()"
    page.click(OTHER)
    before = page.evaluate(regions)
    page.evaluate("document.querySelector('#sliders input').focus()")
    page.press("ArrowRight")
    slope = page.evaluate("document.querySelector('#sliders output').textContent")
    assert slope not in ("", "0°")
    assert page.evaluate(TITLE) == f"v = 0.375 m/s, T = 1 s, slope = {slope}"
    assert page.evaluate(regions) != before


def test_arrow_keys_go_from_task_to_task(page: Page) -> None:
    page.click(OTHER)
    titles = []
    for key in ("ArrowRight", "ArrowUp", "ArrowLeft", "ArrowDown"):
        page.press(key)
        titles.append(page.evaluate(TITLE))
    moved = ["v = 0.65 m/s, T = 1 s", "v = 0.65 m/s, T = 1.3 s", "v = 0.375 m/s, T = 1.3 s", "v = 0.375 m/s, T = 1 s"]
    assert titles == [f"{title}, slope = 0°" for title in moved]
    assert page.evaluate(f"document.activeElement === document.querySelector({CHOSEN!r})")
    assert page.evaluate("document.querySelectorAll('#map [tabindex=\"0\"]').length") == 1


def test_on_a_phone_nothing_is_cut_and_a_tap_chooses(page: Page, file: Path) -> None:
    page.open(file.as_uri(), PHONE, 844, mobile=True)
    wide = "document.documentElement.scrollWidth"
    assert page.evaluate(wide) == PHONE
    page.tap(OTHER)
    page.wait_for(f"{TITLE} === 'v = 0.375 m/s, T = 1 s, slope = 0°'")
    assert page.evaluate(wide) == PHONE
    page.middle("#view")
    picture = seen(page)
    assert picture.shape[1] == PHONE
    colour = np.array([0x56, 0xB4, 0xE9]) / 255  # of the gallop-walk: a leg that stands, the bars of its diagram
    assert (np.abs(picture - colour).max(axis=2) < 0.02).sum() > 500


def test_every_part_has_a_name_for_those_who_cannot_see_it(page: Page) -> None:
    nodes = page.send("Accessibility.getFullAXTree")["nodes"]
    named = {"button", "slider", "checkbox", "combobox", "image", "img", "Canvas"}
    roles = [(node["role"]["value"], node.get("name", {}).get("value", "")) for node in nodes if "role" in node]
    assert {role for role, _ in roles} >= {"button", "slider", "checkbox"}
    assert not [role for role, name in roles if role in named and not name]


def test_without_javascript_pictures_and_tables_are_there(browser: Page, file: Path) -> None:
    browser.send("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.open(file.as_uri())
        assert browser.evaluate("document.querySelector('#explorer').offsetHeight") == 0
        assert browser.evaluate("[...document.images].filter((image) => image.naturalWidth > 300).length") >= 6
        assert browser.evaluate("document.querySelectorAll('table').length") >= 5
    finally:
        browser.send("Emulation.setScriptExecutionDisabled", value=False)
