import logging
import sys
import types
from collections.abc import Iterator
from importlib.metadata import EntryPoint, version
from pathlib import Path
from typing import Any

import pytest
import typer
from rich.text import Text

from aos_gcs import cli
from aos_gcs.cli import main, registry
from aos_gcs.errors import ConfigurationError, ImagingError, LinkError
from tests.fakes.command_line import exit_status


def offer(monkeypatch: pytest.MonkeyPatch, **commands: object) -> None:
    """Install plug-in commands that come from a module of their own."""
    module = types.ModuleType("aos_plug_in_under_test")
    points = []
    for name, command in commands.items():
        if command is not None:
            setattr(module, name, command)
        points.append(EntryPoint(name, f"{module.__name__}:{name}", registry.ENTRY_POINT_GROUP))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(registry, "entry_points", lambda group: points if group == registry.ENTRY_POINT_GROUP else [])


def run(*arguments: str) -> int:
    return exit_status(arguments)


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--version") == 0
    assert capsys.readouterr().out == f"aos-gcs {version('aos-gcs')}\n"


def test_help_lists_built_in_and_plug_in_commands(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def hover() -> None:
        """Stay where you are."""

    offer(monkeypatch, hover=hover)
    assert run("--help") == 0
    help_text = capsys.readouterr().out
    assert "integrate" in help_text
    assert "Stay where you are." in help_text


def commands_of(command: Any, name: str) -> Iterator[tuple[str, Any]]:
    """A command and all below it, with their names."""
    yield name, command
    for below in getattr(command, "commands", {}):
        yield from commands_of(command.commands[below], f"{name} {below}")


def test_help_texts_are_shown_as_they_are_written() -> None:
    """Words in square brackets would be taken for markup and left out."""
    commands = list(commands_of(typer.main.get_command(cli._app()), "aos-gcs"))
    assert len(commands) > 15
    left_out = [
        f"{name}: {text}"
        for name, command in commands
        for text in (command.help, *(getattr(parameter, "help", None) for parameter in command.params))
        if text and Text.from_markup(text).plain != text
    ]
    assert left_out == []


def test_only_the_command_that_is_called_is_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded: list[str] = []
    load = EntryPoint.load

    def recording_load(point: EntryPoint) -> object:
        loaded.append(point.name)
        return load(point)

    monkeypatch.setattr(EntryPoint, "load", recording_load)
    offer(monkeypatch, hover=lambda: None, broken=None)
    assert run("hover") == 0
    assert loaded == ["hover"]


def test_commands_may_be_typer_applications(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    app = typer.Typer()

    @app.command()
    def high() -> None:
        typer.echo("flying high")

    @app.command()
    def low() -> None:
        typer.echo("flying low")

    offer(monkeypatch, fly=app)
    assert run("fly", "low") == 0
    assert capsys.readouterr().out == "flying low\n"
    assert run("--help") == 0
    assert " fly " in capsys.readouterr().out


def test_a_broken_plug_in_says_so_and_leaves_the_others_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    offer(monkeypatch, broken=None, hover=lambda: typer.echo("hovering"))
    assert run("hover") == 0
    assert run("--help") == 0
    assert "Unavailable" in capsys.readouterr().out
    for arguments in (["broken"], ["broken", "--vehicles", "3"], ["broken", "--help"]):
        assert run(*arguments) == 2
        text = capsys.readouterr().err
        assert text.startswith("aos-gcs: The command 'broken' is unavailable")
        assert "AttributeError" in text


def test_a_plug_in_cannot_replace_a_built_in_command(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, integrate=lambda: typer.Exit(7))
    assert run("integrate", "--help") == 0
    assert run("integrate") == 2


def test_errors_for_the_user_are_one_sentence_and_exit_code_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail() -> None:
        raise ConfigurationError("The port 8080 is in use; choose another with --port.")

    offer(monkeypatch, fail=fail)
    assert run("fail") == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == "aos-gcs: The port 8080 is in use; choose another with --port.\n"


def test_errors_from_task_groups_are_unwrapped(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail() -> None:
        nested = ExceptionGroup("inner", [LinkError("No link."), LinkError("No link.")])
        raise ExceptionGroup("outer", [nested, ImagingError("No ground.")])

    offer(monkeypatch, fail=fail)
    assert run("fail") == 2
    assert capsys.readouterr().err == "aos-gcs: No link.\naos-gcs: No ground.\n"


def test_defects_keep_their_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(grouped: bool = False) -> None:
        raise ExceptionGroup("mixed", [LinkError("x"), KeyError("y")]) if grouped else KeyError("y")

    offer(monkeypatch, fail=fail)
    with pytest.raises(KeyError):
        main(["fail"])
    with pytest.raises(ExceptionGroup):
        main(["fail", "--grouped"])


def test_an_interruption_exits_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def wait() -> None:
        raise KeyboardInterrupt

    offer(monkeypatch, wait=wait)
    assert run("wait") == 130


def test_a_command_may_choose_its_exit_code(monkeypatch: pytest.MonkeyPatch) -> None:
    def lose() -> None:
        raise typer.Exit(1)

    offer(monkeypatch, lose=lose)
    assert run("lose") == 1


def test_an_unknown_command_is_refused_with_a_suggestion(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("integrat") == 2
    assert "integrate" in capsys.readouterr().err


def test_the_log_level_is_applied(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def chat() -> None:
        logging.getLogger("aos").debug("a detail")
        logging.getLogger("aos").warning("a warning")

    offer(monkeypatch, chat=chat)
    assert run("--log-level", "warning", "chat") == 0
    text = capsys.readouterr().err
    assert "WARNING aos: a warning" in text
    assert "a detail" not in text
    assert run("--log-level", "debug", "chat") == 0
    assert "a detail" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("replay", "folder", "--port", "70000"), "'--port': it must be at most 65535"),
        (("replay", "folder", "--port", "many"), "'--port': it must be a whole number"),
        (("lab", "calibrate", "--worlds", "1"), "'--worlds': it must be at least 2"),
        (("report", "folder", "--notation", "polar"), "'--notation': 'polar' is not one of 'decimal', 'dms'"),
    ],
)
def test_values_of_options_are_refused_in_plain_words(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], words: str
) -> None:
    assert run(*arguments) == 2
    assert words in " ".join(capsys.readouterr().err.replace("│", " ").split())


def test_completion_is_installed_for_the_program_alone() -> None:
    commands = dict(commands_of(typer.main.get_command(cli._app()), "aos-gcs"))
    params = [(name, param.name) for name, one in commands.items() for param in one.params]
    offering = [name for name, param in params if param == "install_completion"]
    assert offering == ["aos-gcs"]


@pytest.mark.parametrize("command", ["replay", "survey"])
def test_an_empty_address_of_the_dashboard_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    assert run(command, str(tmp_path), "--host", " ") == 2
    assert capsys.readouterr().err.startswith('aos-gcs: --host: give an address such as "127.0.0.1"')


def test_a_survey_without_a_dashboard_needs_no_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("survey", str(tmp_path), "--headless", "--operator-code-file", "code") == 2
    assert "--headless shows no dashboard: leave --operator-code-file out." in capsys.readouterr().err


@pytest.mark.parametrize(
    "command", [("inspect",), ("survey",), ("accounts", "list"), ("integrate", "--ortho", "1", "--out", "map.npy")]
)
def test_a_path_that_is_too_long_is_told(capsys: pytest.CaptureFixture[str], command: tuple[str, ...]) -> None:
    assert run(*command, "x" * 5000) == 2
    assert capsys.readouterr().err == f"aos-gcs: The path {'x' * 40}… is too long: give another name.\n"
