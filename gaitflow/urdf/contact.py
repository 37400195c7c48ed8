"""Where a foot touches the ground: the lowest point of the spheres that a URDF gives it to collide with."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np

from gaitflow.config.file import ConfigError
from gaitflow.urdf.description import Description
from gaitflow.urdf.mechanism import Array


def contact_point(description: Description, link: str, rotation: Array) -> Array | None:
    """The lowest point [3] m of a link's collision spheres, in its frame; None of a link that has none.

    `rotation` [3, 3] turns its vectors to the base frame's directions. Raises ConfigError for a sphere whose radius or
    place is no number.
    """
    spheres = collision_spheres(description, link)
    down = rotation.T @ np.array([0.0, 0.0, -1.0])
    lowest: list[Array] = [centre + radius * down for centre, radius in spheres]
    return max(lowest, key=lambda point: float(point @ down), default=None)


def collision_spheres(description: Description, link: str) -> list[tuple[Array, float]]:
    """Centres [3] m, in a link's frame, and radii [m] of its collision spheres. Raises ConfigError as above."""
    root = ElementTree.fromstring(description.text)
    return [
        _sphere(description, link, collision)
        for element in root.findall("link")
        if element.get("name") == link
        for collision in element.findall("collision")
        if collision.find("geometry/sphere") is not None
    ]


def _sphere(description: Description, link: str, collision: ElementTree.Element) -> tuple[Array, float]:
    sphere, origin = collision.find("geometry/sphere"), collision.find("origin")
    texts = (
        "" if sphere is None else sphere.get("radius", ""),
        "0 0 0" if origin is None else origin.get("xyz", "0 0 0"),
    )
    try:
        radius, place = float(texts[0]), [float(word) for word in texts[1].split()]
    except ValueError:
        radius, place = math.nan, []
    if not (radius >= 0 and len(place) == 3 and np.isfinite([radius, *place]).all()):
        raise ConfigError(
            f"{description.path}: link {link!r} has a collision sphere of radius {texts[0][:40]!r} at "
            f"{texts[1][:40]!r}: must be numbers, a radius >= 0 and three coordinates"
        )
    return np.array(place), radius
