"""``aos-gcs accounts``: the file that is named is the one that is managed, and a missing one is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fakes.command_line import exit_status

PASSWORD = "larch and spruce"  # noqa: S105 - of the tests


def run(*arguments: str) -> object:
    return exit_status(["accounts", *arguments])


def test_accounts_are_listed_with_their_roles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, password = str(tmp_path / "accounts.json"), tmp_path / "password"
    password.write_text(f"{PASSWORD}\n", encoding="utf-8")
    assert run("add", file, "Ada", "--role", "administrator", "--password-file", str(password)) == 0
    assert run("list", file) == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == ["administrator", "Ada"]
    assert run("remove", file, "Ada") == 0
    assert run("list", file) == 0
    assert "has no account yet" in capsys.readouterr().err


def test_a_file_that_does_not_exist_is_no_empty_list(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "acounts.json"
    assert run("list", str(missing)) == 2
    error = capsys.readouterr().err
    assert f"{missing} does not exist. Check the path, or add the first account with: aos-gcs accounts add" in error
    assert not missing.exists()
