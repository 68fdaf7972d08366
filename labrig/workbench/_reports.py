"""Reports as they lie in the folders of investigations, shapes and checks of shapes: pages with scripts, kept apart
from the workbench.

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
from labrig.workbench._shape_check import CHECKED
from labrig.workbench._shape_found import FOUND

REPORT = "report.html"
POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


def routes(desk: Desk) -> list[Route]:
    """`/reports/FOLDER/report.html`, of an investigation and its rounds, of a shape, of a check of one."""
    return [Route("/reports/{name:path}", answering(lambda r: _report(desk, r)))]


def _report(desk: Desk, request: Request) -> Any:
    name = request.path_params["name"]
    path = desk.existing(name)
    investigated = any((folder / STATE).is_file() for folder in path.parents[:2])
    if path.name != REPORT or not (
        investigated or any((path.parent / each).is_file() for each in (FOUND, CHECKED))
    ):
        raise LabrigError(f"{name}: is no report of an investigation, nor of a shape")
    return FileResponse(path, headers={"content-security-policy": POLICY, "cache-control": "no-store"})
