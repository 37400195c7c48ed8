from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from gaitflow.config.cluster import Profile, lifetime, load_profile, walltime_seconds
from gaitflow.config.directives import OF_PBS, OF_SLURM
from gaitflow.config.file import ConfigError
from gaitflow.config.schemas import file_schemas

PROFILES = sorted((Path(__file__).parents[2] / "slurm" / "profiles").glob("*.yaml"))
LEAST = {"name": "a", "walltime": "01:00:00", "jobs": 1}


def profile(**fields: Any) -> Profile:
    return Profile.from_data(LEAST | fields, "a.yaml")


@pytest.mark.parametrize("file", PROFILES, ids=lambda file: file.stem)
def test_shipped_profiles_are_sound_and_fit_the_schema(file: Path) -> None:
    loaded = load_profile(file)
    assert loaded.name == file.stem
    assert loaded.tls, "encrypted unless somebody says otherwise"
    jsonschema.validate(json.loads(loaded.model_dump_json()), file_schemas()["profile.schema.json"])


def test_there_are_a_centre_a_preemptible_one_and_that_of_the_tests() -> None:
    assert [file.stem for file in PROFILES] == ["centre-48h", "pbs-centre-48h", "preemptible", "test-cluster"]
    assert load_profile(PROFILES[0]).walltime_s == 48 * 3600


@pytest.mark.parametrize(
    ("text", "seconds"), [("00:01:00", 60), ("48:00:00", 172_800), ("2-00:00:00", 172_800), ("1-01:01:01", 90_061)]
)
def test_walltimes(text: str, seconds: int) -> None:
    assert walltime_seconds(text) == seconds


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"walltime": "1:2"}, """walltime: '1:2': must be "HH:MM:SS" or "D-HH:MM:SS\""""),
        ({"walltime": "00:60:00"}, "walltime: '00:60:00': must be"),
        ({"walltime": 172800}, 'walltime: 172800 is a number to YAML: write the time in quotes, such as "48:00:00"'),
        ({"walltime": "00:00:59"}, "walltime: '00:00:59': at least one minute"),
        ({"memory": "2 GB"}, "memory: '2 GB': must be a whole number of MB, GB or TB"),
        ({"memory": "0GB"}, "memory: '0GB'"),
        ({"jobs": 0}, "jobs = 0: Input should be greater than or equal to 1"),
        ({"jobs": 10_001}, "jobs = 10001: Input should be less than or equal to 10000"),
        ({"partition": "a b"}, "partition = 'a b'"),
        ({"account": "-x"}, "account = '-x'"),
        ({"scratch": "$(reboot)"}, "scratch = '$(reboot)'"),
        ({"scratch": 'a"; reboot; "'}, "scratch = "),
        ({"scratch": "relative"}, "scratch = 'relative'"),
        ({"interface": "ib0 --x"}, "interface = 'ib0 --x'"),
        ({"setup": ["module load a\nreboot"]}, "setup.0: 'module load a\\nreboot': must be one line of shell"),
        ({"setup": [" "]}, "setup.0: ' ': must be one line of shell"),
        ({"directives": ["-p long"]}, "directives.0: '-p long': must be one option in full"),
        ({"directives": ["qos=long"]}, "directives.0: 'qos=long': must be one option in full"),
        ({"directives": ["--qos=a\n#SBATCH --time=1"]}, "must be one line"),
        ({"directives": ["--time=1"]}, "directives.0: '--time=1': --time is set by gaitflow: use the field walltime"),
        ({"directives": ["--ti=1"]}, "--time is set by gaitflow"),
        ({"directives": ["--mem-per-cpu=1G"]}, "--mem-per-cpu is set by gaitflow: use the field memory"),
        ({"driver": {"walltime": "00:01:00"}}, "driver.walltime: '00:01:00': at least five minutes"),
        ({"driver": {"directives": ["--comment=x"]}}, "driver.directives.0: '--comment=x': --comment is set"),
        ({"margin_s": 1801}, "margin_s = 1801: must be at most half of the walltime, 01:00:00 = 3600 s"),
        ({"margin_s": -1}, "margin_s = -1"),
        ({"wall_time": "01:00:00"}, "wall_time = '01:00:00': unknown field, did you mean walltime?"),
    ],
)
def test_a_fault_is_told_in_one_line(fields: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError) as error:
        profile(**fields)
    (line,) = str(error.value).splitlines()
    assert line.startswith("a.yaml: ") and said in line


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(ConfigError) as error:
        profile(jobs=0, memory="much", walltime="soon")
    assert len(str(error.value).splitlines()) == 3


def test_a_walltime_without_quotes_is_understood_or_explained(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("name: a\njobs: 1\nwalltime: 48:00:00\n")  # YAML makes 172800 of it
    with pytest.raises(ConfigError, match="write the time in quotes"):
        load_profile(file)


def test_every_option_of_the_scripts_is_refused_as_a_directive() -> None:
    for option in OF_SLURM:
        with pytest.raises(ConfigError, match=f"--{option} is set by gaitflow"):
            profile(directives=[f"--{option}=1"])


def test_the_same_holds_for_pbs() -> None:
    for option in OF_PBS:
        with pytest.raises(ConfigError, match=f"{option} is set by gaitflow"):
            profile(scheduler="pbs", directives=[f"{option}=1" if " " in option else f"{option} 1"])
    for two in ("-m abe -v A=1", "-m -N", "-Nother"):
        with pytest.raises(ConfigError, match="must be one option"):
            profile(scheduler="pbs", directives=[two])
    with pytest.raises(ConfigError, match="-l walltime is set by gaitflow: use the field walltime"):
        profile(scheduler="pbs", directives=["-l place=excl,walltime=1"])


@pytest.mark.parametrize("text", ["-l place=excl", "-m abe", "-W group_list=robots", "-P project", "-V"])
def test_other_options_of_qsub_are_let_through_for_pbs_alone(text: str) -> None:
    assert profile(scheduler="pbs", directives=[text]).directives == (text,)
    with pytest.raises(ConfigError, match=r"^a.yaml: directives.0: '-.*: must be one option in full"):
        profile(directives=[text])
    with pytest.raises(ConfigError, match=r"^a.yaml: driver.directives.0: '--qos=long': must be one option of qsub"):
        profile(scheduler="pbs", driver={"directives": ["--qos=long"]})


def test_a_profile_for_slurm_is_the_data_that_it_was() -> None:
    assert "scheduler" not in profile(scheduler="slurm").as_data()
    assert profile(scheduler="pbs").as_data()["scheduler"] == "pbs"
    assert Profile.from_data(profile(scheduler="pbs").as_data(), "a.yaml") == profile(scheduler="pbs")


@pytest.mark.parametrize("text", ["--exclusive", "--qos=long", "--constraint=a&b", "--gres=lscratch:10", "--nice"])
def test_other_options_are_let_through(text: str) -> None:
    assert profile(directives=[text]).directives == (text,)


@pytest.mark.parametrize("longest", [0.0, 60.0, 1000.0])
def test_the_longest_unit_and_the_margin_fit_behind_every_lifetime(longest: float) -> None:
    one = profile(margin_s=100)
    life, stagger = lifetime(one, longest)
    assert stagger > 0
    assert life + stagger + longest + one.margin_s == pytest.approx(one.walltime_s)


def test_a_worker_lives_for_half_of_a_walltime_that_is_too_short() -> None:
    life, stagger = lifetime(profile(), 3600.0)
    assert life + stagger == pytest.approx(1800.0) and life - stagger > 1000


@pytest.mark.parametrize("field", ["walltime", "memory"])
def test_a_text_of_any_length_is_told_in_short(field: str) -> None:
    with pytest.raises(ConfigError) as caught:
        profile(**{field: "x" * 5000})
    assert f"{field}: 'xxx" in str(caught.value) and len(str(caught.value)) < 200
