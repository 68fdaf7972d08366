"""Which: a card for each effect, from diagnosis.json and the library; its plot and its errors when it is looked at."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.catalogue import list_runs, newest_first
from labrig.contents import Errors, Summary
from labrig.workbench._answers import answering, body_of, told
from labrig.workbench._desk import Desk
from labrig.workbench._fits import names_of
from labrig.workbench._held import Key, opened, trial
from labrig.workbench._run import Pair, pair_of, run_folder

if TYPE_CHECKING:
    from labrig.diagnosis import Trial

_MOST_OTHERS = 20


def routes(desk: Desk) -> list[Route]:
    """`/api/which` gives the cards, POSTed to it starts the diagnosis; `/api/which/effect` looks closer at one."""
    return [
        Route("/api/which", answering(lambda request: _which(desk, request))),
        Route("/api/which", answering(lambda request: _start(desk, request)), methods=["POST"]),
        Route("/api/which/effect", answering(lambda request: _effect(desk, request))),
    ]


def _which(desk: Desk, request: Request) -> Any:
    pair = pair_of(desk, request.query_params)
    others = _others(desk, pair)
    if not pair.has("diagnosis.json"):
        return {"diagnosed": False, "out": desk.name(pair.results), "others": others}
    desk.worker.warm(pair.key)
    return Response(desk.worker.ask(cards, pair.key, pair.diagnosis(), others), media_type="application/json")


def _others(desk: Desk, pair: Pair) -> list[dict[str, Any]]:
    """The other runs with the same chambers and observables, the newest first, with which it can be diagnosed, and
    whether it is (`with`).
    """
    names, together = names_of(pair.run), pair.together()
    rows = newest_first(desk.folder, list_runs(desk.folder))
    alike = [
        row
        for row in rows
        if row.run != pair.run_name
        and row.captures
        and not desk.leads_out(row.run)
        and (row.run in together or (names is not None and names_of(desk.folder / row.run) == names))
    ]
    return [
        {
            "run": row.run,
            "started": row.started,
            "captures": row.captures,
            "ruled_out": row.ruled_out,
            "with": row.run in together,
        }
        for row in alike[:_MOST_OTHERS]
    ]


def _start(desk: Desk, request: Request) -> Any:
    asked = body_of(request)
    pair = pair_of(desk, asked)
    others = [desk.name(run_folder(desk, str(name))) for name in asked.get("with") or ()]
    return desk.jobs.start(_words(desk, pair, others), f"diagnose {pair.run_name}", pair.run_name).facts()


def _words(desk: Desk, pair: Pair, others: Sequence[str] = ()) -> list[str]:
    return ["diagnose", pair.run_name, *others, "--model", pair.model_name, "--out", desk.name(pair.results)]


def _effect(desk: Desk, request: Request) -> Any:
    pair = pair_of(desk, request.query_params)
    found = pair.diagnosis()
    name = request.query_params.get("effect", "")
    beside = tuple(each for each in found["effects"] if each != name)
    return Response(desk.worker.ask(closer, pair.key, name, beside), media_type="application/json")


def cards(key: Key, found: Summary, others: list[dict[str, Any]]) -> str:
    """Every effect that was considered, the surest first, with what the library says of it; in the worker."""
    from labrig.model import Model
    from labrig.view import UNSEEN, needed, note

    words = note(found)
    library = Model.load(key[1]).library()
    alone = {each["effect"]: each for each in found.get("ranking", [])}
    order = {"sure": 0, "possible": 1, "not it": 2}
    effects = []
    for each in found["effects_considered"]:
        effect = library.get(each["effect"])
        effects.append(
            {
                **each,
                "call": each["call"] if each.get("seen", True) else UNSEEN,
                "needs": needed(found, effect, each["effect"]),
                "alone": alone[each["effect"]]["heldout_error"] if each["effect"] in alone else None,
                "meaning": effect.meaning if effect else "",
                "signature": effect.signature if effect else "",
                "experiment": effect.experiment if effect else "",
                "ruled_out_by": effect.ruled_out_by if effect else "",
                "acts_on": effect.acts_on if effect else "",
                "rival": each["effect"] in found["rivals"],
            }
        )
    effects.sort(key=lambda each: (order.get(each["call"], 3), -each["probability"], each["effect"]))
    return told(
        {
            "diagnosed": True,
            "others": others,
            "verdict": words.verdict,
            "headline": words.headline,
            "why": words.why,
            "else": words.else_,
            "next": words.next_,
            "named": words.named,
            "units": found["units"],
            "error": found["error"],
            "probability": found["probability"],
            "unnamed": found.get("unnamed", {}),
            "effects": effects,
            "warnings": found.get("warnings", []),
        }
    )


def closer(key: Key, effect: str, beside: tuple[str, ...]) -> str:
    """One effect: the error with it alone and beside the sure ones, and the plot in which it shows; in the worker."""
    from labrig.view import pictures_of, value_lines

    if effect not in opened(key).model.library():
        raise LabrigError(f"there is no effect {effect!r}")
    try:
        alone = trial(key, (effect,), True)
        others = trial(key, beside, True) if beside else None
        both = trial(key, (effect,), False, beside) if beside else alone
    except LabrigError as error:
        return told({"effect": effect, "cannot": str(error)})
    fall = next(each for each in both.falls if each.effect == effect)
    error = errors_in(fall.units, alone)
    return told(
        {
            "effect": effect,
            "units": fall.units,
            "base": error["base"],
            "floor": error["floor"],
            "alone": error["model"],
            "beside": errors_in(fall.units, both)["model"] if beside else None,
            "others": errors_in(fall.units, others)["model"] if others else None,
            "names": list(beside),
            "helps": fall.helps,
            "falls": fall.words,
            "values": value_lines(alone.result),
            "figure": pictures_of(both.result)[effect](),
        }
    )


def errors_in(units: str, tried: "Trial") -> Errors:
    """The errors with what was tried of the sensors that measure in these units."""
    summary = tried.result.summary
    return summary["error"] if units == summary["units"] else summary["error_by_unit"][units]
