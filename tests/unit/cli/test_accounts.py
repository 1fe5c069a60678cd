"""``aos-gcs accounts``: the file that is named is the one that is managed, and a missing one is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.clock import machine_utc_s
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


@pytest.fixture
def file(tmp_path: Path) -> Path:
    password = tmp_path / "password"
    password.write_text(f"{PASSWORD}\n", encoding="utf-8")
    assert run("add", str(tmp_path / "a.json"), "Ada", "--role", "operator", "--password-file", str(password)) == 0
    return tmp_path / "a.json"


@pytest.mark.parametrize(
    ("url", "page"),
    [
        ("https://10.0.0.5:8080/", "https://10.0.0.5:8080/"),
        ("http://station.local", "http://station.local/"),
        ("https://[fd00::5]:8080", "https://[fd00::5]:8080/"),
    ],
)
def test_an_invitation_is_a_link_that_others_open(
    file: Path, capsys: pytest.CaptureFixture[str], url: str, page: str
) -> None:
    capsys.readouterr()
    assert run("invite", str(file), "--role", "analyst", "--url", url) == 0
    link, token = capsys.readouterr().out.strip().split("#invite=")
    assert link == page
    assert AccountFile(file).accept(token, "Anders", PASSWORD, machine_utc_s()).name == "Anders"


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("10.0.0.5:8080", "is no address of the page"),
        ("ftp://10.0.0.5/", "is no address of the page"),
        ("https://", "is no address of the page"),
        ("https://10.0.0.5:808080/", "is no address of the page"),
        ("https://10.0.0.5/aos", "is no address of the page"),
        ("https://10.0.0.5/#plan", "is no address of the page"),
        ("http://127.0.0.1:8080/", "on this machine alone"),
        ("http://localhost:8080/", "on this machine alone"),
        ("http://0.0.0.0:8080/", "on this machine alone"),
        ("http://[::1]:8080/", "on this machine alone"),
    ],
)
def test_an_invitation_that_nobody_could_open_is_refused(
    file: Path, capsys: pytest.CaptureFixture[str], url: str, reason: str
) -> None:
    before = file.read_bytes()
    assert run("invite", str(file), "--role", "analyst", "--url", url) == 2
    assert reason in capsys.readouterr().err
    assert file.read_bytes() == before


def test_an_invitation_needs_the_page_and_a_file_of_accounts(
    tmp_path: Path, file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("invite", str(file), "--role", "analyst") == 2
    assert "--url" in capsys.readouterr().err
    assert run("invite", str(tmp_path / "b.json"), "--role", "analyst", "--url", "https://10.0.0.5/") == 2
    assert "does not exist" in capsys.readouterr().err
    assert not (tmp_path / "b.json").exists()


@pytest.mark.parametrize("command", [("remove",), ("role", "--role", "analyst"), ("password", "--password-file", "p")])
def test_accounts_of_a_file_that_does_not_exist_cannot_be_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    missing = tmp_path / "acounts.json"
    assert run(command[0], str(missing), "Ada", *command[1:]) == 2
    assert f"{missing} does not exist. Check the path" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
