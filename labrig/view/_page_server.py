"""Hands the web viewer's page to a browser on this machine, and forbids that page to talk to anybody else.

The page would report its use to the viewer's makers. The browser itself keeps it from doing so: every answer
carries a content security policy that allows connections to this machine only.
"""

import http.server
import threading
import urllib.error
import urllib.request
from http import HTTPStatus

LOOPBACK = "127.0.0.1"
POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' data: blob:; "
    f"connect-src 'self' data: blob: http://{LOOPBACK}:* ws://{LOOPBACK}:*"
)
TIMEOUT_S = 10.0


class PageServer:
    """Serves what is at `source_port` on a free port of its own, on 127.0.0.1, from a thread, until closed."""

    def __init__(self, source_port: int) -> None:
        handler = type("Handler", (_Handler,), {"source": f"http://{LOOPBACK}:{source_port}"})
        self._server = http.server.ThreadingHTTPServer((LOOPBACK, 0), handler)
        self._server.daemon_threads = True
        self.port = int(self._server.server_address[1])
        self._thread = threading.Thread(target=self._server.serve_forever, name="labrig page", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join(TIMEOUT_S)


class _Handler(http.server.BaseHTTPRequestHandler):
    source = ""

    def do_GET(self) -> None:
        """Fetch the same path from the viewer and pass it on, with the policy."""
        try:
            with urllib.request.urlopen(self.source + self.path, timeout=TIMEOUT_S) as answer:
                body, kind = answer.read(), answer.headers.get("Content-Type", "application/octet-stream")
        except urllib.error.HTTPError as error:
            self.send_error(error.code)
            return
        except OSError:
            self.send_error(HTTPStatus.BAD_GATEWAY, "the viewer has ended")
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Content-Security-Policy", POLICY)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""
