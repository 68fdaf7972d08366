"""A page for each effect, out of what its class says and of a run in which a simulated rig hides it."""

import inspect
import json
from pathlib import Path
from typing import Any

from labrig.effects._effect import Effect
from labrig.effects._registry import shipped

PICTURES = Path(__file__).parents[1] / "pictures" / "effects"
_ACTS = {
    "pressure": "the pressures: what a chamber gets is not what was commanded",
    "mechanics": "the mechanics: the surface answers otherwise than the model says",
    "observation": "what is seen: the surface is right, and the measurement of it is off",
}


def effect_names() -> list[str]:
    """The effects that come with labrig, in alphabetical order."""
    return sorted(shipped())


def effects_index() -> str:
    """What there is, and what gives each away."""
    rows = [
        f"| [{_title(name)}]({name}.md) | {effect.acts_on} | {effect.signature} |"
        for name, effect in sorted(shipped().items())
    ]
    return (
        "# The effects\n\nThe physical effects that labrig can identify in a model's error. Each page says what the "
        "effect is, which laws it covers, its signature in measurements, and the experiment that decides whether it is "
        "there. The pictures are examples; how often the names are right is measured by the "
        "[blind benchmark](../reference/blind_benchmark.md). How an effect is identified: "
        "[diagnosis](../reference/diagnosis.md); one of your own: [add an effect](../how-to/add-an-effect.md).\n\n"
        "| Effect | acts on | signature |\n|---|---|---|\n" + "\n".join(rows) + "\n"
    )


def effect_page(name: str) -> str:
    """The page of one effect."""
    effect = shipped()[name]
    meaning = " ".join(effect.meaning.split())
    laws = " ".join((inspect.getdoc(type(effect).family) or "").split())
    lines = [
        f"# {_title(name)}",
        meaning,
        f"It acts on {_ACTS[effect.acts_on]}.",
        "## Signature",
        f"{effect.signature[:1].upper()}{effect.signature[1:]}.",
        f"![{_title(name)}: measured and fitted](../pictures/effects/{name}.png)",
        _caption(json.loads((PICTURES / f"{name}.json").read_text(encoding="utf-8")), name),
        "## Experiment",
        f"{effect.experiment[:1].upper()}{effect.experiment[1:]}. `labrig next` plans it within the limits of your rig "
        "where a diagnosis leaves the effect open ([decide between rival effects](../how-to/settle-a-doubt.md)).",
        "## Laws",
        laws,
        f"Source: {effect.reference}.",
        "## Parameters",
        _parameters(effect),
        f'In the terminal: `labrig effects show {name}`. In Python: `labrig.improve(run, model, "{name}")` fits it '
        "and adds it to a model.",
    ]
    return "\n\n".join(lines) + "\n"


def _title(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _caption(figures: dict[str, Any], name: str) -> str:
    error, title = figures["error_mm"], _title(name).lower()
    return (
        f"*{figures['captures']} captures of a simulated rig that hides {title}: four chambers under a membrane, seed "
        f"{figures['seed']}. Pale: single points; dots: means; line: the fitted effect. With it the held-out error "
        f"falls from {error['base']:.2f} to {error['model']:.2f} mm; the noise floor is {error['floor']:.2f} mm. "
        f"{_verdict(figures, name)}*"
    )


def _verdict(figures: dict[str, Any], name: str) -> str:
    """What the diagnosis says of the run: the effect's name, or what it says instead."""
    title, share = _title(name).lower(), f"{100 * figures['probability']:.0f} %"
    if name in figures["sure"]:
        return f"`labrig diagnose` identifies {title} in these captures ({share})."
    others = " and ".join(other.replace("_", " ") for other in figures["sure"])
    instead = f"names {others}" if others else f"says `{figures['verdict']}`"
    return (
        f"`labrig diagnose` {instead} here, and gives {title} {share}: on this rig the name is not reliable."
    )


def _parameters(effect: Effect) -> str:
    rows = []
    for p in effect.parameters:
        bounds = f"{p.low:g} to {p.high:g}" if p.low > -1e300 and p.high < 1e300 else "any"
        if bounds == "any" and p.low > -1e300:
            bounds = f"from {p.low:g}"
        unit = "" if p.unit == "1" else p.unit
        rows.append(f"| `{p.name}` | {unit} | {bounds} | {p.per} | {p.meaning} |")
    return "| Name | unit | bounds | one for each | meaning |\n|---|---|---|---|---|\n" + "\n".join(rows)
