"""The functions that a family of friction or hysteresis is weighted by, under names that an engineer reads.

A model file keeps the short ones: by them its weights are found again.
"""

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from labrig.effects import Fitted

_WEIGHTS, _OF = "weights", " of "
_EFFECTS = ("friction", "hysteresis")
_GROWING = ("", " growing with the pressure", " growing with the pressure squared")
_HAT = 25
"""The hats by which a turn is placed are a quarter of the range apart, %."""
_PLAIN = {
    "direction": "Coulomb friction",
    "direction load": f"Coulomb friction{_GROWING[1]}",
    "direction load2": f"Coulomb friction{_GROWING[2]}",
    "more one way": "more friction while filling than while venting",
    "settled": "share of the pressure whichever way it came",
    "settled2": "share of the pressure squared whichever way it came",
    "settled3": "share of the pressure cubed whichever way it came",
    "settled wall": "share of the wall's deflection whichever way it came",
    "settled wall2": "share of the wall's deflection squared whichever way it came",
}
_SIZED = (
    (r"presliding ([\d.]+ %)", "presliding friction within {0} of the range after a turn"),
    (
        r"presliding ([\d.]+ %) load",
        f"presliding friction within {{0}} of the range after a turn{_GROWING[1]}",
    ),
    (r"skin ([\d.]+ %)", "each place staying behind by {0} of the motion"),
    (
        r"skin ([\d.]+ %) by place (\d+)",
        "each place staying behind by {0} of the motion, more to one end ({1})",
    ),
    (r"body ([\d.]+ %)", "the whole body staying behind by {0} of the motion"),
    (r"path ([\d.]+ %)", "all pressures staying behind together by {0} of the range"),
    (r"path ([\d.]+ %) load", f"all pressures staying behind together by {{0}} of the range{_GROWING[1]}"),
    (r"marker ([\d.]+ %)", "each marker staying behind by {0} of the motion"),
    (r"play ([\d.]+ %)", "play of {0} of the range"),
    (r"play ([\d.]+ %) tilted", "play of {0} of the range stronger at high pressure"),
    (
        r"play ([\d.]+ %) of (-?[\d.]+ %) to (-?[\d.]+ %)",
        "play of {0} of the range between {1} and {2} of it",
    ),
    (r"play ([\d.]+ %) of all", "play of {0} of the range in all chambers together"),
    (r"wall play ([\d.]+ %)", "play of {0} of the wall's deflection"),
    (r"trail ([\d.]+ %)", "the pressure left behind and caught up over {0} of the range"),
    (r"trail ([\d.]+ %) up", "the pressure left behind and caught up over {0} of the range while filling"),
    (r"trail ([\d.]+ %) square", "the pressure squared left behind and caught up over {0} of the range"),
)
_TURNED = {"last": "after the last turn at", "before": "when the turn before the last was at"}


def shown_of(one: "Fitted") -> dict[str, Any]:
    """The parameters of an effect as a person reads them, the functions of these two families under their names."""
    shown = one.shown
    weights = shown.get(_WEIGHTS)
    if weights and one.effect in _EFFECTS:
        names = [_read_name(str(name)) for name in weights.get("per") or []]
        shown[_WEIGHTS] = {**weights, "per": names}
    return shown


def _read_name(label: str) -> str:
    """One function; of a chamber it is what that one has beside what all have. As it is where it has no other name."""
    if (said := _read(label)) is not None:
        return said
    common, _, chamber = label.rpartition(_OF)
    said = _read(common)
    return label if said is None else f"{said} (more in {chamber})"


def _read(label: str) -> str | None:
    if label in _PLAIN:
        return _PLAIN[label]
    if found := re.fullmatch(r"(last|before) turn (\d) at (\d)", label):
        turn, then, now = found.groups()
        return f"at {_HAT * int(now)} % {_TURNED[turn]} {_HAT * int(then)} % of the range"
    if found := re.fullmatch(r"way ([\d.]+ %) load(\d)", label):
        return f"what builds up over {found[1]} of the range after a turn{_GROWING[int(found[2])]}"
    if found := re.fullmatch(r"body settled ([\d.]+) %", label):
        return f"how far the whole body went to the power of {float(found[1]) / 100:g}"
    if found := re.fullmatch(r"(turn|play .+ %) (\d+) (\d+)", label):
        what, sensor, chamber = found.groups()
        law = _PLAIN["direction"] if what == "turn" else _read(what)
        return f"{law} from chamber {int(chamber) + 1} at sensor {int(sensor) + 1}"
    for pattern, words in _SIZED:
        if found := re.fullmatch(pattern, label):
            return words.format(*found.groups())
    return None
