"""``aos-gcs accounts``: the people who sign in at a command post."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.roles import Role
from aos_gcs.clock import machine_utc_s
from aos_gcs.errors import InputDataError

accounts = typer.Typer(
    no_args_is_help=True,
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
        str, typer.Option(help="Address of the dashboard as the person reaches it.")
    ] = "http://127.0.0.1:8080/",
    hours: Annotated[float, typer.Option(help="Hours until the invitation expires.", min=0.1, max=24.0 * 30)] = 24.0,
) -> None:
    """Print a link by which one person makes an account. Send it through a private channel."""
    token = AccountFile(file).invite(Role(role), "the command line", machine_utc_s(), hours * 3600.0)
    typer.echo(f"{url.rstrip('/')}/#invite={token}")


@accounts.command("list")
def list_accounts(file: File) -> None:
    """Print all accounts and their roles."""
    if not file.exists():
        remedy = f"add the first account with: aos-gcs accounts add {file} NAME --role administrator"
        raise InputDataError(f"{file} does not exist. Check the path, or {remedy}.")
    found = AccountFile(file).all()
    for account in found:
        typer.echo(f"{account.role:14}{account.name}")
    if not found:
        typer.echo(f"{file} has no account yet.", err=True)


@accounts.command("remove")
def remove(file: File, name: Name) -> None:
    """Remove an account. A running service ends its sessions within a second."""
    AccountFile(file).remove(name)


@accounts.command("role")
def role(file: File, name: Name, role: RoleOption) -> None:
    """Give an account another role. A running service applies it within a second."""
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
    AccountFile(file).set_password(name, _password(password_file))


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
