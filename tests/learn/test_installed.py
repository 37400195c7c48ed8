"""PyTorch is needed where the perceptron is trained, said before anything is solved, and loaded nowhere else."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from gaitflow.cli import main
from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Learning
from gaitflow.learn.installed import check_installed


@pytest.fixture
def without_torch(monkeypatch: pytest.MonkeyPatch) -> None:
    """From here on `import torch` fails, as where it is not installed."""
    monkeypatch.setitem(sys.modules, "torch", None)


@pytest.mark.usefixtures("without_torch")
def test_the_perceptron_is_refused_without_torch() -> None:
    with pytest.raises(ConfigError, match=r"mlp.* needs PyTorch.*gaitflow\[mlp\].*methods: \[svm, forest, knn\]"):
        check_installed(Learning())
    with pytest.raises(ConfigError, match=r"\{methods: \[knn\]\}"):
        check_installed(Learning(methods=("mlp", "knn")))
    check_installed(Learning(methods=("svm", "forest", "knn")))


@pytest.mark.usefixtures("without_torch")
@pytest.mark.parametrize("command", [["run"], ["train"], ["submit", "--profile", "centre-48h", "--dry-run"]])
def test_commands_say_so_in_one_line_before_anything_else(command: list[str], tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["--root", str(tmp_path), *command, "half-cheetah-exact-slopes"])
    assert done.exit_code == 2 and len(done.stderr.splitlines()) == 1 and "needs PyTorch" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("without_torch")
@pytest.mark.parametrize("command", [["validate", "--json"], ["solve", "--profile", "PROFILE"]])
def test_what_needs_no_torch_says_in_a_line_that_training_will(command: list[str], tmp_path: Path) -> None:
    """The profile is no profile, so that `solve` ends before it begins."""
    (tmp_path / "profile.yaml").write_text("{}")
    arguments = [each.replace("PROFILE", str(tmp_path / "profile.yaml")) for each in command]
    for scenario, told in (("half-cheetah-exact-slopes", 1), ("quickstart", 0)):
        done = CliRunner().invoke(main, ["--root", str(tmp_path), *arguments, scenario])
        said = [line for line in done.stderr.splitlines() if "can be solved here, but not trained" in line]
        assert len(said) == told and all("needs PyTorch" in line for line in said)
        assert command[0] == "solve" or (done.exit_code == 0 and json.loads(done.stdout)["scenario"] == scenario)


def test_torch_is_loaded_for_the_perceptron_only() -> None:
    code = "import sys, gaitflow.learn.train; print({'torch', 'skorch'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
