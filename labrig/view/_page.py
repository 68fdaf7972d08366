"""One self-contained HTML page: style, sections, and interactive plots with the plotting library inlined once."""

import json
from collections.abc import Sequence
from html import escape

from labrig.view._explorer_script import LINKED_CAMERAS
from labrig.view._figures import Figure
from labrig.view._style import CSS

_CONFIG = {"displayModeBar": False, "responsive": True}


class Page:
    """Collects a page's body and its figures; `html()` puts them together."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._body: list[str] = []
        self._figures: list[Figure] = []
        self._parts: dict[str, str] = {}

    def add(self, markup: str) -> None:
        """Append markup as it is."""
        self._body.append(markup)

    def section(self, title: str, about: str = "") -> None:
        """Append a heading, and a line that says what is to be seen under it."""
        self.add(f"<h2>{escape(title)}</h2>")
        if about:
            self.add(f'<p class="about">{escape(about)}</p>')

    def plot(self, figure: Figure) -> str:
        """Register a figure; returns the markup of the place where it will be drawn."""
        self._figures.append(figure)
        height = int(figure["layout"].get("height", 300))
        return f'<div class="drawn" id="plot{len(self._figures) - 1}" style="height:{height}px"></div>'

    def script(self, name: str, text: str) -> None:
        """Run a script once all figures are drawn; of one name only once."""
        self._parts[name] = text

    def html(self) -> str:
        """The whole page; it loads nothing from anywhere."""
        return (
            '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{escape(self._title)}</title><style>{CSS}</style></head>\n"
            f"<body><main>\n{chr(10).join(self._body)}\n</main>\n{self._scripts()}</body></html>\n"
        )

    def _scripts(self) -> str:
        if not self._figures:
            return ""
        from plotly.offline import get_plotlyjs

        figures = json.dumps(self._figures, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")
        config = json.dumps(_CONFIG)
        return (
            f"<script>{get_plotlyjs()}</script>\n<script>const figures={figures};\n"
            f'Promise.all(figures.map((f,i)=>Plotly.newPlot("plot"+i,f.data,f.layout,{config}))).then(()=>{{'
            f"{LINKED_CAMERAS}{''.join(self._parts.values())}}});</script>\n"
        )


def table(
    header: Sequence[str], rows: Sequence[Sequence[str]], classes: Sequence[str] = (), marked: int = 0
) -> str:
    """A table of cells that are markup already, one class a column; the first `marked` rows stand out."""
    classes = [*classes, *([""] * len(header))][: len(header)]

    def cells(tag: str, values: Sequence[str]) -> str:
        pairs = zip(values, classes, strict=True)
        return "".join(f'<{tag} class="{c}">{v}</{tag}>' if c else f"<{tag}>{v}</{tag}>" for v, c in pairs)

    body = "".join(
        f"<tr{' class=chosen' if i < marked else ''}>{cells('td', row)}</tr>" for i, row in enumerate(rows)
    )
    return f'<div class="scroll"><table><tr>{cells("th", list(header))}</tr>{body}</table></div>'


def bar(share: float, width: float = 120.0, pale: bool = False) -> str:
    """A bar of `share` (0 to 1) of `width` pixels."""
    share = min(1.0, max(0.0, share)) if share == share else 0.0
    return f'<span class="bar{" pale" if pale else ""}" style="width:{max(1.0, share * width):.0f}px"></span>'
