"""Encryption of the dashboard, requests without it, and proxies in front of it."""

from __future__ import annotations

import asyncio
import ipaddress
import ssl
import sys
from collections.abc import AsyncIterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import cv2
import httpx
import ifaddr
import numpy as np
import pytest
from cryptography import x509

from aos_gcs.api.access.proxies import TrustedProxies
from aos_gcs.api.listener import ServerAddress
from aos_gcs.api.plain_http import plain_answer
from aos_gcs.api.server import serve
from aos_gcs.api.tls import TlsFiles, fingerprint, local_addresses, own_certificate, server_context
from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.runtime.encryption import address_for_phones, qr_text, tls_files, with_certificate
from tests.fakes.app import app_of, client_at, stream_at
from tests.fakes.mission import ScriptedMission

CODE = "larch-and-spruce"
NOW = datetime.now(UTC)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> TlsFiles:
    return own_certificate(tmp_path_factory.mktemp("tls"), NOW)


@pytest.fixture
async def address(files: TlsFiles) -> AsyncIterator[ServerAddress]:
    app = app_of(ScriptedMission(LoopClock()), operator_code=CODE)
    async with serve(app, port=0, tls=server_context(files)) as address:
        yield address


def trusting(files: TlsFiles) -> ssl.SSLContext:
    return ssl.create_default_context(cafile=str(files.certificate))


async def test_pages_and_event_stream_are_encrypted_and_the_cookie_stays_so(
    address: ServerAddress, files: TlsFiles
) -> None:
    assert address.url.startswith("https://")
    context = trusting(files)
    async with client_at(address.url, verify=context) as client:
        signed_in = await client.post("/api/session", json={"code": CODE, "name": "Ada"})
        assert "secure" in signed_in.headers["set-cookie"].lower()
        assert (await client.get("/api/session")).json()["name"] == "Ada"
    async with stream_at(address.url.replace("https", "wss") + "api/events", ssl=context) as stream:
        assert '"kind":"hello"' in str(await stream.recv())


async def test_plain_requests_are_sent_on_and_carry_nothing_out(address: ServerAddress) -> None:
    plain = f"http://127.0.0.1:{address.port}"
    async with client_at() as client:
        sent_on = await client.get(f"{plain}/?a=1")
        assert (sent_on.status_code, sent_on.headers["location"]) == (308, f"https://127.0.0.1:{address.port}/?a=1")
        refused = await client.post(f"{plain}/api/session", json={"code": CODE, "name": "Ada"})
        assert (refused.status_code, "set-cookie" in refused.headers) == (403, False)


async def test_what_is_no_handshake_harms_nobody(address: ServerAddress, files: TlsFiles) -> None:
    for first in (b"\x16\x03\x01rubbish", b"\x00" * 64):
        reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
        writer.write(first)
        writer.write_eof()
        await reader.read()
        writer.close()
    async with client_at(verify=trusting(files)) as client:
        assert (await client.get(f"{address.url}api/session")).status_code == 200


@pytest.mark.parametrize(
    ("head", "location"),
    [
        (b"GET / HTTP/1.1\r\nHost: a.example:8080\r\n\r\n", b"https://a.example:8080/\r\n"),
        (b"HEAD /x?y HTTP/1.1\r\nA: b\r\nhost: [::1]:80\r\n\r\n", b"https://[::1]:80/x?y\r\n"),
        (b"POST / HTTP/1.1\r\nHost: a\r\n\r\n", None),
        (b"GET / HTTP/1.1\r\n\r\n", None),
        (b"GET /\xff HTTP/1.1\r\nHost: a\r\n\r\n", None),
        (b"GET / HTTP/1.1\r\nHost: a/b\r\n\r\n", None),
        (b"GET / HTTP/1.1\r\nHost: a\rSet-Cookie: b\r\n\r\n", None),
        (b"\x00\x01", None),
    ],
)
def test_plain_requests_are_answered_with_an_address_of_this_station_only(head: bytes, location: bytes | None) -> None:
    answer = plain_answer(head)
    if location is None:
        assert answer.startswith(b"HTTP/1.1 403 ")
        assert b"Location" not in answer
    else:
        assert answer.startswith(b"HTTP/1.1 308 ")
        assert b"\r\nLocation: " + location in answer


def test_the_own_certificate_stays_until_it_expires(tmp_path: Path) -> None:
    files = own_certificate(tmp_path, NOW)
    before = fingerprint(files.certificate)
    assert files.key.stat().st_mode & 0o777 == 0o600
    assert fingerprint(own_certificate(tmp_path, NOW + timedelta(days=800)).certificate) == before
    parsed = x509.load_pem_x509_certificate(files.certificate.read_bytes())
    names = parsed.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert ipaddress.ip_address("127.0.0.1") in names.get_values_for_type(x509.IPAddress)
    assert "localhost" in names.get_values_for_type(x509.DNSName)
    assert fingerprint(own_certificate(tmp_path, NOW + timedelta(days=820)).certificate) != before


def test_certificates_that_cannot_be_used_are_named(tmp_path: Path, files: TlsFiles) -> None:
    other = own_certificate(tmp_path, NOW)
    with pytest.raises(ConfigurationError, match=r"api\.tls_cert, api\.tls_key: .* cannot be used"):
        server_context(TlsFiles(files.certificate, other.key))
    with pytest.raises(InputDataError, match=r"api\.tls_cert: the certificate .*missing does not exist"):
        server_context(TlsFiles(tmp_path / "missing", other.key))
    with pytest.raises(InputDataError, match=r"api\.tls_key: the key .*missing does not exist"):
        server_context(TlsFiles(files.certificate, tmp_path / "missing"))
    other.certificate.write_text("rubbish")
    with pytest.raises(ConfigurationError, match="Remove it, and a new one is made"):
        own_certificate(tmp_path, NOW)
    with pytest.raises(ConfigurationError, match="has no certificate as PEM"):
        fingerprint(other.certificate)


def test_the_configuration_says_whether_and_by_what_is_encrypted(tmp_path: Path, files: TlsFiles) -> None:
    assert tls_files(with_certificate(ApiConfig(), tmp_path, NOW)) is None
    own = with_certificate(ApiConfig(tls=True), tmp_path, NOW)
    assert tls_files(own) == TlsFiles(tmp_path / ".tls.pem", tmp_path / ".tls.key")
    given = with_certificate(ApiConfig(tls_cert=files.certificate, tls_key=files.key), tmp_path, NOW)
    assert tls_files(given) == files
    with pytest.raises(ValueError, match="tls_key needs tls_cert"):
        ApiConfig(tls_key=files.key)
    with pytest.raises(ValueError, match="trusted_proxies"):
        ApiConfig(trusted_proxies=("proxy.example",))


def test_phones_get_an_address_that_they_reach() -> None:
    assert address_for_phones(ServerAddress("127.0.0.1", 8080)) is None
    reached = ServerAddress("192.0.2.1", 8080, is_encrypted=True)
    assert address_for_phones(reached) == reached
    rows = (qr_text(reached.url) or "").splitlines()
    assert len({len(row) for row in rows}) == 1
    assert len(rows) == (len(rows[0]) + 1) // 2  # two modules in one character
    assert set(rows[0]) == {"█"}  # the margin


@pytest.mark.parametrize("url", ["https://192.0.2.1:8080/", "https://station-with-a-long-name.example.org:8443/"])
def test_the_code_on_the_terminal_is_read_as_its_address(url: str) -> None:
    lines = (qr_text(url) or "").splitlines()
    # What a dark terminal shows: each character is two modules, light where it is drawn.
    light = np.array(
        [half for line in lines for half in ([one in "█▀" for one in line], [one in "█▄" for one in line])]
    )
    picture = np.kron(np.where(light, 255, 0), np.ones((8, 8))).astype(np.uint8)
    picture = cv2.copyMakeBorder(picture, 32, 32, 32, 32, cv2.BORDER_CONSTANT, value=0)
    text, _, _ = cv2.QRCodeDetector().detectAndDecode(picture)
    assert text == url


def test_addresses_are_those_of_the_networks_and_none_of_the_machine_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    def adapter(*addresses: str | tuple[str, int, int]) -> ifaddr.Adapter:
        return ifaddr.Adapter("x", "x", [ifaddr.IP(one, 24, "x") for one in addresses])

    found = [adapter("127.0.0.1", ("::1", 0, 0)), adapter("192.0.2.7", ("fe80::1", 0, 2)), adapter("192.0.2.7")]
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: found)
    assert local_addresses() == ("192.0.2.7",)
    monkeypatch.setitem(sys.modules, "ifaddr", None)
    assert local_addresses() == ()


@pytest.mark.parametrize(
    ("header", "client"),
    [
        ("203.0.113.9", "203.0.113.9"),
        ("1.2.3.4, 203.0.113.9", "203.0.113.9"),  # what comes first may be the client's own invention
        ("203.0.113.9, 10.0.0.7", "203.0.113.9"),
        ("", "10.0.0.2"),
        ("unknown", "10.0.0.2"),
        ("203.0.113.9, rubbish", "10.0.0.2"),
        ("10.0.0.7", "10.0.0.2"),
    ],
)
def test_proxies_tell_the_last_address_that_is_none_of_theirs(header: str, client: str) -> None:
    assert TrustedProxies(["10.0.0.0/24"]).client("10.0.0.2", header) == client


@pytest.mark.parametrize(("peer", "is_believed"), [("10.0.0.2", True), ("10.0.0.3", False)])
async def test_headers_of_proxies_are_believed_from_configured_addresses_only(peer: str, is_believed: bool) -> None:
    app = app_of(ScriptedMission(LoopClock()), operator_code=CODE, trusted_proxies=["10.0.0.2"])
    transport = httpx.ASGITransport(app, client=(peer, 1))
    async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:

        async def sign_in(code: str, claimed: str) -> httpx.Response:
            headers = {"X-Forwarded-For": claimed, "X-Forwarded-Proto": "https"}
            return await client.post("/api/session", json={"code": code, "name": "Ada"}, headers=headers)

        answers = [await sign_in("wrong", "203.0.113.9") for _ in range(7)]
        assert answers[-1].status_code == 429
        other = await sign_in(CODE, "203.0.113.10")  # another client of the proxy, or a claim of the same one
        assert (other.status_code == 200) is is_believed
        assert ("secure" in other.headers.get("set-cookie", "").lower()) is is_believed
