"""Who may ask this server: its own pages, in a browser that was given the token, and nobody else.

Against other sites in the same browser: the `Host` must be this computer (a foreign name that resolves to it is DNS
rebinding), the `Origin` this server, and what changes anything carries the token in a header, which no other site can
send. Against other people: the token, first in the address (as Jupyter has it), then in a cookie.
"""

import hmac
import ipaddress
from collections.abc import Iterable
from urllib.parse import parse_qs, urlencode

from pydantic_core import from_json
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN_HEADER = "x-labrig-token"
RIG_HEADER = "x-labrig-rig"
LOOPBACK = ("127.0.0.1", "localhost", "::1")
MOST_JSON_BYTES = 4_000_000
_READS = ("GET", "HEAD")
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; font-src 'self'; frame-src {frames}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}


class Guarded:
    """The application behind these checks; `hosts` are names besides this computer's own that it may be called by."""

    def __init__(self, app: ASGIApp, token: str, hosts: Iterable[str] = ()) -> None:
        self._app = app
        self._token = token
        self._hosts = {*LOOPBACK, *(host.lower() for host in hosts)}
        # The vent button is another server, on a port of its own; beyond this computer under any of its addresses.
        frames = "http://*:*" if tuple(hosts) else "http://localhost:* http://127.0.0.1:*"
        self._headers = {**_HEADERS, "content-security-policy": _POLICY.format(frames=frames)}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass on with the headers that keep a page to itself."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        request, headers = Request(scope, receive), Headers(scope=scope)
        answer = self._refusal(scope, headers) or self._entry(request)
        if answer is None and scope["method"] not in _READS:
            answer = await _with_body(request)
        await (answer or self._app)(scope, receive, _adding(send, self._headers))

    def _refusal(self, scope: Scope, headers: Headers) -> PlainTextResponse | None:
        host = headers.get("host", "")
        name = _name(host)
        if name not in self._hosts and not _is_address(name):
            return _no(f"{name or 'no host'}: this workbench goes by no such name")
        origin = headers.get("origin")
        if origin is not None and origin != f"{scope['scheme']}://{host}":
            return _no("another site asks; only the workbench's own pages may")
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin") and not _is_visit(
            scope, headers
        ):
            return _no("another site asks; only the workbench's own pages may")
        if scope["method"] not in _READS and not self._knows(headers.get(TOKEN_HEADER)):
            return _no(
                "the request lacks the workbench's token; open the address that `labrig workbench` printed"
            )
        return None

    def _entry(self, request: Request) -> PlainTextResponse | RedirectResponse | None:
        """A token in the address becomes a cookie; without either there is no way in."""
        given, headers = parse_qs(request.scope["query_string"].decode("latin-1")), request.headers
        if "token" in given and request.scope["path"] == "/":
            if not self._knows(given["token"][0]):
                return _no("the token in the address is wrong; open the one that `labrig workbench` printed")
            rest = urlencode({k: v for k, v in given.items() if k != "token"}, doseq=True)
            answer = RedirectResponse("/" + (f"?{rest}" if rest else ""), 303)
            answer.set_cookie(_cookie(headers), self._token, httponly=True, samesite="lax", path="/")
            return answer
        # Other programs on this computer have cookies of their own here, of any form: they are passed over.
        if self._knows(headers.get(TOKEN_HEADER)) or self._knows(request.cookies.get(_cookie(headers))):
            return None
        return _no("this workbench opens with a token: open the address that `labrig workbench` printed")

    def _knows(self, given: str | None) -> bool:
        return given is not None and hmac.compare_digest(given.encode(), self._token.encode())


def may_move_rig(request: Request, rig_token: str) -> bool:
    """Whether a request comes from the page that was opened for the rig."""
    given = request.headers.get(RIG_HEADER)
    return given is not None and hmac.compare_digest(given.encode(), rig_token.encode())


async def _with_body(request: Request) -> PlainTextResponse | None:
    """Read the JSON that a request brings into its state; uploads are left to whoever stores them."""
    request.state.body = {}
    if not request.headers.get("content-type", "").startswith("application/json"):
        return None
    read = bytearray()
    # Counted as it comes: what is sent in pieces does not say how much it is.
    try:
        async for chunk in request.stream():
            read += chunk
            if len(read) > MOST_JSON_BYTES:
                most = MOST_JSON_BYTES // 10**6
                return PlainTextResponse(f"the request brings more than {most} MB; send less", 413)
    except ClientDisconnect:  # the page was closed meanwhile
        return PlainTextResponse("the request is not whole", 400)
    try:
        body = from_json(bytes(read) or b"{}", allow_inf_nan=False)  # also refuses what is nested too deeply
    except ValueError:
        body = None
    if not isinstance(body, dict):
        return PlainTextResponse("the request brings no JSON object", 400)
    request.state.body = body
    return None


def _adding(send: Send, headers: dict[str, str]) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            given = message.get("headers", [])
            there = {name.lower() for name, _ in given}  # what an answer says of itself is kept
            own = [(k.encode(), v.encode()) for k, v in headers.items() if k.encode() not in there]
            message = {**message, "headers": [*given, *own]}
        await send(message)

    return sending


def _no(why: str) -> PlainTextResponse:
    return PlainTextResponse(f"labrig workbench: {why}\n", 403)


def _name(host: str) -> str:
    """The name in a Host header, without its port."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.rpartition(":")[0].lower() if ":" in host else host.lower()


def _is_address(name: str) -> bool:
    """An address in digits: no other site can make a browser believe that it is its own name."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _is_visit(scope: Scope, headers: Headers) -> bool:
    """A person follows a link to the page itself, or from one report to the next, which have an origin of their own."""
    return (
        (scope["path"] == "/" or scope["path"].startswith("/reports/"))
        and headers.get("sec-fetch-mode") == "navigate"
        and headers.get("sec-fetch-dest") == "document"
    )


def _cookie(headers: Headers) -> str:
    """Cookies know no ports: workbenches side by side have names of their own."""
    return f"labrig-{headers.get('host', '').rpartition(':')[2] or '80'}"
