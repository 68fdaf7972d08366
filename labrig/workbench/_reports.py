"""The reports of an investigation, as they lie in its folder: pages with scripts, kept apart from the workbench.

A report is shown in a sandbox: the browser gives it an origin that nobody has, so it reads nothing of the workbench
and asks nobody for anything, whatever stands in the file.
"""

from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.investigation import STATE
from labrig.workbench._answers import answering
from labrig.workbench._desk import Desk

REPORT = "report.html"
POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


def routes(desk: Desk) -> list[Route]:
    """`/reports/INVESTIGATION/report.html`, and those of its rounds."""
    return [Route("/reports/{name:path}", answering(lambda r: _report(desk, r)))]


def _report(desk: Desk, request: Request) -> Any:
    name = request.path_params["name"]
    path = desk.existing(name)
    if path.name != REPORT or not any((folder / STATE).is_file() for folder in path.parents[:2]):
        raise LabrigError(f"{name}: is no report of an investigation")
    return FileResponse(path, headers={"content-security-policy": POLICY, "cache-control": "no-store"})
