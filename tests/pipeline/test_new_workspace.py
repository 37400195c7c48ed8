"""`gaitflow init`: what it writes is of use at once, and it writes over nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from gaitflow.cli import main
from gaitflow.config.file import ConfigError
from gaitflow.pipeline.new_workspace import new_workspace
from gaitflow.pipeline.workspace import Workspace


def test_a_new_workspace_holds_a_scenario_and_its_robot(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["init", str(tmp_path / "my-maps")])
    assert done.exit_code == 0, done.output
    folder = tmp_path / "my-maps"
    files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    assert files == {
        "README.md", ".gitignore", "configs/robots/half_cheetah.yaml", "configs/scenarios/quickstart.yaml"
    }  # fmt: skip
    robot = folder / "configs/robots/half_cheetah.yaml"
    robot.write_text(robot.read_text().replace("mass: 14.0", "mass: 20.0"))
    assert Workspace(folder).scenario("quickstart").robot.mass == 20.0
    commands = [line for line in (folder / "README.md").read_text().splitlines() if line.startswith("    gaitflow ")]
    assert len(commands) == 5


def test_nothing_is_written_over_and_nothing_half_written(tmp_path: Path) -> None:
    (tmp_path / "README.md").write_text("mine")
    with pytest.raises(ConfigError, match=r"README\.md: is there already"):
        new_workspace(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["README.md"]
    (tmp_path / "README.md").unlink()
    assert all(file.is_file() for file in new_workspace(tmp_path)), "an empty folder is as good as a new one"
