"""The pictures of an investigation by name, each made when it is asked for: what a notebook draws."""

from collections.abc import Callable
from functools import partial
from itertools import accumulate

from labrig.investigation_contents import InvestigationContent
from labrig.view._figures import FONT, Figure, _layout
from labrig.view._pictures import error_bars
from labrig.view._style import AFTER, FLOOR


def investigation_pictures(content: InvestigationContent) -> dict[str, Callable[[], Figure]]:
    """What can be drawn of an investigation (the content of investigation.json), as `pictures_of` does of a result.

    `rounds` (error and noise floor after each round, over the time on the rig) and `error` (from the model to the
    noise, with all runs).
    """
    pictures: dict[str, Callable[[], Figure]] = {"rounds": partial(_rounds, content)}
    if steps := [(str(name), float(value)) for name, value in content["waterfall"] if value is not None]:
        pictures["error"] = partial(error_bars, steps, str(content["units"]))
    return pictures


def _rounds(content: InvestigationContent) -> Figure:
    rounds = content["rounds"]
    minutes = list(accumulate(each["minutes"] for each in rounds))
    names = [f"{each['round']}: {each['programme']}, {each['verdict']}" for each in rounds]
    lines: list[Figure] = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": {"model": "error with what was found", "floor": "noise floor"}[key],
            "x": minutes,
            "y": [each["error"][key] for each in rounds],
            "hovertext": names,
            "hoverinfo": "text+y",
            "line": {"color": colour},
        }
        for key, colour in (("model", AFTER), ("floor", FLOOR))
    ]
    upright = {"title": {"text": f"error, {content['units']} rms", "font": FONT}, "rangemode": "tozero"}
    across = {"title": {"text": "time on the rig, min", "font": FONT}}
    return {"data": lines, "layout": _layout(xaxis=across, yaxis=upright)}
