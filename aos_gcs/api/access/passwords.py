"""Passwords of accounts: what they have to be, and their digests by Argon2id."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra

MIN_LENGTH: Final = 10
MAX_LENGTH: Final = 200
_PURPOSE: Final = "Accounts"
_EXTRA: Final = "team"


def check_password(password: str, name: str = "") -> None:
    """Refuse a password that is too short, or the name of its account.

    Raises:
        InputDataError: with the reason.
    """
    if not MIN_LENGTH <= len(password) <= MAX_LENGTH:
        raise InputDataError(f"password: between {MIN_LENGTH} and {MAX_LENGTH} characters; several words are best.")
    if len(set(password)) < 4 or password.casefold() == name.casefold():
        raise InputDataError("password: too easy to guess; several words are best.")


def hash_password(password: str) -> str:
    """Return what is written down in the place of a password; takes a tenth of a second and 64 MiB.

    Raises:
        ConfigurationError: the library is missing.
    """
    digest: str = _hasher().hash(password)
    return digest


def is_password(digest: str | None, password: str) -> bool:
    """Return whether a password is the one behind a digest; for None false, after the same time."""
    errors = load_extra("argon2.exceptions", _EXTRA, _PURPOSE)
    try:
        _hasher().verify(_nobodys() if digest is None else digest, password)
    except (errors.VerificationError, errors.InvalidHashError):
        return False
    return digest is not None


@cache
def _hasher() -> Any:
    # The library's own parameters are those of RFC 9106 for machines with little memory.
    return load_extra("argon2", _EXTRA, _PURPOSE).PasswordHasher()


@cache
def _nobodys() -> str:
    """Return the digest that passwords for unknown names are compared with, so that they take as long as others."""
    return hash_password("the password of nobody")
