"""``aos-gcs accounts``: the people who sign in at a command post."""

from __future__ import annotations

import ipaddress
from enum import StrEnum
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

import typer

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.roles import Role
from aos_gcs.clock import machine_utc_s
from aos_gcs.errors import InputDataError

accounts = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    help="Manage the accounts of a command post: who may observe, judge findings, fly, or administer.",
)

File = Annotated[
    Path, typer.Argument(help="File of accounts, named as api.accounts in the configuration.", dir_okay=False)
]
Name = Annotated[str, typer.Argument(help="Name of the person, as it stands in the audit log.")]


class GivenRole(StrEnum):
    """Role that an account can have."""

    OBSERVER = "observer"
    ANALYST = "analyst"
    OPERATOR = "operator"
    ADMINISTRATOR = "administrator"


RoleOption = Annotated[
    GivenRole, typer.Option("--role", help="Role: see all; judge findings; fly; or manage accounts, too.")
]


@accounts.command("add")
def add(
    file: File,
    name: Name,
    role: RoleOption,
    *,
    password_file: Annotated[
        Path | None, typer.Option(help="File with the password, instead of typing it.", dir_okay=False)
    ] = None,
) -> None:
    """Add an account with a password; a running service knows it after a second."""
    account = AccountFile(file).add(name, Role(role), _password(password_file), machine_utc_s())
    typer.echo(f"{account.name}: {account.role}")


@accounts.command("invite")
def invite(
    file: File,
    role: RoleOption,
    *,
    url: Annotated[
        str,
        typer.Option(help="Address of the dashboard as the person reaches it, such as https://10.0.0.5:8080/."),
    ],
    hours: Annotated[float, typer.Option(help="Hours until the invitation expires.", min=0.1, max=24.0 * 30)] = 24.0,
) -> None:
    """Print a link by which one person makes an account. Send it through a private channel."""
    page = _page(url)
    _require_accounts(file)
    token = AccountFile(file).invite(Role(role), "the command line", machine_utc_s(), hours * 3600.0)
    typer.echo(f"{page}#invite={token}")


@accounts.command("list")
def list_accounts(file: File) -> None:
    """Print all accounts and their roles."""
    _require_accounts(file)
    found = AccountFile(file).all()
    for account in found:
        typer.echo(f"{account.role:14}{account.name}")
    if not found:
        typer.echo(f"{file} has no account yet.", err=True)


@accounts.command("remove")
def remove(file: File, name: Name) -> None:
    """Remove an account. A running service ends its sessions within a second."""
    _require_accounts(file)
    AccountFile(file).remove(name)


@accounts.command("role")
def role(file: File, name: Name, role: RoleOption) -> None:
    """Give an account another role. A running service applies it within a second."""
    _require_accounts(file)
    AccountFile(file).set_role(name, Role(role))


@accounts.command("password")
def password(
    file: File,
    name: Name,
    *,
    password_file: Annotated[
        Path | None, typer.Option(help="File with the password, instead of typing it.", dir_okay=False)
    ] = None,
) -> None:
    """Set another password for an account, such as a forgotten one. Its sessions end."""
    _require_accounts(file)
    AccountFile(file).set_password(name, _password(password_file))


def _require_accounts(file: Path) -> None:
    if not file.exists():
        remedy = f"add the first account with: aos-gcs accounts add {file} NAME --role administrator"
        raise InputDataError(f"{file} does not exist. Check the path, or {remedy}.")


def _page(url: str) -> str:
    """Return the address of the page, which is at the root of its server.

    Raises:
        InputDataError: no other machine can open it.
    """
    try:
        parts = urlsplit(url)
        is_page = parts.scheme in {"http", "https"} and parts.hostname and parts.port != 0
    except ValueError:
        is_page = False
    if not is_page or parts.path not in {"", "/"} or parts.query or parts.fragment or parts.username is not None:
        raise InputDataError(
            f"--url {url} is no address of the page: give http:// or https://, host and port, and nothing behind them, "
            "such as https://10.0.0.5:8080/."
        )
    if _is_own(parts.hostname or ""):
        raise InputDataError(
            f"--url {url} can be opened on this machine alone: give its name or address in the network."
        )
    return f"{parts.scheme}://{parts.netloc}/"


def _is_own(host: str) -> bool:
    """Whether an address is that of the machine itself, for whoever opens it, or of none."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host == "localhost" or host.endswith(".localhost")
    return address.is_loopback or address.is_unspecified


def _password(file: Path | None) -> str:
    """Return the password in a file, without the line's end, or what is typed twice.

    Raises:
        InputDataError: the file cannot be read.
    """
    if file is None:
        typed: str = typer.prompt("Password", hide_input=True, confirmation_prompt=True)
        return typed
    try:
        return file.read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        raise InputDataError(f"The password cannot be read from {file}: {error}.") from error
