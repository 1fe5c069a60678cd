"""Encryption of the dashboard: certificates that are given, or one of the station's own."""

from __future__ import annotations

import ipaddress
import os
import socket
import ssl
from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from aos_gcs.errors import ConfigurationError
from aos_gcs.extras import load_extra
from aos_gcs.input_values import require_file

CERTIFICATE_NAME: Final = ".tls.pem"
KEY_NAME: Final = ".tls.key"
_VALID_FOR: Final = timedelta(days=825)
"""Longest time for which phones believe a certificate that somebody has installed."""
_EXTRA: Final = "team"
_OWNER_ONLY: Final = 0o600


@dataclass(frozen=True, slots=True)
class TlsFiles:
    """Certificate and private key, as PEM; both may be in one file."""

    certificate: Path
    key: Path


def server_context(files: TlsFiles) -> ssl.SSLContext:
    """Return how connections are encrypted: TLS 1.2 or newer.

    Raises:
        ConfigurationError: the files cannot be used.
        InputDataError: one of them is not there.
    """
    require_file(files.certificate, f"api.tls_cert: the certificate {files.certificate}")
    require_file(files.key, f"api.tls_key: the key {files.key}")
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.set_alpn_protocols(["http/1.1"])
    try:
        # A key with a passphrase would have the service wait for somebody to type it.
        context.load_cert_chain(files.certificate, files.key, password=_no_passphrase)
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"api.tls_cert, api.tls_key: {files.certificate} and {files.key} cannot be used ({error}). "
            "Both are PEM files; the key has to fit the certificate, and no passphrase."
        ) from error
    return context


def _no_passphrase() -> bytes:
    raise ValueError("the key has a passphrase")


def fingerprint(certificate: Path) -> str:
    """Return the SHA-256 of a certificate, as browsers show it.

    Raises:
        ConfigurationError: the file cannot be read.
    """
    try:
        text = certificate.read_text(encoding="ascii")
        begin, end = text.index("-----BEGIN CERTIFICATE-----"), text.index("-----END CERTIFICATE-----")
        der = ssl.PEM_cert_to_DER_cert(text[begin:end] + "-----END CERTIFICATE-----\n")
    except (OSError, ValueError) as error:
        raise ConfigurationError(f"api.tls_cert: {certificate} has no certificate as PEM ({error}).") from error
    digest = sha256(der).hexdigest().upper()
    return ":".join(digest[index : index + 2] for index in range(0, len(digest), 2))


def own_certificate(folder: Path, now: datetime) -> TlsFiles:
    """Return the station's own certificate, signed by itself; a new one where there is none, or it expires soon.

    Raises:
        ConfigurationError: it cannot be made or written.
    """
    files = TlsFiles(folder / CERTIFICATE_NAME, folder / KEY_NAME)
    x509 = load_extra("cryptography.x509", _EXTRA, "A certificate of the station's own")
    if files.certificate.is_file() and files.key.is_file():
        try:
            found = x509.load_pem_x509_certificate(files.certificate.read_bytes())
        except (OSError, ValueError) as error:
            raise ConfigurationError(
                f"api.tls: {files.certificate} is no certificate ({error}). Remove it, and a new one is made."
            ) from error
        if found.not_valid_after_utc - now > timedelta(days=7):
            return files
    certificate, key = _make(x509, now)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write(files.key, key)
        _write(files.certificate, certificate)
    except OSError as error:
        raise ConfigurationError(f"api.tls: the certificate cannot be written in {folder}: {error}.") from error
    return files


def _make(x509: Any, now: datetime) -> tuple[bytes, bytes]:
    """Return a certificate for the names and addresses of this machine, and its key, as PEM."""
    ec = load_extra("cryptography.hazmat.primitives.asymmetric.ec", _EXTRA, "A certificate")
    hashes = load_extra("cryptography.hazmat.primitives.hashes", _EXTRA, "A certificate")
    serialization = load_extra("cryptography.hazmat.primitives.serialization", _EXTRA, "A certificate")
    key = ec.generate_private_key(ec.SECP256R1())
    host = socket.gethostname()[:60] or "station"
    name = x509.Name([x509.NameAttribute(x509.oid.NameOID.COMMON_NAME, f"aos-gcs {host}"[:64])])
    names = [x509.DNSName(one) for one in ("localhost", host, f"{host}.local") if one.isascii()]
    addresses = [x509.IPAddress(ipaddress.ip_address(one)) for one in ("127.0.0.1", "::1", *local_addresses())]
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + _VALID_FOR)
        .add_extension(x509.SubjectAlternativeName([*names, *addresses]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([x509.oid.ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(key, hashes.SHA256())
    )
    pem = serialization.Encoding.PEM
    private = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    return certificate.public_bytes(pem), private


def _write(path: Path, content: bytes) -> None:
    unfinished = path.with_name(path.name + ".new")
    unfinished.unlink(missing_ok=True)
    descriptor = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _OWNER_ONLY)
    with os.fdopen(descriptor, "wb") as file:
        file.write(content)
    unfinished.replace(path)


def local_addresses() -> tuple[str, ...]:
    """Return the IPv4 addresses of this machine in its networks; none where the library that asks is not installed."""
    try:
        ifaddr = load_extra("ifaddr", _EXTRA, "The list of this machine's addresses")
    except ConfigurationError:
        return ()
    found = (ip.ip for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4)
    return tuple(dict.fromkeys(one for one in found if not ipaddress.ip_address(one).is_loopback))
