from __future__ import annotations

import base64
import re
from dataclasses import replace

import matplotlib.image
import pandas as pd
import pytest

from gaitflow.report.report import PAGE, png_of, write_report


@pytest.fixture(scope="module")
def written(tmp_path_factory, scenario, labels, solutions, gaits, select, learning, record):
    folder = tmp_path_factory.mktemp("report") / "new"
    return folder, write_report(folder, scenario, labels, solutions, gaits, select, learning, record)


def test_all_files_are_there_and_nothing_else(written) -> None:
    folder, paths = written
    motions = {"walking", "gallop-walk", "pronking", "gallop", "gallop-bound", "bounding"}
    expected = {"map.png", "gaits.png", "state_space.png", PAGE, *(f"motion-{name}.png" for name in motions)}
    assert {path.name for path in paths} == expected
    assert {path.name for path in folder.iterdir()} == expected


def test_pictures_are_readable_when_shown_small(written) -> None:
    folder, _ = written
    height, width, _ = matplotlib.image.imread(folder / "map.png").shape
    assert 1200 <= width <= 1300  # 8.4 inches at 150 dpi: letters of 10 points stay above 12 pixels at 800
    assert height > 600


def test_the_page_holds_the_pictures_that_were_written(written) -> None:
    folder, paths = written
    html = (folder / PAGE).read_text(encoding="utf-8")
    inlined = {base64.b64decode(data) for data in re.findall(r"base64,([A-Za-z0-9+/=]+)", html)}
    assert inlined == {path.read_bytes() for path in paths if path.suffix == ".png"}


def test_the_page_states_scenario_ties_unsolved_tasks_winner_and_origin(written, record, learning) -> None:
    html = (written[0] / PAGE).read_text(encoding="utf-8")
    for text in (
        "force 1.",
        "slope 0°",
        "friction 0.8",
        "12 values of speed from 0.1 to 2.3 m/s",
        "one stance",
        record["units_digest"],
        learning["rule"],
        "3e-09",
    ):
        assert text in html
    assert re.search(r'<tr class="marked"><td>svm</td>', html)
    assert re.search(r"<h2>Tasks without a gait</h2>.*<td>1.6</td><td>grid</td><td>infeasible</td>", html, re.S)


def test_without_classifier_and_trajectories_there_is_a_map_and_a_page(
    tmp_path, scenario, labels, solutions, gaits, record
) -> None:
    bare = [replace(solution, trajectory=None) for solution in solutions]
    paths = write_report(tmp_path, scenario, labels, bare, gaits, None, None, record)
    assert [path.name for path in paths] == ["map.png", PAGE]
    assert "No classifier was trained." in (tmp_path / PAGE).read_text(encoding="utf-8")


def test_a_map_in_space(tmp_path, anymal, labels, trot, solved, record) -> None:
    walk = solved(0.2, 0.8, "0111/1101/1101/0111")
    named = [("walking trot", trot), ("four-beat walk 0111/1011/1110/1101", walk)]
    rows = [
        labels.iloc[0].to_dict()
        | {"speed": one.task.speed, "cycle_duration": 0.8, "gait": name, "gait_key": one.gait, "pattern": one.pattern}
        | {"cost": one.cost, "ties": [name], "label": name}
        for name, one in named
    ]
    paths = write_report(tmp_path, anymal, pd.DataFrame(rows), [trot, walk], [], None, None, record)
    motions = ["motion-walking-trot.png", "motion-four-beat-walk-0111-1011-1110-1101.png"]
    assert {path.name for path in paths} == {"map.png", "gaits.png", "state_space.png", PAGE, *motions}
    html = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "<h2>Every label checked again</h2>" in html and "2 of 2 labelled motions" in html
    assert "<td>slip in stance</td>" in html and "<td>NO</td>" not in html


def test_a_gait_named_by_its_diagram_stays_in_the_folder(tmp_path, scenario, labels, solution_of, record) -> None:
    name = "F 0110 / H ../../1100"
    one = labels[labels["gait"] == "gallop"].iloc[:1].assign(gait=name, label=name, split="grid")
    row = one.iloc[0]
    solution = solution_of(row["speed"], row["cycle_duration"], "gallop")
    folder = tmp_path / "report"
    paths = write_report(folder, scenario, one, [solution], [name], None, None, record)
    assert [path.name for path in paths] == ["map.png", "gaits.png", "state_space.png", "motion-1.png", PAGE]
    assert all(path.parent == folder and path.is_file() for path in paths)


def test_a_map_over_slopes_says_which_slices_it_draws(
    tmp_path, sloped, sloped_labels, gaits, solution_of, record
) -> None:
    write_report(tmp_path, sloped, sloped_labels, [], gaits, None, None, record)
    html = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "9 of 12 slices of the map are drawn" in html and "12 values of slope from -22 to 22°" in html


def test_labels_that_the_mesh_leaves_open_are_listed(tmp_path, scenario, labels, record) -> None:
    told = labels.assign(cost_error=1e-3, resolved=labels["speed"] > 0.2)
    write_report(tmp_path, scenario, told, [], [], None, None, record)
    html = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert re.search(r"<h2>Labels that the mesh leaves open</h2>.*smaller than the error.*<td>0.1 %</td>", html, re.S)
    write_report(tmp_path, scenario, told.assign(resolved=True), [], [], None, None, record)
    assert "Every margin is larger than the errors" in (tmp_path / PAGE).read_text(encoding="utf-8")


def test_equal_figures_have_equal_bytes(labels, gaits, tasks) -> None:
    from gaitflow.report.gait_map import draw_gait_map

    one, two = (png_of(draw_gait_map(labels, gaits, None, "a map", tasks)) for _ in range(2))
    assert one == two
