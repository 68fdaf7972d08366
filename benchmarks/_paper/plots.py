"""Plots of the experiments, in one style."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.view._learning import (
    _figure,
    draw_lines,
    plain_axis,
    save_figure,
)
from labrig.view._style import AFTER, BEFORE, GROUPS, INK, MUTED

__all__ = ["bars", "curves", "histogram", "structure"]

COLOURS = (BEFORE, AFTER, *GROUPS[2:])


def curves(
    series: dict[str, Any], x: Sequence[float], labels: tuple[str, str], path: Path, log: bool = False
) -> Path:
    """Lines of means over seeds (S, n) with bands from the best seed to the worst."""
    values = {name: np.asarray(v, float) for name, v in series.items()}
    lines = {name: (np.asarray(x, float), v.mean(axis=0)) for name, v in values.items()}
    spread = {name: (v.min(axis=0), v.max(axis=0)) for name, v in values.items() if len(v) > 1}
    return draw_lines(lines, labels, path, spread, log)


def structure(error: Floats, layers: Sequence[int], neurons: Sequence[int], path: Path) -> Path:
    """Maximal error (seeds, layers, neurons) against neurons, a line for each number of layers."""
    series = {f"{n} hidden layer{'s' if n > 1 else ''}": error[:, i] for i, n in enumerate(layers)}
    return curves(series, neurons, ("neurons in each layer", "maximal error, mm"), path)


def bars(groups: Sequence[str], series: dict[str, Floats], label: str, path: Path) -> Path:
    """Bars side by side: one group each set-point, one colour each model, (S, n) with lines over seeds."""
    figure, axes = _figure(1, 1, (1.3 * len(groups) + 2.4, 3.6))
    axis = axes.ravel()[0]
    width = 0.8 / len(series)
    for k, (name, values) in enumerate(series.items()):
        mean = values.mean(axis=0)
        low, high = mean - values.min(axis=0), values.max(axis=0) - mean
        place = np.arange(len(groups)) + (k - 0.5 * (len(series) - 1)) * width
        axis.bar(place, mean, 0.92 * width, color=COLOURS[k], label=name)
        axis.errorbar(place, mean, (low, high), fmt="none", ecolor=INK, linewidth=0.9, capsize=2)
    axis.set_xticks(range(len(groups)), groups)
    axis.set_ylabel(label, color=MUTED)
    axis.legend(frameon=False, fontsize=9)
    plain_axis(axis)
    return save_figure(figure, path)


def histogram(series: dict[str, Floats], label: str, path: Path) -> Path:
    """How many shapes have which error, one colour each model."""
    figure, axes = _figure(1, 1, (6.4, 3.6))
    axis = axes.ravel()[0]
    top = max(float(v.max()) for v in series.values())
    bins = np.linspace(0.0, top, 46)
    for (name, values), colour in zip(series.items(), COLOURS, strict=False):
        axis.hist(
            values, bins=list(bins), color=colour, alpha=0.65, label=f"{name} (mean {values.mean():.3f})"
        )
    axis.set_xlabel(label, color=MUTED)
    axis.set_ylabel("test shapes", color=MUTED)
    axis.legend(frameon=False, fontsize=9)
    plain_axis(axis)
    return save_figure(figure, path)
