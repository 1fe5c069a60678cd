"""The command line ``aos-gcs``.

A command is a function with typer annotations in a module of its own; its docstring is its help. Built-in commands
stand in :data:`BUILT_IN`, others come from the entry-point group ``aos_gcs.commands``. A command's module is imported
only when that command (or the overview of all) is asked for, and should import what is heavy inside the function.

Commands raise :class:`aos_gcs.errors.AosError` for everything the user can act on; :func:`main` maps it, once, to a
sentence on standard error and exit code 2. ``typer.Exit(code)`` ends a command with another code.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from aos_gcs.cli.output import LogLevel, configure_logging
from aos_gcs.cli.registry import group_class
from aos_gcs.errors import AosError, InputDataError
from aos_gcs.input_values import printable
from aos_gcs.process import use_one_blas_thread

BUILT_IN: dict[str, str] = {
    "demo": "aos_gcs.cli.demo:demo",
    "run": "aos_gcs.cli.run:run",
    "restore": "aos_gcs.cli.restore:restore",
    "integrate": "aos_gcs.cli.integrate:integrate",
    "extract": "aos_gcs.cli.extract:extract",
    "calibrate": "aos_gcs.cli.calibrate:calibrate",
    "terrain": "aos_gcs.cli.terrain:terrain",
    "basemap": "aos_gcs.cli.basemap:basemap",
    "plan-aperture": "aos_gcs.cli.plan_aperture:plan_aperture",
    "inspect": "aos_gcs.cli.inspect:inspect",
    "replay": "aos_gcs.cli.replay:replay",
    "report": "aos_gcs.cli.report:report",
    "sharing": "aos_gcs.cli.sharing:sharing",
    "tak-enrol": "aos_gcs.cli.tak_enrol:tak_enrol",
    "accounts": "aos_gcs.cli.accounts:accounts",
    "export": "aos_gcs.cli.export:export",
    "searched": "aos_gcs.cli.searched:searched",
    "survey": "aos_gcs.cli.survey:survey",
    "lab": "aos_gcs.cli.lab.commands:lab",
}
"""Command name to ``module:function``, in the order in which the help lists them."""

NEWLINE = "\n"
EXIT_USER_ERROR = 2
EXIT_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave the interpreter with its exit code.

    Args:
        arguments: without the program's name; ``sys.argv[1:]`` if None.

    Raises:
        SystemExit: always; 0 for success, 2 for errors of the user, 130 after Ctrl-C.
    """
    use_one_blas_thread()
    try:
        typer.main.get_command(_app())(arguments, prog_name="aos-gcs")
    except AosError as error:
        _exit_with([error])
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        # Wherever a path that was given is looked at first; shown is its beginning.
        _exit_with([InputDataError(f"The path {str(error.filename)[:40]}… is too long: give another name.")])
    except BaseExceptionGroup as group:
        # Task groups wrap what their tasks raise; anything that is no AosError is a defect and keeps its traceback.
        known, unknown = group.split(AosError)
        if known is None or unknown is not None:
            raise
        _exit_with(_leaves(known))
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)


def _app() -> typer.Typer:
    app = typer.Typer(
        cls=group_class(BUILT_IN),
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_common_options)
    return app


def _print_version(requested: bool) -> None:
    if requested:
        # Reading the distribution's metadata costs milliseconds that only this option should pay.
        from importlib.metadata import version  # noqa: PLC0415

        typer.echo(f"aos-gcs {version('aos-gcs')}")
        raise typer.Exit


def _common_options(
    log_level: Annotated[
        LogLevel, typer.Option(help="How much the program reports on standard error.", case_sensitive=False)
    ] = LogLevel.INFO,
    version: Annotated[  # noqa: ARG001 - handled by its callback
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Ground control for camera-drone swarms that see through forest canopy and find people."""
    configure_logging(log_level)


def _leaves(group: BaseExceptionGroup[AosError]) -> list[AosError]:
    leaves: list[AosError] = []
    for error in group.exceptions:
        leaves.extend(_leaves(error) if isinstance(error, BaseExceptionGroup) else [error])
    return leaves


def _exit_with(errors: Sequence[AosError]) -> None:
    for text in dict.fromkeys(str(error) for error in errors):
        typer.echo(f"aos-gcs: {printable(text, keep=NEWLINE)}", err=True)
    sys.exit(EXIT_USER_ERROR)
