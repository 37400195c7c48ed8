"""The contact point of a foot is the lowest point of its spheres."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.urdf.contact import contact_point
from gaitflow.urdf.description import Description, read_description
from gaitflow.urdf.importing import Request, import_robot

Write = Callable[..., Path]
TURNED = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # x of the link points down


def described(write: Write, *spheres: str) -> Description:
    collisions = "".join(f"<collision>{sphere}</collision>" for sphere in spheres)
    return read_description(write(f'<robot name="r"><link name="foot">{collisions}</link></robot>'))


def sphere(radius: str, at: str | None = None) -> str:
    origin = "" if at is None else f'<origin xyz="{at}"/>'
    return f'{origin}<geometry><sphere radius="{radius}"/></geometry>'


def test_the_lowest_point(write: Write) -> None:
    one = described(write, sphere("0.03", "0 0 0.01"))
    np.testing.assert_allclose(contact_point(one, "foot", np.eye(3)), [0, 0, -0.02], atol=1e-15)
    np.testing.assert_allclose(contact_point(one, "foot", TURNED), [0.03, 0, 0.01], atol=1e-15)
    box = '<geometry><box size="1 1 1"/></geometry>'
    two = described(write, box, sphere("0.02"), sphere("0.01", "0 0 -0.02"))
    np.testing.assert_allclose(contact_point(two, "foot", np.eye(3)), [0, 0, -0.03], atol=1e-15)


def test_a_foot_without_a_sphere_has_none(write: Write) -> None:
    assert contact_point(described(write), "foot", np.eye(3)) is None
    assert contact_point(described(write, sphere("0.1")), "hand", np.eye(3)) is None


@pytest.mark.parametrize(
    ("radius", "at"), [("big", "0 0 0"), ("-1", "0 0 0"), ("nan", None), ("1", "0 0"), ("1", "a b c")]
)
def test_a_sphere_of_no_numbers(write: Write, radius: str, at: str | None) -> None:
    with pytest.raises(ConfigError, match="link 'foot' has a collision sphere of radius"):
        contact_point(described(write, sphere(radius, at)), "foot", np.eye(3))


def test_an_imported_robot_knows_its_frames(write: Write, by_hand: Any) -> None:
    text = by_hand.text().replace(
        '<link name="LF_foot">', f'<link name="LF_foot"><collision>{sphere("0.02")}</collision>'
    )
    request = Request(
        write(text), "walker", by_hand.feet, pose=by_hand.standing, max_force=200.0, box=(0.05, 0.05, 0.02)
    )
    robot = import_robot(request).robot
    assert robot.frames is not None and robot.frames.base_link == "base"
    height = (by_hand.thigh + by_hand.shank) * np.cos(0.5) * 2 / 22  # four feet of 0.5 kg pull it down
    np.testing.assert_allclose(robot.frames.com_in_base, [0.0, 0.0, -height], atol=1e-6)
    assert [foot.link for foot in robot.frames.feet] == list(by_hand.feet)
    assert [foot.leg for foot in robot.frames.feet] == list(robot.leg_names)
    # The shank leans half of the knee's angle: the lowest point of the sphere is off its pole by as much.
    lean = 0.02 * np.array([np.sin(0.5), 0.0, -np.cos(0.5)])
    found = np.array(robot.frames.feet[0].contact_point)
    np.testing.assert_allclose(np.abs(found), np.abs(lean), atol=1e-6)
    assert robot.frames.feet[1].contact_point == (0.0, 0.0, 0.0)
    assert "a foot has no collision sphere" in robot.source
