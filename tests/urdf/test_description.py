"""Descriptions from strangers: what is read, and what is refused before any library sees it."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from gaitflow.config.file import ConfigError
from gaitflow.urdf import description
from gaitflow.urdf.description import label_of, read_description

Write = Callable[..., Path]
BOMB = (
    '<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    '<robot name="&b;"><link name="base"/></robot>'
)


def link(mass: str) -> str:
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    return f'<link name="a"><inertial><mass value="{mass}"/>{inertia}</inertial></link>'


def refusal(path: Path) -> str:
    with pytest.raises(ConfigError) as caught:
        read_description(path)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


def test_name_text_and_mass(write: Write) -> None:
    text = f'<robot name="box">{link("2.5")}<link name="b"/></robot>'
    read = read_description(write(text))
    assert (read.name, read.text, read.mass) == ("box", text, 2.5)


@pytest.mark.parametrize("text", [BOMB, '<robot name="a"><!-- <!entity x "y"> --></robot>'])
def test_entities_are_refused(write: Write, text: str) -> None:
    assert "DOCTYPE or ENTITY" in refusal(write(text))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32"])
def test_entities_cannot_hide_in_another_encoding(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "hidden.urdf"
    path.write_bytes(BOMB.encode(encoding))
    assert "not UTF-8" in refusal(path)


def test_too_large(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(description, "MAX_BYTES", 1000)
    assert "more than 1000 bytes" in refusal(write('<robot name="a">' + " " * 1000 + "</robot>"))


def test_a_device_without_end_is_too_large() -> None:
    assert "more than" in refusal(Path("/dev/zero"))


def test_too_many_links(write: Write) -> None:
    links = "".join(f'<link name="l{index}"/>' for index in range(description.MAX_LINKS + 1))
    assert "1001 links" in refusal(write(f'<robot name="a">{links}</robot>'))


def test_too_many_elements(write: Write) -> None:
    assert "60001 elements" in refusal(write(f'<robot name="a">{"<x/>" * 60_000}</robot>'))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not valid XML"),
        ("<robot name='a'>", "not valid XML"),
        ("<sdf version='1.6'/>", "expected <robot name=...>, found <sdf>"),
        ("<robot/>", "expected <robot name=...>"),
        ("<robot name='a'><link name='b'><inertial/></link></robot>", "link 'b' has mass value = ''"),
        *((f"<robot name='a'>{link(mass)}</robot>", repr(mass)) for mass in ("nan", "inf", "-1", "heavy")),
        (f"<robot name='a'>{link('1').replace('iyz', 'ijz')}</robot>", "link 'a' has inertia iyz = ''"),
    ],
)
def test_what_is_no_robot(write: Write, text: str, said: str) -> None:
    assert said in refusal(write(text))


def links(*moments: tuple[float, float, float]) -> str:
    """A robot with a link a triple of moments, 1 kg each."""
    parts = [
        f'<link name="l{index}"><inertial><mass value="1"/><inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link>'
        for index, (xx, yy, zz) in enumerate(moments)
    ]
    return f'<robot name="a">{"".join(parts)}</robot>'


@pytest.mark.parametrize("moments", [(0.3, 0.8, 5.0), (-0.1, 0.8, 0.9), (0.3, 0.8, 1.2), (0.0, 0.0, 1.0)])
def test_moments_that_no_body_has(write: Write, moments: tuple[float, float, float]) -> None:
    said = refusal(write(links((0.3, 0.8, 0.9), moments)))
    assert "link 'l1' has an inertia with the principal moments " in said
    assert "none is negative or larger than the sum of the other two" in said


def test_a_turned_inertia_is_judged_by_its_principal_moments(write: Write) -> None:
    turned = '<inertia ixx="1" ixy="0.9" ixz="0" iyy="1" iyz="0" izz="0.15"/>'  # 0.1, 0.15 and 1.9
    text = f'<robot name="a"><link name="l"><inertial><mass value="1"/>{turned}</inertial></link></robot>'
    assert "0.1 and 0.15 and 1.9 kg m^2" in refusal(write(text))


@pytest.mark.parametrize("moments", [(0.1, 0.2, 0.1 + 0.2), (0.0, 0.0, 0.0), (0.0, 0.1, 0.1), (0.0, 0.0, 3e-6)])
def test_flat_bodies_points_and_placeholders_too_small_to_matter_are_read(
    write: Write, moments: tuple[float, float, float]
) -> None:
    assert read_description(write(links((0.3, 0.8, 0.9), moments))).mass == 2.0


def chain(links: int) -> str:
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    names = [f"l{i}" for i in range(links)]
    parts = [f'<link name="{name}">{body}</link>' for name in names]
    parts += [
        f'<joint name="to_{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for parent, child in pairwise(names)
    ]
    return f'<robot name="a">{"".join(parts)}</robot>'


def test_what_the_library_that_reads_it_takes_ages_for_is_refused(write: Write) -> None:
    assert read_description(write(chain(50))).mass == 50.0
    assert "has 102 or more links one below the other; the most it may have are 100" in refusal(write(chain(600)))
    ring = chain(3).replace("</robot>", '<joint name="r"><parent link="l2"/><child link="l0"/></joint></robot>')
    assert "links one below the other" in refusal(write(ring))
    many = " ".join(f'a{i}="1"' for i in range(300_000))
    assert "has 300001 or more attributes in one element" in refusal(write(f'<robot name="a" {many}/>'))


def test_deeply_nested_elements_are_refused(write: Write) -> None:
    nested = "<a>" * 10_000 + "</a>" * 10_000
    assert "elements one inside the other; the most" in refusal(write(f'<robot name="a">{nested}</robot>'))


@pytest.mark.parametrize("name", ["l" * 201, "l&#10;m", "l\u202em"])
def test_names_that_no_error_could_show_are_refused(write: Write, name: str) -> None:
    said = refusal(write(f'<robot name="a"><link name="{name}"/></robot>'))
    assert "must have at most 200 letters, all printable" in said and said.isprintable() and len(said) < 300


def test_a_missing_file(tmp_path: Path) -> None:
    assert "cannot be read" in refusal(tmp_path / "no.urdf")


def test_labels_tell_nothing_of_the_machine() -> None:
    assert label_of(Path("/opt/env/share/example-robot-data/robots/a.urdf")) == "example-robot-data/robots/a.urdf"
    assert label_of(Path("/opt/secret/a.urdf")) == "a.urdf"
    assert label_of(Path("/share")) == "share"
