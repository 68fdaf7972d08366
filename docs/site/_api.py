"""The reference of labrig's public names, out of their docstrings."""

import inspect

import labrig


def api_page() -> str:
    """One entry for each name that `dir(labrig)` shows, functions first."""
    names = [name for name in labrig.__all__ if not name.startswith("_")]
    functions = [name for name in names if not inspect.isclass(getattr(labrig, name))]
    classes = [name for name in names if name not in functions]
    parts = [
        "# Public names\n\nWhat `import labrig` offers; `help(labrig.compare)` says the same in a notebook. Runs, "
        "models and rigs are taken as paths, or opened.\n",
        "## Functions\n",
        *(f"::: labrig.{name}\n" for name in functions),
        "## What they give back, and errors\n",
        *(f"::: labrig.{name}\n" for name in classes),
    ]
    return "\n".join(parts)
