"""The server: this machine alone, a secret in the address, a few known paths, and small requests.

Whoever asks has to know the token, which is new each time and leads every path. A page of another site cannot ask
either way: the name of the host has to be this machine's (against names that are pointed at it later), a question
has to come from the page's own origin, and no other origin is told anything. Connections that have not shown the
token are few: the oldest makes room for a new one, so nobody on this machine can keep the page out, or fill the
memory. It is the standard library's server: a handful of paths for one person needs no other.
"""

import hmac
import json
import os
import secrets
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
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.reporting.session import REQUESTS, Session, answer_request
from camopt.solve.smallest.complete_scene import with_all_sizes

HOST = "127.0.0.1"
MOST_BYTES = 1 << 16  # of a question
SILENT_SECONDS = 60.0  # seconds after which a silent connection ends
MOST_UNKNOWN_CONNECTIONS = 32  # connections that have not shown the token; a browser opens six at once
RESPONSE_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
JSON_TYPE, HTML_TYPE = "application/json", "text/html; charset=utf-8"
"""The kinds of answers."""


class RequestRefused(Exception):
    """A request that is not answered: the status, and no word why."""


class Server(ThreadingHTTPServer):
    """A session, its token, and a ticket: an address for one look, which leads to the page."""

    daemon_threads = True
    allow_reuse_address = os.name == "posix"  # elsewhere it would let another program listen too
    request_queue_size = MOST_UNKNOWN_CONNECTIONS

    def __init__(self, session: Session, port: int = 0, told: Callable[[str], None] = print) -> None:
        self.session, self.told = session, told
        self.token, self.ticket = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        self.lock = Lock()
        self.strangers: dict[Any, None] = {}
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
    def first_address(self) -> str:
        """An address that works once: what starts a browser can be read by others on this machine."""
        return f"{self.origin}/{self.ticket}"

    def redeem_ticket(self, given: str) -> bool:
        """Whether it is the ticket, which is then gone."""
        with self.lock:
            taken = bool(self.ticket) and secrets_match(given, self.ticket)
            self.ticket = "" if taken else self.ticket
        return taken

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in a thread of its own; of too many strangers the oldest goes."""
        with self.lock:
            self.strangers[request] = None
            oldest = next(iter(self.strangers)) if len(self.strangers) > MOST_UNKNOWN_CONNECTIONS else None
            if oldest:
                del self.strangers[oldest]
                with suppress(OSError):
                    oldest.shutdown(SHUT_RDWR)  # its thread reads the end, and closes it
        super().process_request(request, client_address)

    def trust_connection(self, request: Any) -> None:
        """A connection is no stranger any more."""
        with self.lock:
            self.strangers.pop(request, None)

    def shutdown_request(self, request: Any) -> None:
        self.trust_connection(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A connection that breaks is the page's matter."""

    def server_close(self) -> None:
        self.session.search.stop()
        super().server_close()


def open_server(scene: Scene, folder: Path, port: int = 0, told: Callable[[str], None] = print) -> Server:
    """A server for a scene, which listens already; ``serve_forever`` answers until it is interrupted.

    Where the scene leaves sizes to be found, the page opens with its smallest cam.

    Raises
    ------
    BadInput
        If the folder for what is saved is none; as ``optimise``, where the scene lacks a size.
    Unmet
        If no cam gives the sizes that the scene lacks.
    OSError
        If the port is taken.
    """
    if not folder.is_dir():
        raise BadInput([Mistake("camopt", "folder", str(folder), "a folder that is there")])
    given, scene = scene, with_all_sizes(scene)
    resolve_design(scene)
    if scene is not given:
        told("The scene leaves sizes to be found; the page opens with its smallest cam.")
    compile_never()  # a slider would wait for it
    return Server(Session(scene, folder), port, told)


def secrets_match(one: str, other: str) -> bool:
    """Whether two secrets are one, in a time that does not say how much of them is."""
    return hmac.compare_digest(one.encode(), other.encode())


class RequestHandler(BaseHTTPRequestHandler):
    """One connection of the page."""

    server: Server
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True  # an answer would wait for the acknowledgement of its head
    timeout: ClassVar[float] = SILENT_SECONDS

    def do_GET(self) -> None:
        """The page."""
        with self._send_refusals():
            self._check_host()
            if self.server.redeem_ticket(self.path.removeprefix("/")):
                self._send(HTTPStatus.SEE_OTHER, b"", HTML_TYPE, Location=f"/{self.server.token}/")
            elif self._page_path() == "":
                self._send(HTTPStatus.OK, self.server.session.page().encode(), HTML_TYPE)
            else:
                raise RequestRefused(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """A question of the page."""
        with self._send_refusals():
            self._check_host()
            what = self._page_path()
            if self.headers["Origin"] != f"http://{self.headers['Host']}":
                raise RequestRefused(HTTPStatus.FORBIDDEN)
            asked = self._request_body()
            if what not in REQUESTS:
                raise RequestRefused(HTTPStatus.NOT_FOUND)
            text = json.dumps(
                answer_request(self.server.session, what, asked), allow_nan=False, separators=(",", ":")
            )
            self._send(HTTPStatus.OK, text.encode(), JSON_TYPE)

    def _check_host(self) -> None:
        port = self.server.server_port
        if self.headers.get_all("Host") not in ([f"{HOST}:{port}"], [f"localhost:{port}"]):
            raise RequestRefused(HTTPStatus.FORBIDDEN)

    def _page_path(self) -> str:
        """The rest of the path, after the token."""
        token, _, rest = self.path.removeprefix("/").partition("/")
        if not secrets_match(token, self.server.token):
            raise RequestRefused(HTTPStatus.FORBIDDEN)
        self.server.trust_connection(self.connection)
        return rest if rest or self.path.endswith("/") else "-"

    def _request_body(self) -> Any:
        """The body of a question."""
        length = self.headers["Content-Length"] or ""
        if not (length.isascii() and length.isdigit()) or self.headers["Transfer-Encoding"]:
            raise RequestRefused(HTTPStatus.BAD_REQUEST)
        if len(length) > 9 or int(length) > MOST_BYTES:
            raise RequestRefused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        if self.headers["Content-Type"] != JSON_TYPE:
            raise RequestRefused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
        try:
            return json.loads(self.rfile.read(int(length)), parse_int=float, parse_constant=_refuse_constant)
        except (ValueError, RecursionError):
            raise RequestRefused(HTTPStatus.BAD_REQUEST) from None

    @contextmanager
    def _send_refusals(self) -> Iterator[None]:
        """What is refused has a status and nothing else; so has a fault of ours, which the terminal is told."""
        try:
            yield
        except RequestRefused as refused:
            self.send_error(refused.args[0])
        except (ConnectionError, TimeoutError):
            self.close_connection = True
        except Exception as fault:
            self.server.told(f"internal error: {type(fault).__name__}: {fault}")
            self.send_error(HTTPStatus.INTERNAL_SERVER_ERROR)

    def _send(self, status: int, body: bytes, kind: str, **more: str) -> None:
        self.send_response(status)
        for name, value in {
            **RESPONSE_HEADERS,
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            **more,
        }.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Nothing but the status; what is left of the request is not read."""
        self.close_connection = True
        self._send(code, b"", "text/plain", Connection="close")

    def version_string(self) -> str:
        return "camopt"

    def log_message(self, format: str, *args: Any) -> None:
        """The terminal is not told of each request: addresses have the token in them."""


def _refuse_constant(name: str) -> None:
    raise ValueError(name)
