"""Colours of gaits: fixed for the named gaits, so that one gait looks the same in every figure of every scenario.

A quadruped's gaits have the hue of their kind: the gait that goes by the kind alone has the colour itself, the others
of the kind have shades of it.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable

from matplotlib.colors import to_hex, to_rgb

# Okabe & Ito (2008), told apart by people of every common colour vision; ordered as speed rises in Fig. 4a.
NAMED_COLOURS = {
    "walking": "#0072B2",
    "gallop-walk": "#56B4E9",
    "pronking": "#F0E442",
    "gallop-pronk": "#E69F00",
    "gallop": "#D55E00",
    "gallop-bound": "#CC79A7",
    "bounding": "#009E73",
}
# Kinds of a quadruped's gaits, walks first; walks are blue, grounded runs greyer, trots green and orange, paces purple.
KIND_COLOURS = {
    "four-beat walk": "#0072B2",
    "three-beat walk": "#56B4E9",
    "two-beat walk": "#6A5ACD",
    "four-beat grounded run": "#0E7490",
    "three-beat grounded run": "#7FB7BE",
    "two-beat grounded run": "#94A3C4",
    "walking trot": "#117733",
    "trot": "#8DB600",
    "running trot": "#E69F00",
    "walking pace": "#882255",
    "pace": "#AA4499",
    "running pace": "#CC79A7",
    "walking bound": "#44AA99",
    "bound": "#009E73",
    "pronk": "#F0E442",
    "one-beat run": "#DDCC77",
    "two-beat run": "#CC6677",
    "three-beat run": "#661100",
    "four-beat run": "#8B5A2B",
    "canter": "#B22222",
}
# Tol's "muted" scheme for gaits without a name; a second round of it is lighter.
OTHER_COLOURS = ("#332288", "#882255", "#999933", "#44AA99", "#661100", "#AA4499", "#117733", "#88CCEE", "#CC6677")
SHADES = (0.35, -0.35, 0.6, -0.55, 0.18, -0.18)  # of a kind's colour: share of white, or of black when negative


def kind_and_contacts(name: str) -> tuple[str, str]:
    """A quadruped's gait name in its two parts, ("four-beat walk", "0111/1101/..."); another name and ""."""
    parts = re.fullmatch(r"([^/]+) ([01/]+)", name)
    return (parts[1], parts[2]) if parts else (name, "")


def ordered_gaits(gaits: Iterable[str]) -> tuple[str, ...]:
    """Distinct gait names in one fixed order: named gaits first, kinds together, then the others alphabetically."""
    order = {name: place for place, name in enumerate((*KIND_COLOURS, *NAMED_COLOURS))}

    def place(name: str) -> tuple[int, str, str]:
        kind, contacts = kind_and_contacts(name)
        return order.get(kind, len(order)), contacts, name

    return tuple(sorted(set(gaits), key=place))


def gait_colours(gaits: Iterable[str]) -> dict[str, str]:
    """Hex colour of each gait name, in `ordered_gaits`' order. A named gait's does not depend on the other gaits."""
    fixed = KIND_COLOURS | NAMED_COLOURS
    colours: dict[str, str] = {}
    members: dict[str, int] = defaultdict(int)
    others = 0
    for name in ordered_gaits(gaits):
        kind, contacts = kind_and_contacts(name)
        if kind not in fixed:
            rounds, index = divmod(others, len(OTHER_COLOURS))
            colours[name] = lighter(OTHER_COLOURS[index], 1 - 0.6**rounds)
            others += 1
        elif contacts:
            rounds, index = divmod(members[kind], len(SHADES))
            colours[name] = _shade(fixed[kind], SHADES[index] * 0.8**rounds)
            members[kind] += 1
        else:
            colours[name] = fixed[kind]
    return colours


def lighter(colour: str, share: float) -> str:
    """`colour` mixed with the given share (0 to 1) of white, as hex."""
    red, green, blue = (channel + (1 - channel) * share for channel in to_rgb(colour))
    return to_hex((red, green, blue))


def _shade(colour: str, share: float) -> str:
    if share >= 0:
        return lighter(colour, share)
    red, green, blue = (channel * (1 + share) for channel in to_rgb(colour))
    return to_hex((red, green, blue))
