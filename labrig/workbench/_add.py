"""Add: effects switched on and off; what each is worth, what it changes, and the model file that would be saved."""

import difflib
from typing import Any

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.contents import Summary
from labrig.view import added as added_by
from labrig.workbench._answers import answering, body_of, told
from labrig.workbench._desk import Desk
from labrig.workbench._held import Key, opened, trial
from labrig.workbench._run import Pair, pair_of
from labrig.workbench._shapes import errors_of, shape_of


def routes(desk: Desk) -> list[Route]:
    """`/api/add/effects` gives the switches, `/api/add` the state of some of them; `/api/add/save` saves one."""
    return [
        Route("/api/add/effects", answering(lambda request: _switches(desk, request))),
        Route("/api/add", answering(lambda request: _add(desk, request))),
        Route("/api/add/save", answering(lambda request: _save(desk, request)), methods=["POST"]),
    ]


def _switches(desk: Desk, request: Request) -> Any:
    pair = pair_of(desk, request.query_params)
    found = pair.diagnosis()
    text = desk.worker.ask(switches, pair.key, found)
    desk.worker.warm(pair.key)
    return Response(text, media_type="application/json")


def _add(desk: Desk, request: Request) -> Any:
    asked = request.query_params
    pair = pair_of(desk, asked)
    names = _names(asked.get("effects", ""))
    refine = asked.get("refined") == "1"
    return Response(desk.worker.ask(added, pair.key, names, refine), media_type="application/json")


def _save(desk: Desk, request: Request) -> Any:
    asked = body_of(request)
    pair = pair_of(desk, asked)
    names = _names(str(asked.get("effects", "")))
    if not names:
        raise LabrigError("nothing is switched on: there is nothing to save")
    path = desk.path(str(asked.get("name", "")))
    if path.parent not in (desk.folder, pair.model.parent):
        raise LabrigError(
            f"{asked.get('name') or 'its name is empty'}: give the model a plain name, without a folder"
        )
    if path.suffix != ".yaml":
        raise LabrigError(f"{asked.get('name') or 'its name is empty'}: a model's name ends in .yaml")
    if path.exists():
        raise LabrigError(f"{desk.name(path)}: exists already; choose another name")
    words = improve_words(desk, pair, names, desk.name(path), force=bool(asked.get("force")))
    return desk.jobs.start(words, f"improve {pair.model_name}", pair.run_name).facts()


def improve_words(
    desk: Desk, pair: Pair, names: tuple[str, ...], output: str, force: bool = False
) -> list[str]:
    """The command that adds effects to a model."""
    out = pair.run / f"{output.rpartition('/')[2].removesuffix('.yaml')}"
    adding = [word for name in names for word in ("--add", name)]
    words = ["improve", pair.run_name, "--model", pair.model_name, *adding, "-o", output]
    return [*words, "--out", desk.name(out), *(["--force"] if force else [])]


def _names(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for name in text.split(",") if name))


def switches(key: Key, found: Summary) -> str:
    """Every effect that could be added, the likeliest first, and the surface that follows; in the worker."""
    own = opened(key)
    library = own.model.library()
    has = [entry.name for entry in own.model.file.effects]
    calls = {each["effect"]: each for each in found["effects_considered"]}
    order = {"sure": 0, "possible": 1}
    compared = own.compare()
    names = sorted(
        (name for name in library if name not in has),
        key=lambda name: (
            order.get(calls.get(name, {}).get("call", ""), 2),
            -calls.get(name, {}).get("probability", 0.0),
            name,
        ),
    )
    return told(
        {
            "effects": [
                {
                    "effect": name,
                    "call": calls.get(name, {}).get("call", "not it"),
                    "probability": calls.get(name, {}).get("probability", 0.0),
                    "meaning": library[name].meaning,
                }
                for name in names
            ],
            "has": has,
            "found": added_by(found),
            "shape": shape_of(compared),
            "captures": [str(name) for name in compared.fields["capture"].values],
        }
    )


def added(key: Key, names: tuple[str, ...], refine: bool) -> str:
    """The model with these effects: errors, what each is worth, values, the model file's change; in the worker."""
    from labrig.model import model_text
    from labrig.view import fitted, place_tables, shown_of, value_lines, values_words

    own = opened(key)
    if names:
        tried = trial(key, names, refine)
        result, falls = tried.result, tried.falls
    else:
        result, falls = own.compare(), ()
    error = result.summary["error"]
    before = model_text(own.model.file).splitlines()
    after = model_text(result.improved.file if result.improved else own.model.file).splitlines()
    by_chamber = {signature.effect: signature.chambers for signature in result.signatures}
    unit = own.ready.context.rows.actuation_unit
    waterfall = [(label.replace("model", "base"), value) for label, value in result.waterfall]
    return told(
        {
            "effects": list(names),
            "refined": refine or not names,
            "units": result.summary["units"],
            "error": {"base": error.get("base", error["model"]), **error},
            "drop": result.summary.get("drop", 0.0),
            "waterfall": waterfall,
            "falls": [{"effect": each.effect, "helps": each.helps, "words": each.words} for each in falls],
            "values": [
                {
                    "effect": one.effect,
                    "form": one.form,
                    "words": values_words(shown_of(one), one.units),
                    "parameters": one.parameters,
                    "tables": place_tables(
                        shown_of(one), by_chamber.get(one.effect, {}), unit, {}, one.units
                    ),
                }
                for one in fitted(result)
            ],
            "lines": value_lines(result),
            "diff": list(
                difflib.unified_diff(before, after, "model.yaml", "with these effects", n=2, lineterm="")
            ),
            "captures": errors_of(result),
        }
    )
