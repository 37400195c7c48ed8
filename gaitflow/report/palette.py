"""Colours of gaits: fixed for the named gaits, so that one gait looks the same in every figure of every scenario."""

from __future__ import annotations

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
# Tol's "muted" scheme for gaits without a name; a second round of it is lighter.
OTHER_COLOURS = ("#332288", "#882255", "#999933", "#44AA99", "#661100", "#AA4499", "#117733", "#88CCEE", "#CC6677")


def ordered_gaits(gaits: Iterable[str]) -> tuple[str, ...]:
    """Distinct gait names in the order of every legend: named gaits first, then the others alphabetically."""
    found = set(gaits)
    return tuple(name for name in NAMED_COLOURS if name in found) + tuple(sorted(found - NAMED_COLOURS.keys()))


def gait_colours(gaits: Iterable[str]) -> dict[str, str]:
    """Hex colour of each gait name, in legend order. A named gait's colour does not depend on the other gaits."""
    colours: dict[str, str] = {}
    others = 0
    for name in ordered_gaits(gaits):
        if name in NAMED_COLOURS:
            colours[name] = NAMED_COLOURS[name]
            continue
        rounds, index = divmod(others, len(OTHER_COLOURS))
        colours[name] = lighter(OTHER_COLOURS[index], 1 - 0.6**rounds)
        others += 1
    return colours


def lighter(colour: str, share: float) -> str:
    """`colour` mixed with the given share (0 to 1) of white, as hex."""
    red, green, blue = (channel + (1 - channel) * share for channel in to_rgb(colour))
    return to_hex((red, green, blue))
