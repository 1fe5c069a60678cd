"""Ports that are found now and opened later."""

from __future__ import annotations

import os
import socket
from itertools import combinations, islice

import pytest

from aos_gcs.runtime.simulated.unused_ports import unused_ports


@pytest.mark.parametrize("kind", [socket.SOCK_DGRAM, socket.SOCK_STREAM])
def test_a_port_in_use_is_passed_over(kind: socket.SocketKind) -> None:
    _, port = islice(unused_ports(kind), 2)
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", port))
        assert port not in islice(unused_ports(kind), 3)


def test_every_port_comes_once_and_none_is_one_that_systems_give_away() -> None:
    ports = list(unused_ports(socket.SOCK_DGRAM))
    assert len(ports) == len(set(ports)) > 5000
    assert min(ports) >= 1024
    assert max(ports) + 1 < 32_768, "the first one that Linux gives to a socket that asks for any"
    assert all(port % 2 == 0 for port in ports), "the next one is that of RTCP"


def test_processes_that_start_one_after_the_other_begin_far_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    starts = []
    for process in range(4711, 4719):
        monkeypatch.setattr(os, "getpid", lambda process=process: process)
        starts.append(next(unused_ports(socket.SOCK_DGRAM)))
    assert min(abs(one - other) for one, other in combinations(starts, 2)) > 500
