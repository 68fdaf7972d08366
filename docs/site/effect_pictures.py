"""Draws what gives each effect away, from a run of a simulated rig that hides it.

    python docs/site/effect_pictures.py [EFFECT...]

For each effect: a rig with four chambers under a membrane hides it, a campaign is measured, the effect is fitted to it.
Writes docs/pictures/effects/NAME.png, and beside it NAME.json with the figures that the effect's page quotes.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import labrig
from labrig.diagnosis import Signature
from labrig.effects._registry import shipped
from labrig.view._signature_figure import binned
from labrig.view._style import FLOOR, GROUPS, INK, LINE, MUTED
from labrig_drivers.simulated import hide, seal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FOLDER = Path(__file__).parents[1] / "pictures" / "effects"
RIG = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "membrane", "seed": 0, "hidden": "sealed.json"},
}
CAPTURES, SEED = 60, 1
MOST_POINTS = 1500
SIZES_MM = {"delay": 0.4}
"""Root mean squares other than the usual: a delay of 1 mm keeps the pressures so far off that the rig stops."""
LONG_HOLDS = ("creep", "leak")
"""Effects whose growth shows in long holds only: the picture is of a run of these."""


def measured(name: str, folder: Path) -> list[Path]:
    """The runs of a rig that hides an effect, under `folder`."""
    folder.mkdir()
    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (folder / "model.yaml").write_text(
        "base: {kind: simulator, rig: rig.yaml}\neffects: []\n", encoding="utf-8"
    )
    seal(folder, hide(name, seed=SEED, amplitude=SIZES_MM.get(name)))
    rig = folder / "rig.yaml"
    runs = [labrig.run("capture", rig, out=folder / "run", captures=CAPTURES, seed=SEED)]
    if name in LONG_HOLDS:
        runs.append(labrig.run("hold", rig, out=folder / "holds", seed=SEED))
    return runs


def draw(item: Signature, path: Path) -> None:
    """One picture: single points pale, means as dots, the fitted effect as a line; one colour for each group."""
    figure = Figure(figsize=(6.4, 3.6), dpi=110)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    known = np.isfinite(item.x) & np.isfinite(item.measured) & np.isfinite(item.fitted) & (item.weight > 0)
    names = sorted(dict.fromkeys(item.group[known].tolist()), key=lambda n: (n.startswith("the other"), n))
    ends = []
    for k, name in enumerate(names):
        colour = FLOOR if name.startswith("the other") else GROUPS[1:][k % (len(GROUPS) - 1)]
        inside = np.flatnonzero(known & (item.group == name))
        pale = inside[np.linspace(0, len(inside) - 1, min(len(inside), MOST_POINTS)).astype(int)]
        axes.plot(item.x[pale], item.measured[pale], ".", ms=3, color=colour, alpha=0.18, mew=0)
        x, dots, line = binned(item, inside)
        axes.plot(x, line, "-", lw=2.2, color=colour, label=name or "fitted")
        axes.plot(x, dots, "o", ms=5.5, color=colour, mec="white", mew=0.8)
        ends += [*np.quantile(item.measured[inside], [0.03, 0.97]), *dots, *line]
    room = 0.08 * (max(ends) - min(ends))
    x = item.x[known]
    if item.x_name == "time in hold" and x.min() > 0:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    axes.set_ylim(min(ends) - room, max(ends) + room)
    _dress(axes, item, len(names) > 1)
    figure.tight_layout()
    canvas.print_png(path)
    _lighter(path)


def _dress(axes: "Axes", item: Signature, several: bool) -> None:
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(LINE)
    axes.axhline(0, color=MUTED, lw=0.7)
    axes.grid(color=LINE, lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, labelsize=9, length=0)
    units = [u if u not in ("", "1") else "" for u in (item.x_unit, item.y_unit)]
    axes.set_xlabel(f"{item.x_name}, {units[0]}".rstrip(", "), color=INK, fontsize=9.5)
    axes.set_ylabel(f"{item.y_name}, {units[1]}".rstrip(", "), color=INK, fontsize=9.5)
    if several:
        axes.legend(frameon=False, fontsize=8.5, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))


def _lighter(path: Path) -> None:
    """The same picture in 64 colours: a third of the weight."""
    from PIL import Image

    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(64)
    small.save(path, optimize=True)


def make(name: str, folder: Path) -> dict[str, Any]:
    """Measure, fit and draw one effect; what its page quotes."""
    runs, model = measured(name, folder), folder / "model.yaml"
    found = labrig.diagnose(runs, model)
    better = labrig.improve(runs, model, name, force=True)
    shown = labrig.improve(runs[-1], model, name, force=True) if len(runs) > 1 else better
    item = next(s for s in shown._result.signatures if s.effect == name)
    draw(item, FOLDER / f"{name}.png")
    row = found.effects.set_index("effect").loc[name]
    content = {
        "verdict": found.verdict,
        "sure": found.sure,
        "probability": round(float(row["probability"]), 2),
        "size_mm": round(float(row["size"]), 2),
        "error_mm": {key: round(value, 3) for key, value in better.error.items()},
        "captures": sum(labrig.open_run(run).sizes["capture"] for run in runs),
        "seed": SEED,
    }
    (FOLDER / f"{name}.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return content


def main() -> None:
    """Draw the effects that are named, or all."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("effects", nargs="*", metavar="EFFECT")
    wanted = parser.parse_args().effects or sorted(shipped())
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in wanted:
            print(name, make(name, Path(folder) / name), flush=True)


if __name__ == "__main__":
    main()
