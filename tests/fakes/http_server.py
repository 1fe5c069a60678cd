"""HTTP servers of tests."""

from __future__ import annotations

import sys
from http.server import ThreadingHTTPServer
from typing import Any


class HttpServer(ThreadingHTTPServer):
    """A server on this machine whose clients may hang up at any time, as those do that refuse its answer."""

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report what is a defect: the thread of a request may outlive its test, and with it what it would print to."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)
