"""Reading YAML that may be wrong, damaged or hostile."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import pytest
from pydantic import Field

from gaitflow.config.file import MAX_CONFIG_BYTES, MAX_ERRORS, Config, ConfigError, read_yaml


class Wheel(Config):
    radius: Annotated[float, Field(gt=0)]


class Cart(Config):
    wheels: tuple[Wheel, ...] = ()
    load: float = 0.0


def refusal(path: Path, content: str | bytes) -> str:
    """What read_yaml says of a file with this content, without the path it must begin with."""
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(ConfigError) as caught:
        read_yaml(path)
    assert str(caught.value).startswith(str(path))
    return str(caught.value).removeprefix(str(path))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "cart.yaml"


def test_plain_data_is_read(file: Path) -> None:
    file.write_text("a: 1\nb: [1.5, text, null, true]\nc: {d: 1.0e+6}\ne: 2024-01-31\n", encoding="utf-8")
    assert read_yaml(file) == {"a": 1, "b": [1.5, "text", None, True], "c": {"d": 1e6}, "e": "2024-01-31"}


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("a: 1\nb: c: d\n", ", line 2, column 5: not valid YAML (mapping values are not allowed here)"),
        ("a: [1, 2\n", "not valid YAML"),
        ("a: 1\nb: 2\na: 3\n", ", line 3, column 1: not valid YAML ('a' is given twice)"),
        ("a: {b: 1, b: 1}\n", "'b' is given twice"),
        ("a: &x [1]\nb: *x\n", ", line 2, column 4: not valid YAML (aliases are not allowed, write it out)"),
        ("a: &x [*x]\n", "aliases are not allowed"),
        ("a: !!python/object/apply:os.getcwd []\n", "could not determine a constructor for the tag"),
        ("a: !!binary aGVsbG8=\n", "could not determine a constructor for the tag"),
        ("a: !!set {b, c}\n", "could not determine a constructor for the tag"),
        ("? [1, 2]\n: 3\n", "found unhashable key"),
        ("a: 1\n---\nb: 2\n", "but found another document"),
        (b"a: \xff\xfe\n", "not valid YAML ('utf-8' codec can't decode"),
        (b"a: \x00\n", "not valid YAML (unacceptable character"),
        ("[" * 50_000, "not valid YAML (nested too deep)"),
        ("a: " + "9" * 5000, "not valid YAML (Exceeds the limit"),
        (
            "a: 48:00:00",
            "line 1, column 4: not valid YAML ('48:00:00' is a number in base 60: write the time in",
        ),
        ("a: " + "1:" * 300 + "1.5", "is a number in base 60"),
    ],
)
def test_what_is_not_plain_yaml_is_refused(file: Path, content: str | bytes, said: str) -> None:
    assert said in refusal(file, content)


def test_a_file_is_read_up_to_the_limit_only(file: Path) -> None:
    file.write_text("a: " + "x" * (MAX_CONFIG_BYTES - 3), encoding="utf-8")
    assert len(read_yaml(file)["a"]) == MAX_CONFIG_BYTES - 3
    said = refusal(file, "a: " + "x" * (MAX_CONFIG_BYTES - 2))
    assert said == ": more than 100000 bytes, the most a configuration may have"


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"absent\.yaml: cannot be read \(No such file or directory\)"):
        read_yaml(tmp_path / "absent.yaml")
    with pytest.raises(ConfigError, match=r"cannot be read \(Is a directory\)"):
        read_yaml(tmp_path)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (None, "cart.yaml: expected a mapping of fields (`field: value` lines), found nothing: the file is empty"),
        ([1, 2], "cart.yaml: expected a mapping of fields (`field: value` lines), found a list, [1, 2]"),
        ("x", "cart.yaml: expected a mapping of fields (`field: value` lines), found a str, 'x'"),
        ({"lode": 1}, "cart.yaml: lode = 1: unknown field, did you mean load? allowed: wheels, load"),
        ({"zzz": 1}, "cart.yaml: zzz = 1: unknown field; allowed: wheels, load"),
        ({"wheels": [{"radius": 1, "hub": 2}]}, "cart.yaml: wheels.0.hub = 2: unknown field; allowed: radius"),
        ({"a\n\x1b[31m": 1}, r"cart.yaml: 'a\n\x1b[31m' = 1: unknown field; allowed: wheels, load"),
        ({"wheels": [{}]}, "cart.yaml: wheels.0.radius: missing; this field has no default"),
        ({"wheels": 3}, "cart.yaml: wheels = 3: Input should be a valid array"),
        ({"load": True}, "cart.yaml: load = True: Input should be a valid number"),
        (
            {"load": "1e6"},
            "cart.yaml: load = '1e6': Input should be a valid number; this is text: write it without quotes, and an "
            "exponent as in 1.0e+6",
        ),
        ({"load": float("nan")}, "cart.yaml: load = nan: Input should be a finite number"),
        ({"load": -float("inf")}, "cart.yaml: load = -inf: Input should be a finite number"),
    ],
)
def test_errors_name_file_field_value_and_what_is_allowed(data: object, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        Cart.from_data(data, "cart.yaml")
    assert str(caught.value) == said


@pytest.mark.parametrize("data", [{"load": {1, 2}}, {"load": object()}])
def test_data_that_is_not_plain_is_refused(data: object) -> None:
    with pytest.raises(ConfigError, match=r"^cart\.yaml: a value is not plain data"):
        Cart.from_data(data, "cart.yaml")


@pytest.mark.parametrize("value", [10**400, "x" * 100_000, "\ud800", [[[["deep"]]]] * 1000])
def test_errors_stay_short(value: object) -> None:
    with pytest.raises(ConfigError) as caught:
        Cart.from_data({"load": value}, "cart.yaml")
    assert str(caught.value).startswith("cart.yaml: ")
    assert len(str(caught.value)) < 300


def test_every_error_has_its_line_up_to_a_limit() -> None:
    with pytest.raises(ConfigError) as caught:
        Cart.from_data({"load": "a", "wheels": [{"radius": -1}, {"radius": 0}]}, "cart.yaml")
    assert [line.split(":")[1].split()[0] for line in str(caught.value).splitlines()] == [
        "wheels.0.radius",
        "wheels.1.radius",
        "load",
    ]
    with pytest.raises(ConfigError) as caught:
        Cart.from_data({"wheels": [{"radius": -1}] * 1000}, "cart.yaml")
    lines = str(caught.value).splitlines()
    assert len(lines) == MAX_ERRORS + 1
    assert lines[-1] == f"cart.yaml: and {1000 - MAX_ERRORS} more errors"
