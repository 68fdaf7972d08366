"""Pages of the site that are generated: from the README, the effects, the public names and the notebook."""

import os
import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

from _api import api_page  # noqa: E402
from _effects import effect_names, effect_page, effects_index  # noqa: E402
from _notebook import notebook_page  # noqa: E402

OUTSIDE = {"README.md": "index.md", "benchmarks/RESULTS.md": "reference/measured.md"}
"""Files of the repository that are pages of the site under another name."""
_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)]*)?\)")


def on_config(config: Any) -> Any:
    """Put a page for each effect below the overview of them."""
    section = next(entry for entry in config.nav if "Effects" in entry)
    section["Effects"] += [{name.replace("_", " "): f"effects/{name}.md"} for name in effect_names()]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that no file under docs/ holds."""
    pages = {page: (ROOT / path).read_text(encoding="utf-8") for path, page in OUTSIDE.items()}
    pages["effects/index.md"] = effects_index()
    pages |= {f"effects/{name}.md": effect_page(name) for name in effect_names()}
    pages["reference/api.md"] = api_page()
    pages |= notebook_page(ROOT / "docs" / "tutorial-notebook.ipynb")
    for path, content in pages.items():
        files.append(File.generated(config, path, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Lead links that leave docs/ to the page that a file is here, or name the file where it is none."""
    source = next(
        (path for path, here in OUTSIDE.items() if here == page.file.src_uri), f"docs/{page.file.src_uri}"
    )
    folder = Path(source).parent

    def changed(found: re.Match[str]) -> str:
        mark, text, target, anchor = found[1], found[2], found[3], found[4] or ""
        if ":" in target:
            return found[0]
        path = Path(os.path.normpath(folder / target)).as_posix()
        if path in OUTSIDE:
            path = f"docs/{OUTSIDE[path]}"
        elif not path.startswith("docs/"):
            if not (ROOT / path).exists():
                return found[0]
            return f"`{path}`" if text in (path, f"`{path}`") else f"{text} (`{path}` in the repository)"
        here = Path("docs", page.file.src_uri).parent
        return f"{mark}[{text}]({Path(os.path.relpath(path, here)).as_posix()}{anchor})"

    return _LINK.sub(changed, markdown)
