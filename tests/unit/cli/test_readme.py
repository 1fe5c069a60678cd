"""README.md against the program: every command and every extra is there, and none that does not exist."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import typer

from aos_gcs.cli import BUILT_IN, group_class
from aos_gcs.cli.accounts import accounts
from aos_gcs.cli.lab.commands import lab
from aos_gcs.cli.terrain import terrain

ROOT = Path(__file__).resolve().parents[3]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_command_has_a_row() -> None:
    rows = re.findall(r"^\| `aos-gcs ([a-z-]+)", README, re.MULTILINE)
    assert set(rows) == set(group_class(BUILT_IN)().list_commands(None))


@pytest.mark.parametrize(("name", "group"), [("accounts", accounts), ("lab", lab), ("terrain", terrain)])
def test_every_command_of_a_group_is_on_some_page(name: str, group: typer.Typer) -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").rglob("*.md"))
    commands: Any = typer.main.get_command(group)
    assert [one for one in commands.commands if not re.search(rf"{name} {one}\b|`{one}`", text)] == []


def test_every_extra_is_named() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    sentence = README.partition("; the extras are ")[2].partition(". Frames may")[0]
    assert set(re.findall(r"`(\w+)`", sentence)) == set(extras)
