"""Enrolment at a TAK server: a server of the tests signs what it is sent; what stands in the way is named."""

from __future__ import annotations

import base64
import json
import logging
import socket
import ssl
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any, ClassVar
from urllib.parse import parse_qs, urlsplit

import pytest

from aos_gcs.sharing.settings import TakSettings
from aos_gcs.sharing.tak import enrolment
from aos_gcs.sharing.tak.connection import tls_context
from tests.fakes.command_line import exit_status
from tests.fakes.http_server import HttpServer
from tests.fakes.sharing import make_authority, make_certificate

x509 = pytest.importorskip("cryptography.x509")
hashes = pytest.importorskip("cryptography.hazmat.primitives.hashes")
rsa = pytest.importorskip("cryptography.hazmat.primitives.asymmetric.rsa")
serialization = pytest.importorskip("cryptography.hazmat.primitives.serialization")

PEM = serialization.Encoding.PEM
USER, PASSWORD = "aos1", "correct:horse"
CONFIG = """<?xml version="1.0"?><ns2:certificateConfig xmlns:ns2="http://bbn.com/marti/xml/config"><nameEntries>
<nameEntry name="O" value="Mountain Rescue"/><nameEntry name="OU" value="Air"/><nameEntry name="X" value="no"/>
</nameEntries></ns2:certificateConfig>"""


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of an authority and of the server's certificate that it has signed."""
    folder = tmp_path_factory.mktemp("authority")
    make_authority(folder, "ca")
    make_authority(folder, "stranger")
    make_certificate(folder, "ca", "server")
    return folder


class Signer(BaseHTTPRequestHandler):
    """The server; a test changes what it answers."""

    folder: ClassVar[Path]
    requests: ClassVar[list[tuple[str, bytes]]]
    change: ClassVar[Callable[[str, bytes], tuple[int, bytes]] | None]

    def do_GET(self) -> None:
        self._answer(CONFIG.encode())

    def do_POST(self) -> None:
        self._answer(b"")

    def _answer(self, answer: bytes) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.requests.append((self.path, body))
        given = base64.b64decode(self.headers.get("Authorization", "").removeprefix("Basic ")).decode()
        status = 200 if given == f"{USER}:{PASSWORD}" else 401
        if body and status == 200:
            answer = json.dumps(signed(self.folder, body)).encode()
        if type(self).change is not None:
            status, answer = type(self).change(self.path, body)  # type: ignore[misc]
        self.send_response(status)
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_: Any) -> None:
        """Say nothing."""


def signed(folder: Path, request_pem: bytes, key: Any = None) -> dict[str, str]:
    """Return the answer of a server that has signed a request: without the lines around its certificates.

    The authority is there twice, as OpenTAKServer sends it.
    """
    request = x509.load_pem_x509_csr(request_pem)
    ca = x509.load_pem_x509_certificate((folder / "ca.pem").read_bytes())
    ca_key = serialization.load_pem_private_key((folder / "ca.key").read_bytes(), None)
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(request.subject)
        .issuer_name(ca.subject)
        .public_key(key or request.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + timedelta(days=30))
        .sign(ca_key, hashes.SHA256())
    )
    bare, ca_bare = ("\n".join(one.public_bytes(PEM).decode().splitlines()[1:-1]) for one in (certificate, ca))
    return {"signedCert": bare, "ca0": ca_bare, "ca1": ca_bare, "version": "2"}


@contextmanager
def serving(folder: Path, change: Callable[[str, bytes], tuple[int, bytes]] | None = None) -> Iterator[int]:
    """Serve for as long as the context is entered; the port."""
    Signer.folder, Signer.requests, Signer.change = folder, [], staticmethod(change) if change else None  # type: ignore[assignment]
    server = HttpServer(("127.0.0.1", 0), Signer)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "server.pem", folder / "server.key")
    server.socket = context.wrap_socket(server.socket, server_side=True)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    try:
        yield server.server_port
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def configuration(folder: Path, port: int, **more: str) -> Path:
    """Write a configuration that names files in its folder."""
    values = {
        "url": "tls://127.0.0.1:8089",
        "ca_file": str(folder / "ca.pem"),
        "certificate_file": str(folder / "station.pem"),
        "key_file": str(folder / "station.key"),
        "enrol_user": USER,
    } | more
    lines = [f'{name} = "{value}"' for name, value in values.items()]
    path = folder / "station.toml"
    flight = ["[link]", 'urls = ["udpin://0.0.0.0:14550"]', "[mission]", "vehicles = 2"]
    path.write_text("\n".join([*flight, "[tak]", *lines, f"enrol_port = {port}"]), encoding="utf-8")
    return path


@pytest.fixture
def station(authority: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of a station that trusts the authority and knows the password."""
    (tmp_path / "ca.pem").write_bytes((authority / "ca.pem").read_bytes())
    monkeypatch.setenv("AOS_GCS_TAK_PASSWORD", PASSWORD)
    return tmp_path


def run(*arguments: object) -> int:
    return exit_status(["tak-enrol", *arguments])


def test_the_files_of_the_configuration_are_written_for_their_owner_only(
    station: Path, authority: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    with serving(authority) as port:
        config = configuration(station, port)
        assert run(config) == 0
        assert run(config) == 2  # not again unless that is wanted
        first = (station / "station.pem").read_bytes()
        assert run(config, "--replace") == 0
    output = capsys.readouterr()
    assert "exists already" in output.err
    assert (station / "station.pem").read_bytes() != first
    assert {path.stat().st_mode & 0o777 for path in station.glob("station.*") if path != config} == {0o600}
    assert sorted(path.name for path in station.iterdir()) == ["ca.pem", "station.key", "station.pem", "station.toml"]
    names = x509.load_pem_x509_certificate(first).subject.rfc4514_string()
    assert all(name in names for name in (f"CN={USER}", "O=Mountain Rescue", "OU=Air"))
    (_, (path, request), *_) = Signer.requests
    assert parse_qs(urlsplit(path).query) == {"clientUid": ["aos-gcs"], "version": ["1"]}
    assert b"PRIVATE" not in request
    said = output.out + output.err + caplog.text
    assert not any(secret in said for secret in (PASSWORD, base64.b64encode(PASSWORD.encode()).decode(), "PRIVATE"))
    files = {name: str(station / file) for name, file in (("ca_file", "ca.pem"), ("certificate_file", "station.pem"))}
    tls_context(TakSettings("tls://127.0.0.1:8089", key_file=str(station / "station.key"), **files))


def test_authorities_are_written_where_the_station_has_none(
    station: Path, authority: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", str(authority / "ca.pem"))  # as an authority that the system trusts
    (station / "ca.pem").unlink()
    one_file = str(station / "both.pem")
    with serving(authority) as port:
        assert run(configuration(station, port, certificate_file=one_file, key_file=one_file)) == 0
    assert (station / "ca.pem").read_bytes() == (authority / "ca.pem").read_bytes()
    both = Path(one_file).read_text(encoding="ascii")
    assert "PRIVATE KEY" in both
    assert "BEGIN CERTIFICATE" in both


def other_key(_: str, body: bytes) -> tuple[int, bytes]:
    if not body:
        return 200, CONFIG.encode()
    return 200, json.dumps(signed(Signer.folder, body, rsa.generate_private_key(65537, 2048).public_key())).encode()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda _path, _body: (404, b""), "does not enrol (status 404)"),
        (lambda _path, _body: (200, b"<html>no XML"), "is no XML"),
        (lambda _path, _body: (200, b'<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>'), "is no XML"),
        (lambda _path, _body: (200, b" " * 300_000), "more than 256 KiB"),
        (lambda _path, body: (200, b"{}" if body else CONFIG.encode()), "no certificate that can be read"),
        (lambda _path, body: (200, b'{"signedCert": 3}' if body else CONFIG.encode()), "no certificate that can be"),
        (other_key, "signed another key than ours"),
    ],
)
def test_answers_that_are_none_are_named_and_nothing_is_written(
    station: Path,
    authority: Path,
    capsys: pytest.CaptureFixture[str],
    change: Callable[[str, bytes], tuple[int, bytes]],
    says: str,
) -> None:
    with serving(authority, change) as port:
        assert run(configuration(station, port)) == 2
    assert says in capsys.readouterr().err
    assert sorted(path.name for path in station.iterdir()) == ["ca.pem", "station.toml"]


def test_a_wrong_password_is_named_and_not_repeated(
    station: Path, authority: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AOS_GCS_TAK_PASSWORD", "wrong-secret")
    with serving(authority) as port:
        assert run(configuration(station, port)) == 2
    error = capsys.readouterr().err
    assert "refuses the user or the password (status 401)" in error
    assert "wrong-secret" not in error
    assert len(Signer.requests) == 1


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"ca_file": "stranger.pem"}, "not signed by the authority that we trust"),
        ({"server_name": "tak.example"}, "for another name"),
        ({"server_name": "tak.example"}, "Its names: '127.0.0.1'."),
    ],
)
def test_a_server_that_is_not_trusted_never_sees_the_password(
    station: Path, authority: Path, capsys: pytest.CaptureFixture[str], more: dict[str, str], says: str
) -> None:
    if "ca_file" in more:
        more = {"ca_file": str(authority / more["ca_file"])}
    with serving(authority) as port:
        assert run(configuration(station, port, **more)) == 2
    assert says in capsys.readouterr().err
    assert Signer.requests == []


def test_a_server_that_is_not_there_or_speaks_no_tls_is_named(
    station: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))  # Nobody listens there.
        assert run(configuration(station, unused.getsockname()[1])) == 2
    assert "refuses the connection" in capsys.readouterr().err
    plain = HttpServer(("127.0.0.1", 0), Signer)
    thread = threading.Thread(target=plain.serve_forever, args=(0.01,))
    thread.start()
    assert run(configuration(station, plain.server_port)) == 2
    assert "does not speak TLS" in capsys.readouterr().err
    plain.shutdown()
    thread.join()
    monkeypatch.setattr(enrolment, "TIMEOUT_S", 0.2)
    assert run(configuration(station, plain.server_port)) == 2  # It accepts, and answers nothing.
    assert "No answer of" in capsys.readouterr().err
    plain.server_close()


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"url": "tcp://127.0.0.1:8089"}, "tls://"),
        ({"enrol_user": "a:b"}, "enrol_user"),
        ({"enrol_password_file": "nowhere"}, "enrol_password_file"),
        ({"key_file": "nowhere/station.key"}, "folder does not exist"),
    ],
)
def test_settings_that_cannot_be_used_are_named_before_anything_is_sent(
    station: Path, authority: Path, capsys: pytest.CaptureFixture[str], more: dict[str, str], says: str
) -> None:
    with serving(authority) as port:
        assert run(configuration(station, port, **more)) == 2
    assert says in capsys.readouterr().err
    assert Signer.requests == []
