"""The classes of blind campaigns: what may be hidden in each, how large, and under which circumstances."""

from dataclasses import dataclass

FAMILIES: dict[str, tuple[str, ...]] = {
    "history": ("hysteresis", "friction"),
    "hold": ("creep", "leak", "delay"),
    "pressure": ("regulator", "tension", "stiffening"),
    "limit": ("contact",),
    "pair": ("coupling",),
    "shape": ("frame", "rest_shape", "gravity"),
    "session": ("drift", "marker_slip"),
}
"""Effects that can stand in for each other, to a degree."""

STATIC_SAFE = ("hysteresis", "creep", "leak", "stiffening", "contact", "friction", "drift", "coupling")
"""Effects that a static map of degree 1, fitted to the campaign, cannot swallow."""

DELETED = ("hysteresis", "friction", "creep", "leak", "coupling", "frame", "rest_shape", "gravity")
"""Effects for which nothing else can stand in once their family is taken out of the library."""

CONFOUNDED = {
    "one_hold": ("creep", "drift", "leak"),  # nothing but the curve's form in time tells them apart
    "one_level": ("regulator", "stiffening", "tension", "hysteresis", "friction"),  # two states in all
}
"""Programmes that cannot tell some effects apart, and which."""


@dataclass(frozen=True)
class Kind:
    """One class: how many effects of how many floors, and what else is particular to it."""

    effects: int
    floors: tuple[float, float] = (1.0, 1.0)
    slow: float = 0.0  # common-mode AR(0.9) noise, in floors
    structural: tuple[float, float] = (0.0, 0.0)  # how wrong in form the base is, in floors
    static: bool = False
    confounded: bool = False
    outside: bool = False
    deleted: bool = False
    in_one: bool = False  # of several chambers
    usual: int = 100  # campaigns of a full benchmark


CLASSES: dict[str, Kind] = {
    "null": Kind(0, usual=200),
    "null-slow": Kind(0, slow=0.5),
    "null-static": Kind(0, static=True, usual=50),
    "single-1": Kind(1, (1.0, 1.0)),
    "single": Kind(1, (2.0, 4.0), usual=200),
    "one-chamber": Kind(1, (2.0, 4.0), in_one=True),
    "static": Kind(1, (2.0, 4.0), static=True),
    "pair": Kind(2, (1.0, 2.0)),
    "structural": Kind(1, (2.0, 4.0), structural=(1.0, 2.0)),
    "confounded": Kind(1, (2.0, 4.0), confounded=True, usual=50),
    "outside": Kind(1, (2.0, 4.0), outside=True),
    "deleted": Kind(1, (2.0, 4.0), deleted=True),
}


def family_of(effect: str) -> tuple[str, ...]:
    """The effects that can stand in for one, itself among them."""
    return next((family for family in FAMILIES.values() if effect in family), (effect,))
