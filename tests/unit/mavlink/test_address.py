from __future__ import annotations

import contextlib
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given

from aos_drivers.links.address import SigningOptions, parse_link
from aos_gcs.errors import ConfigurationError


@pytest.mark.parametrize(
    ("text", "kind", "host", "port"),
    [
        ("udpin://0.0.0.0:14550", "udpin", "0.0.0.0", 14550),  # noqa: S104
        ("udpout://10.0.0.2:14555", "udpout", "10.0.0.2", 14555),
        ("tcp://sitl:5760", "tcpout", "sitl", 5760),
        ("tcpout://[::1]:5760", "tcpout", "::1", 5760),
        ("tcpin://localhost:1", "tcpin", "localhost", 1),
        ("serial:///dev/ttyUSB0:57600", "serial", "/dev/ttyUSB0", 57600),
        ("serial:///dev/serial/by-id/usb-x-if00:921600", "serial", "/dev/serial/by-id/usb-x-if00", 921600),
    ],
)
def test_links_are_understood(text: str, kind: str, host: str, port: int) -> None:
    link = parse_link(text)
    assert (link.kind, link.host, link.port, link.text) == (kind, host, port, text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "14550",
        "udp://1.2.3.4:5",
        "udpin://:14550",
        "udpin://host",
        "udpin://host:0",
        "udpin://host:70000",
        "serial://ttyUSB0:57600",
        "serial:///dev/ttyUSB0",
    ],
)
def test_other_links_are_named_with_the_allowed_forms(text: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_link(text)
    assert repr(text) in str(caught.value)
    assert "udpin://HOST:PORT" in str(caught.value)


def test_a_link_says_how_it_is_signed() -> None:
    assert parse_link("udpin://0.0.0.0:14550").signing is None
    refusing = parse_link("udpin://0.0.0.0:14550?sign=/etc/a.key")
    assert (refusing.kind, refusing.port, refusing.signing) == ("udpin", 14550, SigningOptions(Path("/etc/a.key")))
    accepting = parse_link("serial:///dev/ttyUSB0:57600?sign=a.key&unsigned=accept")
    assert accepting.signing == SigningOptions(Path("a.key"), accepts_unsigned=True)


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("sing=a.key", "unknown option 'sing'"),
        ("sign=", "name the key file"),
        ("unsigned=accept", "name the key file"),
        ("sign=a.key&unsigned=maybe", "refuse or accept"),
    ],
)
def test_options_that_make_no_sense_are_named(query: str, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        parse_link(f"udpin://0.0.0.0:14550?{query}")


def test_a_baud_rate_of_zero_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="baud rate"):
        parse_link("serial:///dev/ttyUSB0:0")


@given(
    st.text("udptcpinoserial:/?=&%[]@.0159 \\\0é漢", max_size=40),
    st.sampled_from(["", "udpin://", "serial:///dev/", "tcp://h:1?"]),
)
def test_any_text_is_a_link_or_a_named_error(text: str, start: str) -> None:
    with contextlib.suppress(ConfigurationError):
        assert parse_link(start + text).port > 0
