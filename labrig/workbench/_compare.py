"""Compare: how far a model is from a run, and what is drawn of it."""

from typing import Any

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from labrig._durable import write_new
from labrig._errors import LabrigError
from labrig.workbench._answers import answering, body_of, told
from labrig.workbench._desk import Desk
from labrig.workbench._held import Key, opened
from labrig.workbench._run import Pair, pair_of
from labrig.workbench._shapes import captures_of, shape_of
from labrig.workbench._views import kept


def routes(desk: Desk) -> list[Route]:
    """`/api/compare` gives what is drawn, POSTed to it starts the comparison; `/api/model` makes a model file."""
    return [
        Route("/api/compare", answering(lambda request: _compare(desk, request))),
        Route("/api/compare", answering(lambda request: _start(desk, request)), methods=["POST"]),
        Route("/api/model", answering(lambda request: _new_model(desk, request)), methods=["POST"]),
    ]


def _compare(desk: Desk, request: Request) -> Any:
    pair = pair_of(desk, request.query_params)
    if not pair.has("compare.json"):
        return {"compared": False, "command": desk.command(_words(desk, pair))}
    return Response(kept(desk, view, pair.key), media_type="application/json")


def _start(desk: Desk, request: Request) -> Any:
    pair = pair_of(desk, body_of(request))
    job = desk.jobs.join(_words(desk, pair), f"compare {pair.run_name}", pair.run_name)
    return job.facts()


def _words(desk: Desk, pair: Pair) -> list[str]:
    return ["compare", pair.run_name, "--model", pair.model_name, "--out", desk.name(pair.results)]


def view(key: Key) -> str:
    """What the page draws of a comparison, as JSON; in the worker."""
    from labrig.view import note

    result = opened(key).compare()
    words = note(result.summary)
    return told(
        {
            "compared": True,
            "headline": words.headline,
            "why": words.why,
            "units": result.summary["units"],
            "error": result.summary["error"],
            "floor": result.summary["floor"],
            "warnings": result.summary["warnings"],
            "where": result.where,
            "shape": shape_of(result),
            "captures": captures_of(result),
        }
    )


_BASES = {"constant": 0, "straight": 1, "parabola": 2}


def _new_model(desk: Desk, request: Request) -> Any:
    """A model for who has none: a polynomial of the pressures for each observable, fitted to the run."""
    from labrig.model import ModelFile, model_text

    asked = body_of(request)
    base = str(asked.get("base", ""))
    if base not in _BASES:
        raise LabrigError(f"{base!r}: a new model is one of {', '.join(_BASES)}")
    path = desk.path(str(asked.get("name") or "model.yaml"))
    if path.suffix != ".yaml":
        raise LabrigError(f"{path.name}: a model's name ends in .yaml")
    file = ModelFile.model_validate({"base": {"kind": "static", "degree": _BASES[base]}})
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        write_new(path, model_text(file))
    except FileExistsError:
        raise LabrigError(f"{desk.name(path)}: exists already; choose another name") from None
    return {"model": desk.name(path)}
