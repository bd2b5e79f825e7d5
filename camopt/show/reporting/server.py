"""The server of the page with sliders. It answers this machine only, with a secret token in each address.

The token is new at each start, and every path begins with it. A page of another site cannot send requests: the host
must be this machine (which stops DNS rebinding), a POST must come from the page's own origin, and no other origin
can read an answer. Few connections without the token are kept: a new one closes the oldest. So no other program can
lock the page out or fill the memory. The server of the standard library is enough for one user and a few paths.
"""

import hmac
import json
import os
import secrets
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from socket import SHUT_RDWR
from threading import Lock
from typing import Any, ClassVar

from camopt.core.kernels.compile_rule import compile_never
from camopt.core.mistakes import BadInput, Mistake
from camopt.scene.machine import Machine
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.reporting.session import MachineSession, PageSession, Session, answer_request
from camopt.solve.smallest.optimise import with_all_sizes

HOST = "127.0.0.1"
MOST_BYTES = 1 << 16  # of a request
SILENT_SECONDS = 60.0  # s; a silent connection is closed then
MOST_UNKNOWN_CONNECTIONS = 32  # connections without the token; a browser opens six at once
RESPONSE_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
JSON_TYPE, HTML_TYPE = "application/json", "text/html; charset=utf-8"
"""Media types of answers."""


class RequestRefused(Exception):
    """A request that is refused: only the status is sent."""


class Server(ThreadingHTTPServer):
    """The server of one session, with a token for all requests and a ticket for the first one."""

    daemon_threads = True
    allow_reuse_address = os.name == "posix"  # on other systems another program could listen too
    request_queue_size = MOST_UNKNOWN_CONNECTIONS

    def __init__(self, session: PageSession, port: int = 0, notify: Callable[[str], None] = print) -> None:
        self.session, self.notify = session, notify
        self.token, self.ticket = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        self.lock = Lock()
        self.unknown_connections: dict[Any, None] = {}
        try:
            super().__init__((HOST, port), RequestHandler)
        except OSError as trouble:
            raise OSError(trouble.errno or 0, trouble.strerror or str(trouble), f"{HOST}:{port}") from None

    @property
    def origin(self) -> str:
        return f"http://{HOST}:{self.server_port}"

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"{self.origin}/{self.token}/"

    @property
    def one_time_address(self) -> str:
        """An address that works once: other users of this machine can read the command line of the browser."""
        return f"{self.origin}/{self.ticket}"

    def redeem_ticket(self, text: str) -> bool:
        """Whether a text is the ticket, which then expires."""
        with self.lock:
            redeemed = bool(self.ticket) and secrets_match(text, self.ticket)
            self.ticket = "" if redeemed else self.ticket
        return redeemed

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in its own thread; close the oldest of too many unknown connections."""
        with self.lock:
            self.unknown_connections[request] = None
            oldest = (
                next(iter(self.unknown_connections))
                if len(self.unknown_connections) > MOST_UNKNOWN_CONNECTIONS
                else None
            )
            if oldest:
                del self.unknown_connections[oldest]
                with suppress(OSError):
                    oldest.shutdown(SHUT_RDWR)  # its thread then reads the end and closes it
        super().process_request(request, client_address)

    def trust_connection(self, request: Any) -> None:
        """Mark a connection as known: it has shown the token."""
        with self.lock:
            self.unknown_connections.pop(request, None)

    def shutdown_request(self, request: Any) -> None:
        self.trust_connection(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore broken connections, which the page reports; print the traceback of any other error."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)

    def server_close(self) -> None:
        self.session.close()
        super().server_close()


def open_server(
    what: Scene | Machine, folder: Path, port: int = 0, notify: Callable[[str], None] = print
) -> Server:
    """A server for a scene or a machine, already listening; ``serve_forever`` answers until it is interrupted.

    If a scene lacks sizes, the page opens with its smallest cam.

    Raises
    ------
    BadInput
        If ``folder`` is not a folder. If the scene lacks a size: as ``optimise``.
    Unmet
        If the scene lacks sizes and no cam is feasible.
    OSError
        If the port is taken.
    """
    if not folder.is_dir():
        raise BadInput([Mistake("camopt", "folder", str(folder), "an existing folder")])
    compile_never()  # a slider would wait for the compiler
    if isinstance(what, Machine):
        return Server(MachineSession(what, folder), port, notify)
    scene = with_all_sizes(what)
    resolve_design(scene)
    if scene is not what:
        notify("The scene lacks sizes; the page opens with its smallest cam.")
    return Server(Session(scene, folder), port, notify)


def secrets_match(one: str, other: str) -> bool:
    """Whether two secrets are equal, compared in constant time."""
    return hmac.compare_digest(one.encode(), other.encode())


class RequestHandler(BaseHTTPRequestHandler):
    """One connection of the page."""

    server: Server
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True  # else the body of an answer waits until its head is acknowledged
    timeout: ClassVar[float] = SILENT_SECONDS

    def do_GET(self) -> None:
        """Send the page, or redirect the ticket to it."""
        with self._send_refusals():
            self._check_host()
            if self.server.redeem_ticket(self.path.removeprefix("/")):
                self._send(HTTPStatus.SEE_OTHER, b"", HTML_TYPE, Location=f"/{self.server.token}/")
            elif self._path_after_token() == "":
                self._send(HTTPStatus.OK, self.server.session.page().encode(), HTML_TYPE)
            else:
                raise RequestRefused(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """Answer a request of the page."""
        with self._send_refusals():
            self._check_host()
            path = self._path_after_token()
            if self.headers["Origin"] != f"http://{self.headers['Host']}":
                raise RequestRefused(HTTPStatus.FORBIDDEN)
            request = self._request_body()
            if path not in self.server.session.answers:
                raise RequestRefused(HTTPStatus.NOT_FOUND)
            text = json.dumps(
                answer_request(self.server.session, path, request), allow_nan=False, separators=(",", ":")
            )
            self._send(HTTPStatus.OK, text.encode(), JSON_TYPE)

    def _check_host(self) -> None:
        port = self.server.server_port
        if self.headers.get_all("Host") not in ([f"{HOST}:{port}"], [f"localhost:{port}"]):
            raise RequestRefused(HTTPStatus.FORBIDDEN)

    def _path_after_token(self) -> str:
        """The path after the token."""
        token, _, rest = self.path.removeprefix("/").partition("/")
        if not secrets_match(token, self.server.token):
            raise RequestRefused(HTTPStatus.FORBIDDEN)
        self.server.trust_connection(self.connection)
        return rest if rest or self.path.endswith("/") else "-"

    def _request_body(self) -> Any:
        """The JSON body of a request."""
        length = self.headers["Content-Length"] or ""
        if not (length.isascii() and length.isdigit()) or self.headers["Transfer-Encoding"]:
            raise RequestRefused(HTTPStatus.BAD_REQUEST)
        if len(length) > 9 or int(length) > MOST_BYTES:
            raise RequestRefused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        if self.headers["Content-Type"] != JSON_TYPE:
            raise RequestRefused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
        try:
            return json.loads(self.rfile.read(int(length)), parse_int=float, parse_constant=_refuse_json_constant)
        except (ValueError, RecursionError):
            raise RequestRefused(HTTPStatus.BAD_REQUEST) from None

    @contextmanager
    def _send_refusals(self) -> Iterator[None]:
        """Within the block, send a refusal as a status only. A fault of camopt is printed to the terminal."""
        try:
            yield
        except RequestRefused as refused:
            self.send_error(refused.args[0])
        except (ConnectionError, TimeoutError):
            self.close_connection = True
        except Exception as fault:
            self.server.notify(f"internal error: {type(fault).__name__}: {fault}")
            self.send_error(HTTPStatus.INTERNAL_SERVER_ERROR)

    def _send(self, status: int, body: bytes, content_type: str, **more: str) -> None:
        self.send_response(status)
        for name, value in {
            **RESPONSE_HEADERS,
            "Content-Type": content_type,
            "Content-Length": str(len(body)),
            **more,
        }.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send only the status; the rest of the request is not read."""
        self.close_connection = True
        self._send(code, b"", "text/plain", Connection="close")

    def version_string(self) -> str:
        return "camopt"

    def log_message(self, format: str, *args: Any) -> None:
        """Log no requests: their addresses contain the token."""


def _refuse_json_constant(name: str) -> None:
    raise ValueError(name)
