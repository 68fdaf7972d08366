"""Choose: the runs of the folder as the catalogue lists them, and what people say of them: tags and notes."""

from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig._near import meant
from labrig.catalogue import Row, list_runs, newest_first, note, rule_out, tag
from labrig.workbench._ahead import ahead
from labrig.workbench._answers import answering, body_of
from labrig.workbench._compare import view
from labrig.workbench._desk import Desk
from labrig.workbench._run import as_now, measured_now

_LINK = (
    "unreadable: a link that leads out of this folder; open a workbench on the folder in which the run lies"
)


def routes(desk: Desk) -> list[Route]:
    """`/api/runs`, `/api/effects`, `/api/tag`, `/api/note`, `/api/rule-out`."""
    return [
        Route("/api/runs", answering(lambda request: _runs(desk, request))),
        Route("/api/effects", answering(lambda request: {"effects": _effects(desk)})),
        Route("/api/tag", answering(lambda request: _tag(desk, request)), methods=["POST"]),
        Route("/api/note", answering(lambda request: _note(desk, request)), methods=["POST"]),
        Route("/api/rule-out", answering(lambda request: _rule_out(desk, request)), methods=["POST"]),
    ]


def _runs(desk: Desk, request: Request) -> Any:
    """The rows, the newest first; `where` as in `labrig runs --where`."""
    rows = list_runs(desk.folder, request.query_params.get("where") or None)
    rows = newest_first(desk.folder, rows)
    ahead(desk, [row.run for row in rows], view)
    going = measured_now()
    told = [
        Row(row.run, row.started, state=_LINK)
        if desk.leads_out(row.run)
        else as_now(row, desk.folder / row.run, going)
        for row in rows
    ]
    return {"columns": list(rows[0]._fields) if rows else [], "rows": [list(row) for row in told]}


def _effects(desk: Desk) -> list[str]:
    """The effects that may be ruled out, as a list to choose from."""
    return sorted(desk.worker.ask(effects_in, str(desk.folder)))


def _tag(desk: Desk, request: Request) -> Any:
    asked = body_of(request)
    run = desk.existing(str(asked.get("run", "")))
    words = [str(word) for word in asked.get("tags", [])]
    kept = tag(run, words, remove=bool(asked.get("remove")))
    return {"run": desk.name(run), "tags": kept.tags}


def _rule_out(desk: Desk, request: Request) -> Any:
    asked = body_of(request)
    run, effect = desk.existing(str(asked.get("run", ""))), str(asked.get("effect", "")).strip()
    if not asked.get("remove"):
        effect = _known(effect, desk.worker.ask(effects_in, str(desk.folder)))
    kept = rule_out(run, effect, remove=bool(asked.get("remove")))
    return {"run": desk.name(run), "ruled_out": kept.ruled_out_in_words}


def _known(typed: str, known: list[str]) -> str:
    """The effect that was meant, in capital letters or with blanks as well; raises `LabrigError` where it is none."""
    plain = typed.casefold().replace(" ", "_")
    if (name := next((name for name in known if name.casefold() == plain), None)) is not None:
        return name
    what = f"there is no effect {typed!r}{meant(plain, known)}" if typed else "name an effect"
    raise LabrigError(f"{what}; there are {', '.join(sorted(known))}")


def effects_in(folder: str) -> list[str]:
    """The effects that may be named there, one's own among them; in the worker."""
    from labrig.effects import library

    return list(library(Path(folder)))


def _note(desk: Desk, request: Request) -> Any:
    asked = body_of(request)
    run = desk.existing(str(asked.get("run", "")))
    return {"run": desk.name(run), "notes": note(run, str(asked.get("text", ""))).notes}
