"""``aos-gcs tak-enrol``: a client certificate from a TAK server, by name and password."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.errors import ConfigurationError

if TYPE_CHECKING:
    from aos_gcs.sharing.settings import TakSettings

PASSWORD = "AOS_GCS_TAK_PASSWORD"  # noqa: S105 - the name of the variable


def tak_enrol(
    config: Annotated[Path, typer.Argument(help="TOML file with the connection to TAK.", dir_okay=False)],
    *,
    replace: Annotated[bool, typer.Option("--replace", help="Replace an existing certificate.")] = False,
) -> None:
    """Have a TAK server sign a certificate, and write it into the files that the configuration names for TAK.

    The password is read from tak.enrol_password_file, from the variable AOS_GCS_TAK_PASSWORD, or asked for. It is
    neither printed nor kept. The private key is made here and stays here.
    """
    from aos_gcs.config.file import read_config  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.config.settings import sharing_settings  # noqa: PLC0415
    from aos_gcs.sharing.tak.enrolment import enrol  # noqa: PLC0415

    tak = sharing_settings(read_config(config)).tak
    if tak is None or tak.enrol_user is None:
        raise ConfigurationError(f'{config}: give it a section [tak] with url = "tls://…" and enrol_user.')
    ca, certificate, key = _files(tak)
    for path in {certificate, key}:
        if path.exists() and not replace:
            raise ConfigurationError(f"{path} exists already; add --replace to have a new one made in its place.")
        if not path.absolute().parent.is_dir():
            raise ConfigurationError(f"Cannot write {path}: its folder does not exist; create it first.")
    enrolled = enrol(tak, tak.enrol_user, _password(tak))
    if key == certificate:
        _write(key, enrolled.key + enrolled.certificate)
    else:
        _write(key, enrolled.key)
        _write(certificate, enrolled.certificate)
    typer.echo(f"certificate for {tak.enrol_user}, valid until {enrolled.valid_until}: {certificate}")
    if ca.exists():
        typer.echo(f"authorities of the server: {ca}, as it was")
    elif enrolled.authorities:
        _write(ca, enrolled.authorities)
        typer.echo(f"authorities of the server: {ca}")
    else:
        typer.echo(f"The server has sent no authorities: get {ca} from its administrator.")


def _files(tak: TakSettings) -> tuple[Path, Path, Path]:
    if tak.ca_file is None or tak.certificate_file is None or tak.key_file is None:
        raise ConfigurationError("tak: name the files to write: ca_file, certificate_file and key_file.")
    return Path(tak.ca_file), Path(tak.certificate_file), Path(tak.key_file)


def _password(tak: TakSettings) -> str:
    from aos_gcs.sharing.secrets import read_secret  # noqa: PLC0415

    if tak.enrol_password_file is not None or os.environ.get(PASSWORD):
        return read_secret("tak.enrol_password_file", tak.enrol_password_file, PASSWORD, os.environ)
    answer: str = typer.prompt(f"Password of {tak.enrol_user}", hide_input=True)
    return answer


def _write(path: Path, content: bytes) -> None:
    """Write a file that only its owner can read, whole or not at all."""
    try:
        descriptor, name = tempfile.mkstemp(dir=path.absolute().parent, prefix=f".{path.name}.")  # readable by us only
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise ConfigurationError(f"Cannot write {path}: {error.strerror or error}.") from error
