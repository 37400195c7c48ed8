"""A robot written is the robot read."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.config.robot import Robot, load_robot
from gaitflow.urdf.write import write_robot

CONFIGS = Path(__file__).parents[2] / "configs" / "robots"


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_round_trip(path: Path, tmp_path: Path) -> None:
    robot = load_robot(path)
    write_robot(tmp_path / "copy.yaml", robot, ["made by a test"], replace=False)
    assert load_robot(tmp_path / "copy.yaml") == robot
    assert (tmp_path / "copy.yaml").read_text().startswith("# made by a test\nname: ")


def test_names_and_numbers_that_yaml_would_misread(tmp_path: Path) -> None:
    foot = {"NO": (1e-5, 0.2, -0.5), "ON": (1e-5, -0.2, -0.5)}
    robot = Robot.from_data(
        {
            "name": "1234",
            "dimension": 3,
            "mass": 1e22,
            "inertia": [[1.0, 0.0, -1e-5], [0.0, 1.0, 0.0], [-1e-5, 0.0, 1.0]],
            "legs": [{"name": name, "default_foot": where} for name, where in foot.items()],
            "box": [1e-7, 0.1, 0.1],
            "max_force": 500.0,
            "max_foot_speed": 0.1 + 0.2,
            "max_tilt": 0.5,
            "mirror": [["NO", "ON"]],
            "source": 'a "quoted": #text',
        },
        "here",
    )
    write_robot(tmp_path / "robot.yaml", robot, [], replace=False)
    assert load_robot(tmp_path / "robot.yaml") == robot


@pytest.mark.parametrize("end", ["\n", "\r", "\x85", "\u2028", "\udcff", "\x00"])
def test_a_comment_stays_one_line(tmp_path: Path, end: str) -> None:
    """A file's name, which it may hold, may have any character."""
    robot = load_robot(CONFIGS / "half_cheetah.yaml")
    write_robot(tmp_path / "a.yaml", robot, [f"import my{end}mass: 1.0"], replace=False)
    assert load_robot(tmp_path / "a.yaml") == robot
    first = (tmp_path / "a.yaml").read_text().split("\n")[0]
    assert first.startswith("# import my\\") and first.endswith("mass: 1.0") and first.isprintable()


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    robot = load_robot(CONFIGS / "half_cheetah.yaml")
    write_robot(tmp_path / "a.yaml", robot, [], replace=False)
    with pytest.raises(FileExistsError):
        write_robot(tmp_path / "a.yaml", robot, ["new"], replace=False)
    assert "new" not in (tmp_path / "a.yaml").read_text()
    write_robot(tmp_path / "a.yaml", robot, ["new"], replace=True)
    assert "new" in (tmp_path / "a.yaml").read_text()
