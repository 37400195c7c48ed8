"""What gaits are called: Fig. 5's names for a front and a hind leg, Fig. 8's kinds for four legs.

A quadruped has far more gaits than there are words: its gaits have a kind, and one gait of a kind, the archetype, goes
by the kind alone. Any other gait's name ends with its contacts, so that a name always means one gait.
"""

from __future__ import annotations

from collections.abc import Sequence

from gaitflow.core.gaits import Pattern, Symmetry, diagram, gait_of

# Fig. 5, as printed.
_FIGURE_5 = {
    "walking": "0111/1101",
    "gallop": "0110/1100",
    "bounding": "0001/0100",
    "pronking": "0110/0100",
    "gallop-walk": "011/110",
    "gallop-pronk": "010/110",
    "gallop-bound": "010/100",
}
_FIGURE_5_LEGS = ("F", "H")
_FIGURE_5_NAMES = {gait_of(Pattern.from_text(text)): name for name, text in _FIGURE_5.items()}

# Legs left front, right front, left hind, right hind.
_ARCHETYPES = {
    "pronk": "10/10/10/10",
    "trot": "10/01/01/10",
    "walking trot": "1101/0111/0111/1101",
    "running trot": "1000/0010/0010/1000",
    "pace": "10/01/10/01",
    "walking pace": "1101/0111/1101/0111",
    "running pace": "1000/0010/1000/0010",
    "bound": "1000/1000/0010/0010",
    "walking bound": "1101/1101/0111/0111",
    "four-beat walk": "0111/1101/1110/1011",  # the crawl: one leg swings at a time, in lateral sequence
}
_PAIRS = {"trot": ((0, 3), (1, 2)), "pace": ((0, 2), (1, 3)), "bound": ((0, 1), (2, 3))}
_DIAGONALS = ({0, 3}, {1, 2})
_FRONT, _HIND = {0, 1}, {2, 3}
_MIRROR = (1, 0, 3, 2)
_CORNERS = tuple((end, side) for end in (1, -1) for side in (1, -1))
_PLACES = {
    name: ((1 if end == "F" else -1), (1 if side == "L" else -1))
    for end in "FHR"
    for side in "LR"
    for name in (end + side, side + end)
}
_COUNT = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def leg_place(name: str) -> tuple[int, int] | None:
    """Where the leg is by its name: (1 front or -1 hind, 1 left or -1 right), the signs of its foot's x and y.

    F is front, H (hind) or R (rear) the other end, L left, R right, in either order: LF, FL, RH, RR. None for others.
    """
    return _PLACES.get(name)


def quadruped_places(leg_names: Sequence[str]) -> tuple[int, ...] | None:
    """Where left front, right front, left hind and right hind are among the names; None for any other robot."""
    places = [leg_place(name) for name in leg_names]
    if len(places) != len(_CORNERS) or set(places) != set(_CORNERS):
        return None
    return tuple(places.index(corner) for corner in _CORNERS)


def gait_name(gait: Pattern, leg_names: Sequence[str]) -> str:
    """What a gait is called; one name to one gait, and for a quadruped the same for both mirror images.

    Legs F and H: by Fig. 5. A quadruped: its kind (see `gait_kind`) where it is the kind's archetype, otherwise the
    kind and the canonical contacts, legs in the robot's order: "three-beat walk 0011/1101/1110/1101". Gaits without
    such a name are called by their diagram. A pattern that is not canonical is called what its gait is called.
    Raises ValueError as `diagram` does.
    """
    drawn = diagram(gait_of(gait), leg_names)
    if sorted(leg_names) == sorted(_FIGURE_5_LEGS):
        front_first = gait.mirrored([list(leg_names).index(leg) for leg in _FIGURE_5_LEGS])
        return _FIGURE_5_NAMES.get(gait_of(front_first), drawn)
    places = quadruped_places(leg_names)
    if places is None:
        return drawn
    kind = _kind(_placed(gait, places))
    archetype = _ARCHETYPES.get(kind)
    images = Symmetry(mirror=_MIRROR)
    if archetype and gait_of(_placed(gait, places), images) == gait_of(Pattern.from_text(archetype), images):
        return kind
    mirror = tuple(places[_MIRROR[places.index(leg)]] for leg in range(4))
    return f"{kind} {gait_of(gait, Symmetry(mirror)).text}"


def gait_kind(gait: Pattern, leg_names: Sequence[str]) -> str:
    """The kind of gait, in the words of Fig. 8, of a robot with front and hind legs on the left and on the right.

    A beat is a moment at which one or more legs touch down; a flight is a phase without any stance.

    - All legs alike: pronk. Legs alike in diagonal pairs: trot; in left and right pairs: pace; in a front and a hind
      pair: bound. Alike means in every phase, so a pair that lands together and lifts apart is none; and every leg
      lands, so a pair that never stands is none either.
    - A trot or pace with flight is running, one with all legs down in some phase and no flight is walking; with
      neither it is plain. A bound flies; without flight it is walking.
    - Otherwise without flight, by its beats and duty factor: a walk ("four-beat walk") where legs stand for half of the
      cycle or more in the mean, a grounded run ("four-beat grounded run") where they stand for less, as Hildebrand
      tells walks from runs. Durations are no part of a gait, so all phases count as equally long; with two feet or
      more down throughout it is a walk however long they are, with two or fewer a grounded run. The paper's Fig. 8
      calls both walks.
    - Otherwise with flight: a gallop when both hind legs land and then both front legs, in three or four beats;
      a canter when a hind leg, a diagonal pair and a front leg land in this order; any other is a run by its beats
      ("three-beat run"). Gallop and canter land each leg once a cycle.

    Legs count as a quadruped's by their names: one in each corner by `leg_place`. The kind of any other robot's gait is
    its name. Raises ValueError as `diagram` does.
    """
    name = gait_name(gait, leg_names)
    places = quadruped_places(leg_names)
    return name if places is None else _kind(_placed(gait, places))


def is_grounded_run(gait: Pattern) -> bool:
    """Whether some leg always stands, and legs stand for less than half of the cycle in the mean over equal phases."""
    down = [sum(gait.column(phase)) for phase in range(gait.phases)]
    return min(down) > 0 and 2 * sum(down) < gait.phases * gait.legs


def _placed(gait: Pattern, places: Sequence[int]) -> Pattern:
    """The merged gait with its legs in the order left front, right front, left hind, right hind."""
    return Pattern(tuple(gait.rows[place] for place in places)).merged()


def _kind(gait: Pattern) -> str:
    """The kind of a merged gait, its legs in the order of `_placed`."""
    rows = gait.rows
    columns = [gait.column(phase) for phase in range(gait.phases)]
    flies, all_down = (0, 0, 0, 0) in columns, (1, 1, 1, 1) in columns
    if len(set(rows)) == 1 and flies and all_down:
        return "pronk"
    all_land = all(gait.touchdowns(leg) for leg in range(4))
    for name, pairs in _PAIRS.items():
        if all_land and len(set(rows)) == 2 and all(rows[a] == rows[b] for a, b in pairs):
            if name == "bound":
                return name if flies else f"walking {name}"
            return f"running {name}" if flies else f"walking {name}" if all_down else name
    beats = _beats(columns)
    if not flies:
        return f"{_COUNT[len(beats)]}-beat {'grounded run' if is_grounded_run(gait) else 'walk'}"
    if all(gait.touchdowns(leg) == 1 for leg in range(4)):
        if len(beats) >= 3 and _couplets(beats):
            return "gallop"
        if len(beats) == 3 and _canters(beats):
            return "canter"
    return f"{_COUNT[len(beats)]}-beat run"


def _beats(columns: Sequence[tuple[int, ...]]) -> list[set[int]]:
    """The legs that land at each moment of touch-down, round the cycle."""
    landings = [
        {leg for leg, (before, now) in enumerate(zip(columns[phase - 1], columns[phase], strict=True)) if now > before}
        for phase in range(len(columns))
    ]
    return [landing for landing in landings if landing]


def _couplets(beats: Sequence[set[int]]) -> bool:
    """Whether the hind legs land one after the other or together, and so do the front legs."""
    ends = ["F" if beat <= _FRONT else "H" if beat <= _HIND else "mixed" for beat in beats]
    return "mixed" not in ends and sum(end != ends[i - 1] for i, end in enumerate(ends)) == 2


def _canters(beats: Sequence[set[int]]) -> bool:
    return any(
        beats[i] in _DIAGONALS and beats[i - 1] <= _HIND and beats[(i + 1) % 3] <= _FRONT for i in range(len(beats))
    )
