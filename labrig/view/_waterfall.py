"""The waterfall from the base model down to the noise floor, as an inline SVG."""

from collections.abc import Sequence
from html import escape

from labrig._text import number, word
from labrig.view._style import AFTER, BEFORE, CEILING, FLOOR, INK, LINE, MUTED

WIDTH, HEIGHT = 956.0, 320.0
TOP, BOTTOM = 34.0, 52.0
SLOT = 240.0
ROOM = 48.0  # that a drop needs for a label of its own


def waterfall_svg(steps: Sequence[tuple[str, float]], units: str) -> str:
    """Draw (label, rms error) steps: base, one per effect that is added, ceiling, floor."""
    steps = [(label, float(value)) for label, value in steps if value == value]
    if not steps:
        return ""
    top = max(value for _, value in steps) or 1.0
    plot = HEIGHT - TOP - BOTTOM
    slot = min(SLOT, WIDTH / len(steps))
    bar = slot * 0.5

    def y(value: float) -> float:
        return TOP + plot * (1.0 - value / top)

    parts = [_line(0.0, y(0.0), slot * len(steps), y(0.0), INK)]
    floor = next((value for label, value in steps if label == "floor"), None)
    if floor is not None:
        parts.append(_line(0.0, y(floor), slot * len(steps), y(floor), FLOOR, dashes="4 4"))
    previous: float | None = None
    for i, (label, value) in enumerate(steps):
        x = slot * i + (slot - bar) / 2
        is_model = label not in ("ceiling", "floor")
        if is_model and previous is not None and previous > value:
            parts.append(_rectangle(x, y(previous), bar, y(value) - y(previous), LINE))
            parts.append(_line(x - (slot - bar), y(previous), x + bar, y(previous), MUTED))
            roomy = y(value) - y(previous) > ROOM
            drop = f"−{100 * (previous - value) / previous:.0f} %" if previous and roomy else ""
            parts.append(_text(x + bar / 2, (y(previous) + y(value)) / 2 + 4, drop, MUTED, 13))
        parts.append(_rectangle(x, y(value), bar, y(0.0) - y(value), _colour(label, i)))
        parts.append(_text(x + bar / 2, y(value) - 8, f"{number(value)} {units}", INK, 15, bold=True))
        parts.append(_text(x + bar / 2, HEIGHT - BOTTOM + 22, shown_name(label), INK, 14))
        parts.append(_text(x + bar / 2, HEIGHT - BOTTOM + 40, _meaning(label), MUTED, 12))
        if is_model:
            previous = value
    title = escape(", ".join(f"{label} {number(value)} {units}" for label, value in steps))
    return (
        f'<svg class="wide" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%" role="img" aria-label="{title}" '
        f'font-family="inherit">{"".join(parts)}</svg>{_lying(steps, units)}'
    )


def _lying(steps: Sequence[tuple[str, float]], units: str) -> str:
    """The same as lying bars, for a narrow window."""
    top = max(value for _, value in steps) or 1.0
    rows = "".join(
        f"<p><b>{escape(word(label.removeprefix('+ ')))}</b> {escape(_meaning(label))}: {number(value)} {escape(units)}"
        f'<span class="lying" style="width:{max(1.0, 100 * value / top):.0f}%;background:{_colour(label, i)}">'
        "</span></p>"
        for i, (label, value) in enumerate(steps)
    )
    return f'<div class="narrow">{rows}</div>'


def shown_name(label: str) -> str:
    """A step's name as a person reads it."""
    names = {"ceiling": "predictability bound", "floor": "noise floor"}
    return names.get(label, word(label.removeprefix("+ ")))


def _colour(label: str, index: int) -> str:
    if label in ("ceiling", "floor"):
        return CEILING if label == "ceiling" else FLOOR
    return BEFORE if index == 0 else AFTER


def _meaning(label: str) -> str:
    return {
        "base": "the model as it was",
        "model": "the model as it is",
        "ceiling": "lowest predictable error",
        "floor": "what repeats differ by",
    }.get(label, "effect added" if label.startswith("+ ") else "a model as it stands")


def _rectangle(x: float, y: float, width: float, height: float, colour: str) -> str:
    height = max(height, 0.5)
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" fill="{colour}" rx="2"/>'


def _line(x1: float, y1: float, x2: float, y2: float, colour: str, dashes: str = "none") -> str:
    ends = f'x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"'
    return f'<line {ends} stroke="{colour}" stroke-dasharray="{dashes}"/>'


def _text(x: float, y: float, text: str, colour: str, size: int, bold: bool = False) -> str:
    weight = ' font-weight="600"' if bold else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle" fill="{colour}" font-size="{size}"{weight}>'
        f"{escape(text)}</text>"
    )
