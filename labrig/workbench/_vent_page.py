"""The vent button: a page of its own from a process of its own, which works when the workbench and its page hang.

python -m labrig.workbench._vent_page RIG HOST

It says on its first line of output where it is: `{"port": ..., "key": ...}`. Plain HTML and a form, no script: it
needs no more of a browser than a click. What became of the click is told in a frame inside the page, which is loaded
again and again while it says something; the button is not, for a click on a button that is just replaced is lost. What
it says goes when the rig is in use again: it was true of the moment that it names. The process ends when its input
ends (the workbench is gone), but not before the runs and investigations on its rig have.
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
from labrig.rig import NOBODY, RigConfig, VentNow, investigations_on, load_rig, runs_on, users_of, vent_now
from labrig_drivers import DeviceError

WHY = "the vent button"
_WAIT_S = 2.0
_LOOK_S = 1.0
_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; frame-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors http://*:* https://*:*"
)
_STYLE = """
:root { --paper: #ffffff; --ink: #1d2530; --muted: #5c6773; --red: #b3261e; --good: #1f6f8b; --line: #c9c5bb; }
:root.dark { --paper: #1b222a; --ink: #e6e8e6; --muted: #9aa5b0; --red: #c8372d; --good: #5fb0cc; --line: #44505c; }
* { box-sizing: border-box; }
body { margin: 0; height: 100vh; min-height: 52px; display: flex; align-items: center; gap: 18px; padding: 0 0 0 24px;
  background: var(--paper); color: var(--ink); font: 14px/1.35 system-ui, "Segoe UI", Roboto, Arial, sans-serif; }
form { margin: 0; } iframe { flex: 1; min-width: 0; height: 100%; border: 0; }
body.says { display: grid; align-content: safe center; padding: 0 12px 0 0; overflow: auto; }
body.says > * { min-width: 0; overflow-wrap: anywhere; }
button { font: inherit; font-size: 16px; font-weight: 700; letter-spacing: 0.04em; color: #fff; background: var(--red);
  border: 0; border-radius: 7px; padding: 8px 26px; cursor: pointer; white-space: nowrap; }
button:hover { filter: brightness(1.12); }
button:focus-visible { outline: 3px solid var(--ink); outline-offset: 2px; }
b.good { color: var(--good); } b.bad { color: var(--red); } .muted { color: var(--muted); font-size: 13px; }
ul { display: inline; margin: 0; padding: 0; } li { display: inline-block; margin-right: 14px; white-space: nowrap;
  font-variant-numeric: tabular-nums; } li span { color: var(--muted); }
@media (max-width: 700px) { body { gap: 10px; padding-left: 10px; } button { padding: 8px 16px; } }
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
        self._users: frozenset[str] = frozenset()

    def begin(self) -> None:
        """Vent, now; returns at once."""
        with self.lock:
            if self.at_work is not None and self.at_work.is_alive():
                return
            self.trouble, self.ended, self.result = "", "", None
            self._users = users_of(self.config)
            self.at_work = threading.Thread(target=self._vent, name="labrig vent", daemon=True)
            self.at_work.start()

    def wait(self, timeout_s: float) -> None:
        """Return when the vent is done, or this long after."""
        if self.at_work is not None:
            self.at_work.join(timeout_s)

    def look(self) -> None:
        """Forget how the last vent ended once somebody uses the rig who did not when it began: it may be filled."""
        with self.lock:
            if self.ended and not self.busy and users_of(self.config) - self._users:
                self.trouble, self.ended, self.result = "", "", None

    def watch(self) -> None:
        """Look again and again, also while no page asks: whoever uses the rig may be gone before one does."""
        while True:
            time.sleep(_LOOK_S)
            with suppress(OSError):
                self.look()

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
    """The button, and a frame for what became of it."""
    name = escape(venting.config.name)
    return _html(
        theme,
        f"Vent {name}",
        f'<body><form method="post" action="/{key}/vent?theme={theme}" target="said">'
        '<button type="submit">VENT</button></form>'
        f'<iframe name="said" title="what became of it" src="/{key}/said?theme={theme}"></iframe></body>',
    )


def said(venting: Venting, key: str, theme: str) -> str:
    """What the button's page says now of the last vent."""
    venting.look()
    name = escape(venting.config.name)
    again_s = 1 if venting.busy else 2 if venting.ended else 0
    if venting.busy:
        trouble = (
            f' <span class="muted">{escape(venting.trouble)}; trying again</span>' if venting.trouble else ""
        )
        text = f"<b>venting …</b>{trouble}"
    elif venting.result is not None:
        text = _confirmed(venting.result, venting.ended)
    elif venting.trouble:
        text = f'<b class="bad">NOT confirmed</b> at {venting.ended}: {escape(venting.trouble)}'
    else:
        about = f"every chamber of {name} to ambient, at once; a run or an investigation ends"
        text = f'<span class="muted">{about}</span>'
    again = (
        f'<meta http-equiv="refresh" content="{again_s};url=/{key}/said?theme={theme}">' if again_s else ""
    )
    return _html(
        theme, "What became of it", f'<body class="says"><div role="status">{text}</div></body>', again
    )


def _html(theme: str, title: str, body: str, more: str = "") -> str:
    return (
        f'<!doctype html><html lang="en" class="{theme}"><head><meta charset="utf-8"><title>{title}</title>'
        f"{more}<style>{_STYLE}</style></head>{body}</html>"
    )


def _confirmed(result: VentNow, ended: str) -> str:
    if result.by == NOBODY:
        return (
            '<b class="good">nothing is filled</b> '
            f'<span class="muted">at {ended}: the rig is simulated inside its runs, and none goes on</span>'
        )
    rows = [
        f"<li><span>{escape(name)}</span> {'no sensor' if value is None else f'{value:.1f} kPa'}</li>"
        for name, value in result.pressure_kpa.items()
    ]
    about = f"read at {ended}, {result.took_s:.1f} s after the click; vented by {result.by}"
    return (
        f'<div><b class="good">vented, confirmed</b> <ul>{"".join(rows)}</ul><br>'
        f'<span class="muted">{escape(about)}</span></div>'
    )


class _Handler(http.server.BaseHTTPRequestHandler):
    venting: Venting
    key = ""

    def do_GET(self) -> None:
        """The page with the button, or what became of it."""
        self._answer(vent=False)

    def do_POST(self) -> None:
        """Vent; answers when it is done, or after two seconds, and sends on to what became of it."""
        self._answer(vent=True)

    def _answer(self, vent: bool) -> None:
        address = urlsplit(self.path)
        given, _, rest = address.path.removeprefix("/").partition("/")
        wanted = ("vent",) if vent else ("", "said")
        if not hmac.compare_digest(given.encode(), self.key.encode()) or rest not in wanted:
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        theme = "dark" if parse_qs(address.query).get("theme") == ["dark"] else "light"
        if vent:
            self.venting.begin()
            self.venting.wait(_WAIT_S)
            self._send(HTTPStatus.SEE_OTHER, "", Location=f"/{self.key}/said?theme={theme}")
            return
        self._send(HTTPStatus.OK, (said if rest else page)(self.venting, self.key, theme))

    def _send(self, status: HTTPStatus, text: str, **more: str) -> None:
        body = text.encode()
        self.send_response(status)
        for name, value in {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": _POLICY,
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "Origin-Agent-Cluster": "?1",
            "X-Content-Type-Options": "nosniff",
            **more,
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
    threading.Thread(target=venting.watch, name="labrig vent watch", daemon=True).start()
    print(json.dumps({"port": port, "key": key}), flush=True)
    sys.stdin.read()
    while venting.busy or runs_on(config) or investigations_on(config):
        time.sleep(_LOOK_S)


if __name__ == "__main__":
    main()
