"""The server: the parts' routes, the page and its scripts, the stream of events; started and stopped as one thing."""

import socket
import sys
import threading
from dataclasses import replace
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from labrig import __version__
from labrig._errors import LabrigError
from labrig.workbench._answers import answering, body_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._events import stream
from labrig.workbench._guarded import LOOPBACK, Guarded
from labrig.workbench._vent_button import VentButton

PARTS = (
    *("_run", "_runs", "_compare", "_where", "_which", "_add", "_import", "_watch", "_next", "_history"),
    *("_rig_setup", "_investigate", "_reports", "_shape"),
)
"""The modules behind the steps; each has `routes(desk)`."""
PORT = 8765
_PAGE = Path(__file__).with_name("page")
_TRIES = 20
_STOPS_S = 5.0


def application(desk: Desk, hosts: tuple[str, ...] = ()) -> Guarded:
    """The workbench of a desk as an ASGI application; `hosts` are further names that it may be called by."""
    routes: list[Any] = [
        Route("/", _index(desk)),
        Route("/api/events", _events(desk)),
        Route("/api/jobs/{job}", answering(lambda r: _job(desk, r))),
        Route("/api/jobs/{job}/cancel", answering(lambda r: _cancel(desk, r)), methods=["POST"]),
        Route("/plotly.js", _plotly),
        Mount("/page", StaticFiles(directory=_PAGE)),
    ]
    for part in PARTS:
        routes += import_module(f"labrig.workbench.{part}").routes(desk)
    return Guarded(Starlette(routes=routes), desk.token, hosts)


class Running:
    """A workbench that is served from a thread, until `stop`."""

    def __init__(self, desk: Desk, listener: socket.socket, hosts: tuple[str, ...]) -> None:
        self.desk = desk
        self.host, self.port = listener.getsockname()[:2]
        config = uvicorn.Config(
            application(desk, hosts),
            log_level="warning",
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)
        self._listener = listener
        self._thread = threading.Thread(
            target=self._server.run, args=([listener],), name="labrig workbench", daemon=True
        )
        self._thread.start()

    @property
    def address(self) -> str:
        """What a browser opens, with the token; with a rig also the second token, which the server never sees in it."""
        name = f"[{self.host}]" if ":" in self.host else self.host
        name = "127.0.0.1" if name == "0.0.0.0" else name
        rig = f"#rig={self.desk.rig_token}" if self.desk.rig_file is not None else ""
        return f"http://{name}:{self.port}/?token={self.desk.token}{rig}"

    def stop(self) -> None:
        """End the streams and the server; jobs go on, and the next workbench on the folder finds them."""
        self.desk.events.close()
        self._server.should_exit = True
        self._thread.join(_STOPS_S)
        self._listener.close()
        if self.desk.vent is not None:
            self.desk.vent.close()
        for each in self.desk.at_end:
            each()
        self.desk.worker.close()
        self.desk.planner.close()


def start(desk: Desk, host: str = LOOPBACK[0], port: int | None = None) -> Running:
    """Serve a desk; without a `port` the first free one from 8765 on.

    Raises `LabrigError` where the port is taken or the host is not this computer's.
    """
    listener = _listener(host, port)
    if desk.rig_file is not None:
        desk = replace(desk, vent=VentButton(desk.rig_file, host))
    names = () if host in LOOPBACK else (host, socket.gethostname())
    return Running(desk, listener, names)


def _listener(host: str, port: int | None) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    tried = [port] if port is not None else [*range(PORT, PORT + _TRIES), 0]
    error: OSError | None = None
    for number in tried:
        listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            if sys.platform == "win32":  # where SO_REUSEADDR lets two share a port
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
            else:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind((host, number))
            listener.listen()
        except OSError as caught:
            error = caught
            listener.close()
        else:
            return listener
    raise LabrigError(
        f"cannot listen on {host}:{tried[0]}: {(error and error.strerror) or error}; choose another --port or --host"
    )


def _index(desk: Desk) -> Any:
    text = (_PAGE / "index.html").read_text(encoding="utf-8")

    def page(request: Request) -> Response:
        desk.worker.begin()  # it is ready by the time that somebody has chosen something
        filled = text.replace("{{token}}", escape(desk.token, quote=True))
        filled = filled.replace("{{folder}}", escape(str(desk.folder), quote=True))
        filled = filled.replace("{{rig}}", escape(desk.rig_file.name if desk.rig_file else "", quote=True))
        filled = filled.replace("{{version}}", escape(__version__, quote=True))
        return HTMLResponse(filled, headers={"cache-control": "no-store"})

    return page


def _events(desk: Desk) -> Any:
    async def endpoint(request: Request) -> Response:
        return StreamingResponse(
            stream(desk), media_type="text/event-stream", headers={"cache-control": "no-store"}
        )

    return endpoint


def _plotly(request: Request) -> Response:
    import plotly

    path = Path(plotly.__file__).parent / "package_data" / "plotly.min.js"
    return FileResponse(path, media_type="text/javascript", headers={"cache-control": "max-age=86400"})


def _job(desk: Desk, request: Request) -> Any:
    job = desk.jobs.get(request.path_params["job"])
    return {**job.facts(), "output": job.output(), "usual_s": desk.jobs.usual_s(job.words)}


def _cancel(desk: Desk, request: Request) -> Any:
    job = desk.jobs.get(request.path_params["job"])
    desk.jobs.cancel(job, harder=bool(body_of(request).get("harder")))
    return says({"state": job.state}, 202)
