"""The model that a run was planned for: `labrig next` wrote its set-points, to tell what that model lacks."""

from functools import lru_cache
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._yaml import read_yaml
from labrig.log import read_run_yaml
from labrig.workbench._desk import Desk

NEXT = "next.yaml"
_PLACES = (f"*/*/{NEXT}", f"*/*/*/{NEXT}", f"*/*/*/*/{NEXT}")
_HOLD_S = 4.0  # of a point that says nothing of it


def planned_for(desk: Desk, run: Path) -> Path | None:
    """The model whose next experiment a run is, from next.yaml in a folder of the model's name; None for others."""
    facts = read_run_yaml(run)
    if facts.get("procedure") != "programme":
        return None
    points = _points((facts.get("parameters") or {}).get("points"))
    for place in _PLACES:
        for path in desk.folder.glob(place):
            if points and _points(_content(path)) == points:
                return model_of(desk, path)
    return None


def model_of(desk: Desk, programme: Path) -> Path | None:
    """The model that a next.yaml is about: RUN/MODEL/next.yaml, the model beside the run or above it."""
    folder = programme.parent
    above = [folder.parent, *(p for p in folder.parent.parents if p.is_relative_to(desk.folder))]
    places = [*above, desk.folder / "models"]
    return next((path for place in places if (path := place / f"{folder.name}.yaml").is_file()), None)


def chambers_of(programme: Path) -> set[str]:
    """The chambers that the set-points of a procedure file name; none where it has no such list."""
    try:
        return set(_chambers(str(programme), programme.stat().st_mtime_ns))
    except OSError:
        return set()


@lru_cache(maxsize=256)
def _chambers(programme: str, _changed_ns: int) -> frozenset[str]:
    return frozenset(name for at, _, _ in _points(_content(Path(programme))) for name, _ in at)


def _content(path: Path) -> Any:
    try:
        return read_yaml(path, "procedure").get("points")
    except LabrigError:
        return None


def _points(points: Any) -> list[tuple[tuple[tuple[str, float], ...], float, str]]:
    """Set-points, their holds and labels, which tell programmes apart; [] for what is no list of points."""
    try:
        return [
            (
                tuple(sorted((str(name), float(value)) for name, value in point["pressure_kpa"].items())),
                float(point.get("hold_s", _HOLD_S)),
                str(point.get("label", "")),
            )
            for point in points
        ]
    except (TypeError, KeyError, AttributeError, ValueError):
        return []
