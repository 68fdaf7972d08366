"""The tutorial's notebook as a page: run from top to bottom, with what it shows."""

import json
import subprocess
import tempfile
from html import escape
from pathlib import Path
from typing import Any

PLOTLY = "application/vnd.plotly.v1+json"
TIMEOUT_S = 240


def executed(path: Path) -> Any:
    """The notebook after it was run in a folder of its own; raises nbclient's error where a cell fails."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(
            notebook,
            timeout=TIMEOUT_S,
            kernel_name="python3",
            resources={"metadata": {"path": folder}},
            extra_arguments=["--log-level=40"],
        )
        # what a cell prints comes as messages; what the kernel's own libraries print as it ends is no warning
        client.execute(stderr=subprocess.DEVNULL)
    return notebook


def notebook_page(path: Path) -> dict[str, str]:
    """The pages and files that the notebook becomes, by their places on the site."""
    from plotly.offline import get_plotlyjs

    parts: list[str] = []
    figures = 0
    for cell in executed(path).cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in cell.outputs:
            data = output.get("data", {})
            if PLOTLY in data:
                parts.append(_figure(data[PLOTLY], figures))
                figures += 1
            elif "text/html" in data:
                parts.append(f'<div class="output">{_one_line(data["text/html"])}</div>')
            else:
                text = output.get("text") or data.get("text/plain", "")
                parts.append(f'<div class="output"><pre>{escape(text.rstrip())}</pre></div>')
    parts.append(f"[This page as a notebook]({path.name})")
    head = '<script src="assets/plotly.min.js"></script>'
    title, rest = parts[0], parts[1:]
    return {
        f"{path.stem}.md": "\n\n".join([title, head, *rest]) + "\n",
        "assets/plotly.min.js": get_plotlyjs(),
    }


def _figure(content: dict[str, Any], number: int) -> str:
    layout = {**content.get("layout", {})}
    layout.pop("template", None)
    height = int(layout.get("height", 380))
    data, shown = (json.dumps(part).replace("</", "<\\/") for part in (content["data"], layout))
    return (
        f'<div class="output" id="figure{number}" style="height:{height}px"></div>\n\n'
        f'<script>Plotly.newPlot("figure{number}",{data},{shown},{{responsive:true,displayModeBar:false}})</script>'
    )


def _one_line(html: str) -> str:
    """Without line breaks, so that Markdown leaves it as it is."""
    return " ".join(html.split())
