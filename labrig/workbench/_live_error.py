"""How far a model is from a run that goes on, capture by capture: a process of its own, so that nothing waits for it.

python -m labrig.workbench._live_error RUN MODEL

It asks the run for its captures, predicts all of them with the whole model, its effects and the pressures' history
included, and says after each look on one line of output: `{"captures": [...], "last": {...}}`, the root mean square
error per coordinate, mm, of each capture. It ends with the run, or when its input ends, or where the run cannot be
reached in time; with 1 where asking anew would say the same again.
"""

import json
import math
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from labrig._errors import LabrigError
from labrig._json import plain
from labrig._running import BusyError, GoneError, Note, notes
from labrig.effects import rows_of
from labrig.log import read_run_yaml
from labrig.model import Model
from labrig.run_contents import CaptureContent, LiveError, NewCaptures, RunStatus

_LOOK_S = 0.5
_REST = 3.0
"""After a look that took so long it rests three times as long: it never has more than a quarter of a core."""


class Watched:
    """What is known so far of a run that goes on."""

    def __init__(self, note: Note) -> None:
        self.note = note
        self.about: RunStatus = self._begun()
        self.start_s = float(read_run_yaml(Path(self.about["folder"])).get("start_s") or 0.0)
        self.captures: list[CaptureContent] = []
        self.actuations: list[Any] = []

    def _begun(self) -> RunStatus:
        """How it stands, once it has opened its devices: before that it does not know its markers."""
        while True:
            about: RunStatus = self.note.ask("status")
            if "markers" in about:
                return about
            time.sleep(_LOOK_S)

    def look(self) -> bool:
        """Ask what is new; whether there is a new capture."""
        before = len(self.captures)
        while True:
            new: NewCaptures = self.note.ask(
                "captures", capture=len(self.captures), actuation=len(self.actuations)
            )
            self.captures += new["captures"]
            self.actuations += new["actuations"]
            if not new["captures"]:
                return len(self.captures) > before

    def dataset(self) -> xr.Dataset:
        """The captures as a campaign of one row each; see docs/reference/dataset.md."""
        chambers, markers = self.about["chambers"], self.about["markers"]
        limits = self.about["limits_kpa"]
        n, C = len(self.captures), len(chambers)
        values = np.array([capture["values"] for capture in self.captures], float)
        hold = np.array([[capture["hold_s"]] for capture in self.captures], float)
        time_s = np.array([[capture["time_s"] - self.start_s] for capture in self.captures], float)
        of = np.array([capture["event"] for capture in self.captures], np.int64)
        pressure = np.array([pressure for _, pressure in self.actuations], float)
        moments = np.array([moment - self.start_s for moment, _ in self.actuations], float)
        kpa = {"units": "kPa"}
        data: dict[str, Any] = {
            "commanded": (("capture", "chamber"), values[:, :C], kpa),
            "measured": (("capture", "time", "chamber"), values[:, None, C : 2 * C], kpa),
            "position_mm": (("capture", "time", "marker", "axis"), values[:, 2 * C :].reshape(n, 1, -1, 3)),
            "hold_s": (("capture", "time"), hold),
            "time_s": (("capture", "time"), time_s),
            "settled": (("capture", "time"), np.ones((n, 1), bool)),
            "event_time_s": ("event", moments),
            "event_commanded": (("event", "chamber"), pressure, kpa),
        }
        if self.about.get("rest_mm"):
            data["rest_mm"] = (("marker", "axis"), np.array(self.about["rest_mm"], float))
        coords: dict[str, Any] = {
            "capture": np.arange(n),
            "chamber": chambers,
            "marker": markers,
            "axis": list("xyz"),
            "chamber_min": ("chamber", np.array([low for low, _ in limits])),
            "chamber_max": ("chamber", np.array([high for _, high in limits])),
            "session": ("capture", ["0"] * n),
            "event_session": ("event", ["0"] * len(moments)),
            "event_of": ("capture", of),
            "repeat": ("capture", [capture["repeat"] for capture in self.captures]),
        }
        attributes = {"source": "rig", "between_sessions": "vented", "start_s": self.start_s}
        return xr.Dataset(data, coords=coords, attrs=attributes)


def errors(watched: Watched, model: Model) -> LiveError:
    """The error of every capture so far, and the last one's markers; raises `LabrigError` where the two do not fit."""
    rows = rows_of(watched.dataset())
    if (needed := _coefficients(model, len(rows.chambers))) >= len(watched.captures):
        raise LabrigError(
            f"a map that is fitted to these captures says nothing of them before there are {needed + 1}"
        )
    context = model.context(rows)
    residual = context.residual
    seen = np.isfinite(residual)
    rms = np.sqrt((np.where(seen, residual, 0.0) ** 2).sum(axis=1) / np.maximum(seen.sum(axis=1), 1))
    last = watched.captures[int(rows.capture[-1])]
    return {
        "captures": [
            {"step": watched.captures[c]["step"], "time_s": float(t), "rms": float(r)}
            for c, t, r in zip(rows.capture.tolist(), rows.time_s, rms, strict=True)
        ],
        "rms": float(np.sqrt((residual[seen] ** 2).mean())) if seen.any() else None,
        "last": {
            "step": last["step"],
            "label": last["label"],
            "measured_mm": rows.values[-1].reshape(-1, 3),
            "predicted_mm": context.base[-1].reshape(-1, 3),
        },
    }


def _said(watched: Watched, model: Model) -> LiveError:
    try:
        return errors(watched, model)
    except LabrigError as error:  # more captures may mend it
        return {"error": str(error)}


def _coefficients(model: Model, chambers: int) -> int:
    """Of each observable's polynomial, where the base is one: it goes through as many captures exactly."""
    base = model.file.base
    return math.comb(chambers + base.degree, base.degree) if base.kind == "static" else 0


def main() -> None:
    """Look, predict, say, until the run or the input ends."""
    folder, path = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2])
    gone = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), gone.set()), daemon=True).start()
    try:
        model = Model.load(path)
        note = next((note for note in notes("run") if note.facts.get("folder") == folder), None)
        if note is None:
            return
        watched = Watched(note)
        if not watched.about.get("markers"):
            raise LabrigError("the rig has no markers: there is nothing to hold the model against")
        while not gone.is_set():
            began = time.monotonic()
            if watched.look():
                print(json.dumps(plain(_said(watched, model))), flush=True)
            took_s = time.monotonic() - began
            gone.wait(max(_LOOK_S, _REST * took_s))
    except (
        GoneError,
        BusyError,
        OSError,
    ):  # nobody answers in time, or nobody reads any more: it may be asked anew
        return
    except LabrigError as error:
        print(json.dumps({"error": str(error)}), flush=True)
        sys.exit(1)


if __name__ == "__main__":
    main()
