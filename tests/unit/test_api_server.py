"""The server's own socket."""

from __future__ import annotations

import socket

import pytest

from aos_gcs.api.server import listen
from aos_gcs.errors import LinkError


def test_answers_are_not_held_back_by_the_kernel() -> None:
    with (
        listen("127.0.0.1", 0) as listener,
        socket.create_connection(listener.getsockname()),
        listener.accept()[0] as accepted,
    ):
        assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_port_in_use_is_refused_with_the_remedy() -> None:
    with listen("127.0.0.1", 0) as listener, pytest.raises(LinkError, match="--port"):
        listen("127.0.0.1", listener.getsockname()[1])
