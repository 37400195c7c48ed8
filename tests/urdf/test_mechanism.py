"""Mass, inertia and Jacobians of a URDF against sums and differences made by hand."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.description import read_description
from gaitflow.urdf.mechanism import Mechanism, load_mechanism

Write = Callable[..., Path]


def load(path: Path) -> Mechanism:
    return load_mechanism(read_description(path))


def test_mass_and_centre(mechanism: Mechanism, walker: list[LegChain], by_hand: Any) -> None:
    height = (by_hand.thigh + by_hand.shank) * np.cos(0.5)
    assert mechanism.mass == pytest.approx(22.0)
    np.testing.assert_allclose(
        walker[0].foot_at(walker[0].stance)[0], by_hand.hip + np.array([0, by_hand.offset, -height]), atol=1e-12
    )
    np.testing.assert_allclose(mechanism.composite(walker[0].pose)[0], [0, 0, -height * 2 / 22], atol=1e-12)


def test_composite_inertia_is_the_sum_over_links(mechanism: Mechanism, walker: list[LegChain]) -> None:
    """Steiner: body and four point-like feet, each about the common centre of mass."""
    centre, inertia = mechanism.composite(walker[0].pose)
    parts = [(20.0, np.zeros(3), np.diag([0.3, 0.8, 0.9]))]
    parts += [(0.5, leg.foot_at(leg.stance)[0], 1e-4 * np.eye(3)) for leg in walker]
    total = np.zeros((3, 3))
    for mass, at, own in parts:
        arm = at - centre
        total += own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(inertia, total, atol=1e-9)
    np.testing.assert_allclose(mechanism.base_inertia(), np.diag([0.3, 0.8, 0.9]), atol=1e-12)


def test_jacobian_is_the_derivative(anymal: list[LegChain]) -> None:
    leg, rng = anymal[2], np.random.default_rng(0)
    for _ in range(5):
        own, step = rng.uniform(-1, 1, 3), 1e-6
        _, jacobian = leg.foot_at(own)
        for joint in range(3):
            move = step * np.eye(3)[joint]
            slope = (leg.foot_at(own + move)[0] - leg.foot_at(own - move)[0]) / (2 * step)
            np.testing.assert_allclose(jacobian[:, joint], slope, atol=1e-8)


def test_each_leg_has_its_joints(mechanism: Mechanism, by_hand: Any) -> None:
    own = mechanism.joints_of(by_hand.feet)
    assert [mechanism.joint_names[joint] for joint in own[1]] == ["RF_HAA", "RF_HFE", "RF_KFE"]
    assert sorted(joint for joints in own for joint in joints) == list(range(12))


def test_a_shared_joint_belongs_to_no_leg(mechanism: Mechanism) -> None:
    shank, foot = mechanism.joints_of(["LF_thigh", "RF_foot"])
    assert len(shank) == 2 and len(foot) == 3
    with pytest.raises(ConfigError, match="no joint of its own"):
        mechanism.joints_of(["LF_thigh", "LF_foot"])


def test_an_unknown_link_names_near_ones(mechanism: Mechanism) -> None:
    with pytest.raises(ConfigError, match=r"no link 'LF_feet'; it has LF_foot"):
        mechanism.link("LF_feet")
    with pytest.raises(ConfigError, match="no link 'LF_HAA'"):
        mechanism.link("LF_HAA")  # a joint


def test_joints_that_turn_without_end(write: Write, walker: list[LegChain], by_hand: Any) -> None:
    endless = load(write(by_hand.text().replace('type="revolute"', 'type="continuous"'), "endless.urdf"))
    assert (endless.lower == -np.pi).all() and (endless.upper == np.pi).all()
    foot = endless.link("LF_foot")
    np.testing.assert_allclose(
        endless.point(foot, walker[0].pose)[0], walker[0].foot_at(walker[0].stance)[0], atol=1e-12
    )


def test_a_limit_that_is_zero_or_missing_is_none(write: Write, by_hand: Any) -> None:
    none = load(write(by_hand.text('lower="-1" upper="1" effort="0" velocity="0"')))
    assert np.isinf(none.effort).all() and np.isinf(none.velocity).all()


def test_meshes_are_not_opened(write: Write, by_hand: Any) -> None:
    mesh = '<visual><geometry><mesh filename="/dev/zero"/></geometry></visual>'
    text = by_hand.text().replace(
        "</inertial></link>", f"</inertial>{mesh}{mesh.replace('visual', 'collision')}</link>"
    )
    assert load(write(text)).mass == pytest.approx(22.0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("</robot>", '<link name="loose"/></robot>', "not a URDF that pinocchio reads"),
        ('"LF_HAA" type="revolute"', '"LF_HAA" type="floating"', "has 6 degrees of freedom"),
        ('<inertial><origin xyz="0 0 0"', '<inertial><origin xyz="0 0"', "weigh 22 kg, of which 2 kg could be used"),
    ],
)
def test_what_cannot_be_used(write: Write, by_hand: Any, old: str, new: str, said: str) -> None:
    with pytest.raises(ConfigError, match=r"walker\.urdf: ") as caught:
        load(write(by_hand.text().replace(old, new, 1)))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<robot name='a'/>", "not a URDF that pinocchio reads"),
        ("<robot name='a'><link name='b'/></robot>", "no joint moves"),
    ],
)
def test_nothing_that_moves(write: Write, text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        load(write(text))


def test_without_pinocchio_the_way_out_is_said(write: Write, monkeypatch: pytest.MonkeyPatch, by_hand: Any) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(ConfigError, match=r'pip install "gaitflow\[robots\]"'):
        load(write(by_hand.text()))


def test_reading_robots_loads_neither_pinocchio_nor_scipy() -> None:
    code = "import sys, gaitflow.config.robot; sys.exit(bool({'pinocchio', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_body_whose_mass_is_off_centre(write: Write) -> None:
    """What is far from the origin counts from the centre of mass: inertia does not change with where the base is."""
    inertial = (
        '<inertial><origin xyz="0.4 0 0"/><mass value="3"/>'
        '<inertia ixx="1" iyy="2" izz="3" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    mechanism = load(write(f'<robot name="a"><link name="b">{inertial}</link>'
                           '<joint name="j" type="continuous"><parent link="b"/><child link="c"/></joint>'
                           '<link name="c"/></robot>'))  # fmt: skip
    centre, inertia = mechanism.composite(np.zeros(1))
    np.testing.assert_allclose(centre, [0.4, 0, 0], atol=1e-12)
    np.testing.assert_allclose(inertia, np.diag([1, 2, 3]), atol=1e-12)
