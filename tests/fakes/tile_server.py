"""A tile server on this machine that answers as a test wants, and remembers what it was asked."""

from __future__ import annotations

import ssl
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler

import cv2
import numpy as np

from tests.fakes.http_server import HttpServer

Place = tuple[int, int, int]


@dataclass(frozen=True)
class Reply:
    """Answer to one request."""

    body: bytes = b""
    status: int = 200
    headers: Mapping[str, str] = field(default_factory=dict)


def picture(place: Place = (0, 0, 0), *, ending: str = ".png", side_px: int = 256) -> bytes:
    """Return a tile whose colour tells its place."""
    pixels = np.full((side_px, side_px, 3), [(40 * one) % 256 for one in place], dtype=np.uint8)
    return cv2.imencode(ending, pixels)[1].tobytes()


@dataclass
class TileServer:
    """What the server answers and was asked; tests may change ``answer`` at any time."""

    address: str
    host: str
    answer: Callable[[Place, int], Reply] = lambda place, _: Reply(picture(place))
    """Answer to the request for a tile, of which it is the so manieth, counted from 0."""
    asked: list[Place] = field(default_factory=list)
    paths: list[str] = field(default_factory=list)
    agents: set[str] = field(default_factory=set)
    most_at_once: int = 0


@contextmanager
def tile_server(context: ssl.SSLContext | None = None) -> Iterator[TileServer]:
    """Serve tiles at ``/tiles/ZOOM/COLUMN/ROW.png``, with TLS if a context is given."""
    lock = threading.Lock()
    open_requests = 0

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            nonlocal open_requests
            zoom, column, rest = self.path.rsplit("/", 3)[1:]
            place = int(zoom), int(column), int(rest.split(".")[0])
            with lock:
                open_requests += 1
                server.most_at_once = max(server.most_at_once, open_requests)
                count = server.asked.count(place)
                server.asked.append(place)
                server.paths.append(self.path)
                server.agents.add(self.headers["User-Agent"])
            reply = server.answer(place, count)
            with lock:
                open_requests -= 1
            self.send_response_only(reply.status)
            for name, value in {"Content-Length": str(len(reply.body)), **reply.headers}.items():
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(reply.body)

        def log_message(self, *_: object) -> None:
            """Keep quiet."""

    with HttpServer(("127.0.0.1", 0), Handler) as listening:
        listening.daemon_threads = True
        scheme = "http"
        if context is not None:
            scheme = "https"
            listening.socket = context.wrap_socket(listening.socket, server_side=True)
        host = f"127.0.0.1:{listening.server_port}"
        server = TileServer(f"{scheme}://{host}/tiles/{{z}}/{{x}}/{{y}}.png", host)
        thread = threading.Thread(target=listening.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            listening.shutdown()
            thread.join()
