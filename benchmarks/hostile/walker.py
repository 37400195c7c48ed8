"""A small quadruped as a URDF and an SRDF, on which damage is tried: 20 kg, legs of 0.25 and 0.25 m."""

from __future__ import annotations

SIDES = {"LF": (1, 1), "RF": (1, -1), "LH": (-1, 1), "RH": (-1, -1)}
FEET = tuple(f"{leg}_foot" for leg in SIDES)
LENGTH = 0.25  # m, of thigh and of shank
BENT = 1.0  # rad, of a knee
LIMIT = '<limit lower="-3.2" upper="3.2" effort="50" velocity="10"/>'


def urdf() -> str:
    """Its URDF: hip abduction, hip flexion and knee a leg, a sphere for a foot."""
    parts = [f'<robot name="walker"><link name="base">{_body(20, 0.3, 0.8, 0.9)}</link>']
    for leg, (front, left) in SIDES.items():
        parts += [
            f'<link name="{leg}_{part}">{_body(0.1, 1e-4, 1e-4, 1e-4)}</link>' for part in ("hip", "thigh", "shank")
        ]
        parts += [
            f'<link name="{leg}_foot">{_body(0.5, 1e-4, 1e-4, 1e-4)}<collision><origin xyz="0 0 0" rpy="0 0 0"/>'
            '<geometry><sphere radius="0.02"/></geometry></collision></link>',
            _joint(f"{leg}_HAA", "base", f"{leg}_hip", "1 0 0", f"{0.3 * front} {0.1 * left} 0"),
            _joint(f"{leg}_HFE", f"{leg}_hip", f"{leg}_thigh", "0 1 0", f"0 {0.08 * left} 0"),
            _joint(f"{leg}_KFE", f"{leg}_thigh", f"{leg}_shank", "0 1 0", f"0 0 {-LENGTH}"),
            f'<joint name="{leg}_ankle" type="fixed"><parent link="{leg}_shank"/><child link="{leg}_foot"/>'
            f'<origin xyz="0 0 {-LENGTH}" rpy="0 0 0"/></joint>',
        ]
    return "\n".join([*parts, "</robot>"])


def srdf() -> str:
    """Its standing pose."""
    joints = [
        f'<joint name="{leg}_{joint}" value="{value}"/>'
        for leg, (front, _) in SIDES.items()
        for joint, value in (("HAA", 0), ("HFE", front * BENT / 2), ("KFE", -front * BENT))
    ]
    return f'<robot name="walker"><group_state name="standing" group="all">{"".join(joints)}</group_state></robot>'


def _body(mass: float, xx: float, yy: float, zz: float) -> str:
    return (
        f'<inertial><origin xyz="0 0 0" rpy="0 0 0"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def _joint(name: str, parent: str, child: str, axis: str, at: str) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}" rpy="0 0 0"/><axis xyz="{axis}"/>{LIMIT}</joint>'
    )
