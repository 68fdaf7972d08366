"""The vent button: a page of its own from a process of its own, which works when the workbench and its page hang.

python -m labrig.workbench._vent_page RIG HOST

It says on its first line of output where it is: `{"port": ..., "key": ...}`. Plain HTML and a form, no script: it
needs no more of a browser than a click. It ends when its input ends (the workbench is gone), but not before the runs
on its rig have.
"""

import hmac
import http.server
import json
import secrets
import signal
import socket
import sys
import threading
import time
from contextlib import suppress
from html import escape
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from labrig._errors import LabrigError
from labrig.rig import RigConfig, VentNow, load_rig, runs_on, vent_now
from labrig_drivers import DeviceError

WHY = "the vent button"
_WAIT_S = 2.0
_LOOK_S = 1.0
_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors http://*:* https://*:*"
)
_STYLE = """
:root { --paper: #ffffff; --ink: #1d2530; --muted: #5c6773; --red: #b3261e; --good: #1f6f8b; --line: #c9c5bb; }
:root.dark { --paper: #1b222a; --ink: #e6e8e6; --muted: #9aa5b0; --red: #c8372d; --good: #5fb0cc; --line: #44505c; }
* { box-sizing: border-box; }
body { margin: 0; height: 100vh; min-height: 52px; display: flex; align-items: center; gap: 18px; padding: 0 24px;
  background: var(--paper); color: var(--ink); font: 14px/1.35 system-ui, "Segoe UI", Roboto, Arial, sans-serif; }
form { margin: 0; }
button { font: inherit; font-size: 16px; font-weight: 700; letter-spacing: 0.04em; color: #fff; background: var(--red);
  border: 0; border-radius: 7px; padding: 8px 26px; cursor: pointer; white-space: nowrap; }
button:hover { filter: brightness(1.12); }
button:focus-visible { outline: 3px solid var(--ink); outline-offset: 2px; }
.said { min-width: 0; overflow: hidden; }
b.good { color: var(--good); } b.bad { color: var(--red); } .muted { color: var(--muted); font-size: 13px; }
ul { display: inline; margin: 0; padding: 0; } li { display: inline-block; margin-right: 14px; white-space: nowrap;
  font-variant-numeric: tabular-nums; } li span { color: var(--muted); }
"""


class Venting:
    """The vents of one rig, one at a time: whoever asks while one is on waits for the same."""

    def __init__(self, config: RigConfig) -> None:
        self.config = config
        self.lock = threading.Lock()
        self.at_work: threading.Thread | None = None
        self.trouble = ""
        self.ended = ""
        self.result: VentNow | None = None

    def begin(self) -> None:
        """Vent, now; returns at once."""
        with self.lock:
            if self.at_work is not None and self.at_work.is_alive():
                return
            self.trouble, self.ended, self.result = "", "", None
            self.at_work = threading.Thread(target=self._vent, name="labrig vent", daemon=True)
            self.at_work.start()

    def wait(self, timeout_s: float) -> None:
        """Return when the vent is done, or this long after."""
        if self.at_work is not None:
            self.at_work.join(timeout_s)

    @property
    def busy(self) -> bool:
        """Whether a vent is on."""
        return self.at_work is not None and self.at_work.is_alive()

    def _vent(self) -> None:
        try:
            self.result = vent_now(self.config, WHY, self._tell)
        except (LabrigError, DeviceError) as error:
            self.trouble = str(error)
        except Exception as error:
            self.trouble = f"{type(error).__name__}: {error}; relieve the pressure by hand"
        self.ended = time.strftime("%H:%M:%S")

    def _tell(self, text: str) -> None:
        self.trouble = text


def page(venting: Venting, key: str, theme: str) -> str:
    """What the button's page says now."""
    name = escape(venting.config.name)
    again = f'<meta http-equiv="refresh" content="1;url=/{key}/?theme={theme}">' if venting.busy else ""
    if venting.busy:
        trouble = (
            f' <span class="muted">{escape(venting.trouble)}; trying again</span>' if venting.trouble else ""
        )
        said = f"<b>venting …</b>{trouble}"
    elif venting.result is not None:
        said = _confirmed(venting.result, venting.ended)
    elif venting.trouble:
        said = f'<b class="bad">NOT confirmed</b> at {venting.ended}: {escape(venting.trouble)}'
    else:
        said = (
            f'<span class="muted">every chamber of {name} to ambient, at once; a run that goes on ends</span>'
        )
    return (
        f'<!doctype html><html lang="en" class="{theme}"><head><meta charset="utf-8"><title>Vent {name}</title>'
        f"{again}<style>{_STYLE}</style></head><body>"
        f'<form method="post" action="/{key}/vent?theme={theme}"><button type="submit">VENT</button></form>'
        f'<div class="said" role="status">{said}</div></body></html>'
    )


def _confirmed(result: VentNow, ended: str) -> str:
    rows = [
        f"<li><span>{escape(name)}</span> {'no sensor' if value is None else f'{value:.1f} kPa'}</li>"
        for name, value in result.pressure_kpa.items()
    ]
    about = f"read at {ended}, {result.took_s:.1f} s after the click; vented by {result.by}"
    return (
        f'<b class="good">vented, confirmed</b> <ul>{"".join(rows)}</ul><br>'
        f'<span class="muted">{escape(about)}</span>'
    )


class _Handler(http.server.BaseHTTPRequestHandler):
    venting: Venting
    key = ""

    def do_GET(self) -> None:
        """The page with the button."""
        self._answer(vent=False)

    def do_POST(self) -> None:
        """Vent; answers when it is done, or after two seconds with a page that looks again."""
        self._answer(vent=True)

    def _answer(self, vent: bool) -> None:
        address = urlsplit(self.path)
        given, _, rest = address.path.removeprefix("/").partition("/")
        wanted = "vent" if vent else ""
        if not hmac.compare_digest(given.encode(), self.key.encode()) or rest != wanted:
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        if vent:
            self.venting.begin()
            self.venting.wait(_WAIT_S)
        theme = "dark" if parse_qs(address.query).get("theme") == ["dark"] else "light"
        body = page(self.venting, self.key, theme).encode()
        self.send_response(HTTPStatus.OK)
        for name, value in {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": _POLICY,
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "Origin-Agent-Cluster": "?1",
            "X-Content-Type-Options": "nosniff",
        }.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


class _Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that hangs up is not worth a traceback."""


class _Server6(_Server):
    address_family = socket.AF_INET6


def main() -> None:
    """Serve the button until the workbench is gone, and the runs on the rig with it."""
    for name in ("SIGINT", "SIGBREAK"):  # Ctrl-C ends the workbench; this ends after it
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    config, host = load_rig(Path(sys.argv[1])), sys.argv[2]
    venting, key = Venting(config), secrets.token_urlsafe(24)
    handler = type("Handler", (_Handler,), {"venting": venting, "key": key})
    first = (_Server6 if ":" in host else _Server)((host, 0), handler)
    servers: list[_Server] = [first]
    port = int(first.server_address[1])
    if host == "127.0.0.1":  # `localhost` may mean ::1
        with suppress(OSError):
            servers.append(_Server6(("::1", port), handler))
    for server in servers:
        threading.Thread(target=server.serve_forever, daemon=True).start()
    print(json.dumps({"port": port, "key": key}), flush=True)
    sys.stdin.read()
    while venting.busy or runs_on(config):
        time.sleep(_LOOK_S)


if __name__ == "__main__":
    main()
