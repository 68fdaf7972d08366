"""What a simulated rig hides: chosen, sealed in a file that says nothing at a glance, and revealed again.

    {"effects": [{"name": "creep", "amplitude": 1.0}], "unit": "mm", "seed": 7}

`amplitude` is the root mean square over rows, markers and axes of what the effect changes in a reference
campaign, in `unit`: mm, or floors (multiples of the capture-level noise floor). No effects: nothing is
hidden. The seal keeps an eye from reading by accident; it is not cryptography.
"""

import base64
import json
import zlib
from pathlib import Path
from typing import TypedDict

import numpy as np

from labrig_drivers._protocols import DeviceError
from labrig_drivers.simulated.hidden import EFFECTS, LISTED

SEALED_NAME = "sealed.json"
_MASK = b"labrig keeps this for later"


class HiddenEffect(TypedDict, total=False):
    """An effect that is hidden, and how large it is."""

    name: str
    amplitude: float


class HiddenSetting(TypedDict, total=False):
    """What a simulated rig hides; all of it is there once it is `checked`."""

    effects: list[HiddenEffect]
    unit: str
    seed: int
    duration_s: float


def hide(name: str, seed: int = 0, amplitude: float | None = None, unit: str = "mm") -> HiddenSetting:
    """The setting that hides one effect, or `nothing`; raises `DeviceError` for a name that does not exist.

    Without an amplitude the effect has 1 mm (or one floor) rms; a slipped marker, which is one of many, 0.4.
    """
    size = amplitude if amplitude is not None else (0.4 if name == "marker_slip" else 1.0)
    effects: list[HiddenEffect] = [] if name == "nothing" else [{"name": name, "amplitude": size}]
    return checked({"effects": effects, "unit": unit, "seed": seed})


def choose(seed: int, among: tuple[str, ...] = tuple(LISTED)) -> HiddenSetting:
    """One of `among`, or (one time in eight) nothing, as the seed has it."""
    random = np.random.default_rng([seed, 77])
    name = "nothing" if random.random() < 0.125 else among[int(random.integers(len(among)))]
    return hide(name, seed=seed)


def checked(hidden: HiddenSetting) -> HiddenSetting:
    """The same setting with its defaults filled in; raises `DeviceError` when it cannot be simulated."""
    unit = hidden.get("unit", "mm")
    if unit not in ("mm", "floors"):
        raise DeviceError(f"simulated: hidden: unit '{unit}' is not known (mm or floors)")
    effects: list[HiddenEffect] = []
    for entry in hidden.get("effects", []):
        name = entry.get("name")
        if name not in EFFECTS:
            raise DeviceError(
                f"simulated: hidden: there is no effect '{name}' (known: nothing, {', '.join(EFFECTS)})"
            )
        amplitude = float(entry.get("amplitude", 1.0))
        if not (np.isfinite(amplitude) and amplitude > 0):
            raise DeviceError(f"simulated: hidden: {name}: amplitude {amplitude:g} is not a positive number")
        effects.append({"name": name, "amplitude": amplitude})
    return {
        "effects": effects,
        "unit": unit,
        "seed": int(hidden.get("seed", 0)),
        "duration_s": float(hidden.get("duration_s", 240.0)),
    }


def _masked(data: bytes) -> bytes:
    return bytes(b ^ _MASK[i % len(_MASK)] for i, b in enumerate(data))


def seal(folder: Path, hidden: HiddenSetting) -> Path:
    """Write `sealed.json` into `folder` and return its path."""
    content = zlib.compress(json.dumps(checked(hidden)).encode(), 9)
    path = Path(folder) / SEALED_NAME
    temporary = path.with_suffix(".tmp")
    text = {
        "note": "what this simulated rig hides; `labrig reveal` opens it",
        "sealed": base64.b85encode(_masked(content)).decode(),
    }
    temporary.write_text(json.dumps(text, indent=1) + "\n", encoding="utf-8")
    temporary.replace(path)
    return path


def reveal(folder: Path) -> HiddenSetting:
    """What the sealed file in `folder` (or the file itself) hides; raises `DeviceError` if there is none or
    it is damaged.
    """
    path = Path(folder)
    path = path / SEALED_NAME if path.is_dir() else path
    try:
        text = json.loads(path.read_text(encoding="utf-8"))
        return checked(json.loads(zlib.decompress(_masked(base64.b85decode(text["sealed"])))))
    except FileNotFoundError:
        raise DeviceError(
            f"simulated: {path} does not exist: copy it from where rig.yaml was made, or take `hidden:` out of rig.yaml"
        ) from None
    except (KeyError, TypeError, ValueError, zlib.error):
        raise DeviceError(f"simulated: {path} is no sealed file, or damaged") from None
