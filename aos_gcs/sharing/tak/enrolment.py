"""A client certificate from a TAK server, by name and password, as ATAK and its relatives get theirs.

Two requests to the server's port for enrolment: which names the certificate is to carry, and the request to sign. The
private key is made here and leaves this machine in no message.
"""

from __future__ import annotations

import json
import re
import socket
import ssl
from base64 import b64encode
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote, urlencode

from defusedxml import ElementTree
from defusedxml.common import DefusedXmlException

from aos_gcs.errors import ConfigurationError, LinkError
from aos_gcs.extras import load_extra
from aos_gcs.input_values import shown
from aos_gcs.sharing.settings import TakSettings
from aos_gcs.sharing.tak.connection import reason_text, tls_error

TIMEOUT_S: Final = 15.0
"""Longest silence of the server."""
_MAX_BYTES: Final = 262_144
_KEY_BITS: Final = 2048
"""Size of the RSA key."""
_OK: Final = 200
_REFUSED: Final = (401, 403)
_OTHER_NAME: Final = (62, 64)
"""OpenSSL's codes for a certificate of another host and of another address."""
_MOST_NAMES: Final = 8
"""Names of a certificate that are told."""
_NAMES: Final = {"O": "ORGANIZATION_NAME", "OU": "ORGANIZATIONAL_UNIT_NAME"}
"""Names that servers ask for, by those of the library."""
_MAX_NAME: Final = 64
_ARMOUR: Final = re.compile(r"-----[A-Z ]+-----")
_EXTRA: Final = "team"


@dataclass(frozen=True, slots=True)
class Enrolment:
    """What the server has signed, as PEM."""

    certificate: bytes
    key: bytes = field(repr=False)
    """Without a passphrase."""
    authorities: bytes
    """Certificates of the server's authorities; empty where it sends none."""
    valid_until: str
    """Last day on which the certificate is valid, ISO 8601."""


def enrol(settings: TakSettings, user: str, password: str) -> Enrolment:
    """Have a TAK server sign a certificate; blocks until it has, or does not answer.

    Args:
        settings: connection that the certificate is for; ``ca_file`` is trusted, if it exists, beside the system's.
        user: name of the account, which becomes that of the certificate.
        password: its password, or the server's token for one enrolment.

    Raises:
        ConfigurationError: the library for certificates is missing, or ``ca_file`` cannot be read.
        LinkError: the server cannot be reached, is not trusted, refuses, or answers what is no certificate.
    """
    x509 = load_extra("cryptography.x509", _EXTRA, "Enrolment")
    rsa = load_extra("cryptography.hazmat.primitives.asymmetric.rsa", _EXTRA, "Enrolment")
    serialization = load_extra("cryptography.hazmat.primitives.serialization", _EXTRA, "Enrolment")
    server = _Server(settings, user, password)
    names = _names(server.ask("GET", "/Marti/api/tls/config"))
    key = rsa.generate_private_key(public_exponent=65537, key_size=_KEY_BITS)
    query = urlencode({"clientUid": settings.name, "version": "1"}, quote_via=quote)
    request = _signing_request(x509, key, user, names)
    answer = server.ask("POST", f"/Marti/api/tls/signClient/v2?{query}", request)
    signed, authorities = _signed(answer, x509)
    if signed.public_key() != key.public_key():
        raise LinkError(f"The server at {server.place} has signed another key than ours; ask its administrator.")
    pem = serialization.Encoding.PEM
    return Enrolment(
        signed.public_bytes(pem),
        key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()),
        b"".join(one.public_bytes(pem) for one in authorities),
        signed.not_valid_after_utc.date().isoformat(),
    )


class _Server:
    """The server's port for enrolment."""

    def __init__(self, settings: TakSettings, user: str, password: str) -> None:
        self._host = settings.address[0]
        self._port = settings.enrol_port
        self._name = settings.server_name or self._host
        self._authorization = "Basic " + b64encode(f"{user}:{password}".encode()).decode()
        self._context = _trust(settings)
        self._nameless = _trust(settings)
        self._nameless.check_hostname = False  # its authority is checked all the same
        self.place = f"{self._host}:{self._port}"

    def ask(self, method: str, path: str, body: bytes | None = None) -> bytes:
        """Return the answer to a request."""
        headers = {"Authorization": self._authorization, "Accept": "application/json"}
        if body is None:
            headers["Accept"] = "application/xml"
        try:
            status, answer = self._exchange(method, path, body, headers)
        except TimeoutError:
            raise LinkError(f"No answer of {self.place} within {TIMEOUT_S:.0f} s; check address and network.") from None
        except ssl.SSLError as error:
            raise LinkError(f"{self.place}: {tls_error(error)}{self._other_names(error)}") from error
        except OSError as error:
            raise LinkError(f"{self.place}: {reason_text(error)}") from error
        except HTTPException as error:
            raise LinkError(f"{self.place} does not speak HTTP; check the port (tak.enrol_port).") from error
        if status in _REFUSED:
            raise LinkError(
                f"{self.place} refuses the user or the password (status {status}); a token for enrolment may have "
                "been used before, or have run out."
            )
        if status != _OK:
            raise LinkError(
                f"{self.place} does not enrol (status {status}); check the port (tak.enrol_port), and that the server "
                "has enrolment switched on."
            )
        if len(answer) > _MAX_BYTES:
            raise LinkError(f"{self.place} has answered more than {_MAX_BYTES // 1024} KiB; that is no TAK server.")
        return answer

    def _exchange(self, method: str, path: str, body: bytes | None, headers: Mapping[str, str]) -> tuple[int, bytes]:
        with socket.create_connection((self._host, self._port), TIMEOUT_S) as raw:
            connection = HTTPConnection(self._host, self._port)
            # Encrypted here, as the name in the server's certificate may be another one than its address.
            connection.sock = self._context.wrap_socket(raw, server_hostname=self._name)
            try:
                connection.request(method, path, body, dict(headers))
                response = connection.getresponse()
                return response.status, response.read(_MAX_BYTES + 1)
            finally:
                connection.close()

    def _other_names(self, error: ssl.SSLError) -> str:
        """Return which names the server's certificate has instead of the expected one; the password is not sent."""
        if not isinstance(error, ssl.SSLCertVerificationError) or error.verify_code not in _OTHER_NAME:
            return ""
        try:
            with (
                socket.create_connection((self._host, self._port), TIMEOUT_S) as raw,
                self._nameless.wrap_socket(raw) as encrypted,
            ):
                certificate: Mapping[str, Any] = encrypted.getpeercert() or {}
        except OSError:
            return ""
        names = [shown(value) for _, value in certificate.get("subjectAltName", ())]
        return f" Its names: {', '.join(names[:_MOST_NAMES])}." if names else ""


def _trust(settings: TakSettings) -> ssl.SSLContext:
    context = ssl.create_default_context()
    if settings.ca_file is not None and Path(settings.ca_file).is_file():
        try:
            context.load_verify_locations(settings.ca_file)
        except (OSError, ssl.SSLError) as error:
            raise ConfigurationError(f"tak.ca_file: {settings.ca_file} is not a PEM file of certificates.") from error
    return context


def _names(config: bytes) -> dict[str, str]:
    """Return the names that the server wants in a certificate."""
    try:
        entries = ElementTree.fromstring(config, forbid_dtd=True).iter()
        found = {one.get("name", ""): one.get("value", "") for one in entries if one.tag.endswith("nameEntry")}
    except (ElementTree.ParseError, DefusedXmlException, ValueError) as error:
        raise LinkError("The server's answer about certificates is no XML; check the port (tak.enrol_port).") from error
    return {name: value[:_MAX_NAME] for name, value in found.items() if name in _NAMES and value}


def _signing_request(x509: Any, key: Any, user: str, names: Mapping[str, str]) -> bytes:
    hashes = load_extra("cryptography.hazmat.primitives.hashes", _EXTRA, "Enrolment")
    serialization = load_extra("cryptography.hazmat.primitives.serialization", _EXTRA, "Enrolment")
    attributes = [x509.NameAttribute(x509.oid.NameOID.COMMON_NAME, user)]
    attributes += [x509.NameAttribute(getattr(x509.oid.NameOID, _NAMES[name]), names[name]) for name in sorted(names)]
    request = x509.CertificateSigningRequestBuilder().subject_name(x509.Name(attributes)).sign(key, hashes.SHA256())
    pem: bytes = request.public_bytes(serialization.Encoding.PEM)
    return pem


def _signed(answer: bytes, x509: Any) -> tuple[Any, list[Any]]:
    """Return the certificate of an answer, and those of the authorities."""
    try:
        parts = json.loads(answer)
        certificate = x509.load_pem_x509_certificate(_pem(parts["signedCert"]))
        authorities = [x509.load_pem_x509_certificate(_pem(parts[name])) for name in _authority_names(parts)]
        authorities = list(dict.fromkeys(authorities))  # some servers send one under several names
    except (ValueError, TypeError, KeyError) as error:
        raise LinkError("The server's answer holds no certificate that can be read; ask its administrator.") from error
    return certificate, authorities


def _authority_names(parts: Mapping[str, object]) -> Iterator[str]:
    return (name for name in sorted(parts) if re.fullmatch(r"ca\d{1,2}", name))


def _pem(text: str) -> bytes:
    """Return a certificate with the lines around it, which servers leave out."""
    body = "".join(_ARMOUR.sub("", text).split())
    lines = [body[begin : begin + _MAX_NAME] for begin in range(0, len(body), _MAX_NAME)]
    return "\n".join(["-----BEGIN CERTIFICATE-----", *lines, "-----END CERTIFICATE-----", ""]).encode("ascii")
