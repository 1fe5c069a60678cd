"""The command ``aos-gcs run``: the service for the connections of a configuration file."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Coroutine
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol, TypeVar

import typer

from aos_gcs.background_log import background_log
from aos_gcs.errors import ConfigurationError

if TYPE_CHECKING:
    from aos_gcs.config.model import ServiceConfig
    from aos_gcs.mission.model.phase import Outcome
    from aos_gcs.mission.next_sortie import NextSortie

T = TypeVar("T")


class Staying(Protocol):
    """A mission whose dashboard can stay available."""

    async def stay(self) -> NextSortie | None:
        """Keep the dashboard available until an operator asks for a new sortie."""
        ...


EXIT_FAILED = 1
CODE_FILE_HELP = "File with the operator code for the dashboard, instead of a random code."
EXIT_TERMINATED = 128 + signal.SIGTERM


def run(
    config: Annotated[Path, typer.Argument(help="TOML file; docs/configuration.md describes it.", dir_okay=False)],
    *,
    port: Annotated[
        int | None, typer.Option(help="Port of the dashboard; overrides the configuration file.", min=0, max=65535)
    ] = None,
    operator_code_file: Annotated[Path | None, typer.Option(help=CODE_FILE_HELP, dir_okay=False)] = None,
    tls_cert: Annotated[
        Path | None, typer.Option(help="Certificate (PEM) by which the dashboard is encrypted.", dir_okay=False)
    ] = None,
    tls_key: Annotated[
        Path | None, typer.Option(help="Key of the certificate (PEM); by default in the same file.", dir_okay=False)
    ] = None,
    tls: Annotated[
        bool, typer.Option("--tls", help="Encrypt the dashboard with a certificate of the station's own.")
    ] = False,
    open_browser: Annotated[
        bool, typer.Option("--open", help="Open the dashboard in this machine's browser, for operators.")
    ] = False,
    headless: Annotated[bool, typer.Option("--headless", help="Run without the dashboard.")] = False,
    exit_when_done: Annotated[
        bool,
        typer.Option("--exit-when-done", help="Exit when the mission ends instead of keeping the dashboard available."),
    ] = False,
    continued: Annotated[
        Path | None,
        typer.Option(
            "--continue",
            metavar="DIR",
            help="Folder of a mission over the same area: its map of searched ground and its findings go on.",
            file_okay=False,
        ),
    ] = None,
    plan: Annotated[bool, typer.Option("--plan", help="Print advice on the aperture and exit.")] = False,
) -> None:
    """Fly a mission with the vehicles of a configuration file.

    The operator starts it on the dashboard, unless the file says auto_start. Ctrl-C sends flying vehicles home and
    ends the service; their own link-loss failsafe takes over if that message gets lost.
    """
    from aos_gcs.config.file import read_config  # noqa: PLC0415 - heavy, only for this command

    service = read_config(config)
    if plan:
        _show_plan(service)
        return
    if tls and tls_cert is not None:
        raise ConfigurationError("--tls makes a certificate, and --tls-cert names one: give one of them.")
    of_dashboard = {
        "--port": port is not None,
        "--operator-code-file": operator_code_file is not None,
        "--tls": tls,
        "--tls-cert": tls_cert is not None,
        "--open": open_browser,
    }
    for option, is_given in of_dashboard.items():
        if headless and is_given:
            raise ConfigurationError(f"--headless runs without the dashboard: leave {option} out, or --headless.")
    if port is not None:
        service.api.port = port
    if operator_code_file is not None:
        service.api.operator_code_file = operator_code_file
    if tls_key is not None and tls_cert is None:
        raise ConfigurationError("--tls-key needs --tls-cert.")
    if tls_cert is not None:
        service.api.tls_cert, service.api.tls_key = tls_cert, tls_key
    service.api.tls = service.api.tls or tls
    service.api.open_browser = service.api.open_browser or open_browser
    if headless:
        service.api.enabled = False
    if not (service.api.enabled or service.mission.auto_start):
        raise ConfigurationError("Without the dashboard nobody starts the mission: set mission.auto_start to true.")
    stay = service.api.enabled and not exit_when_done
    if not run_until_terminated(_fly(service, _beginning(service, continued), stay=stay)):
        raise typer.Exit(EXIT_FAILED)


def _beginning(config: ServiceConfig, continued: Path | None) -> NextSortie | None:
    from aos_gcs.runtime.continuing import continued_sortie  # noqa: PLC0415 - heavy, only for this command

    return None if continued is None else continued_sortie(config, continued)


def _show_plan(config: ServiceConfig) -> None:
    from aos_gcs.config.settings import mission_settings  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.planning.detection.aperture import advise  # noqa: PLC0415

    settings = mission_settings(config)
    if settings.forest is None:
        raise ConfigurationError("--plan needs the section [forest] in the configuration; see docs/configuration.md.")
    advice = advise(settings, settings.forest)
    typer.echo(advice.text)
    for reason in advice.plan.reasons:
        typer.echo(f"- {reason}")


async def _fly(config: ServiceConfig, beginning: NextSortie | None, *, stay: bool) -> bool:
    """Fly one sortie after another, and return whether the last one neither failed nor was aborted."""
    from aos_gcs.mission.model.phase import Outcome  # noqa: PLC0415 - heavy, only for this command

    outcome, following = await _fly_sortie(config, beginning, stay=stay)
    while following is not None:
        config.api.open_browser = False  # its page goes on with the next sortie
        outcome, following = await _fly_sortie(config, following, stay=stay)
    return outcome not in {Outcome.FAILED, Outcome.ABORTED}


async def _fly_sortie(
    config: ServiceConfig, following: NextSortie | None, *, stay: bool
) -> tuple[Outcome, NextSortie | None]:
    """Run a mission, print its result, and return how it has ended, and what the next one begins with, if any."""
    from aos_gcs.cli.display.live import followed  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.runtime.service import open_service  # noqa: PLC0415

    following_it = None
    async with open_service(config, following) as service:
        async with followed(service.mission.view):
            snapshot = await service.run()
        # A terminal that stands still must not stop the heartbeat.
        await asyncio.to_thread(typer.echo, f"{snapshot.outcome}: {snapshot.message} Recorded in {service.folder}.")
        if stay:
            following_it = await stay_up(service)
        elif service.mission.may_any_fly:
            text = "A vehicle still flies, or may. The heartbeat goes on until it has landed, or Ctrl-C."
            await asyncio.to_thread(typer.echo, text, err=True)
            await service.stay(until_landed=True)
    return snapshot.outcome, following_it


async def stay_up(mission: Staying) -> NextSortie | None:
    """Keep the dashboard available until an operator asks for a new sortie there, and return what it begins with."""
    text = "The mission has ended. The dashboard stays available, for a new sortie, too, until Ctrl-C."
    await asyncio.to_thread(typer.echo, text, err=True)
    return await mission.stay()


def run_until_terminated(main: Coroutine[Any, Any, T]) -> T:
    """Run a coroutine; SIGTERM cancels it just as Ctrl-C does, so that it can bring its vehicles home.

    Raises:
        typer.Exit: it was cancelled by SIGTERM.
    """

    async def guarded() -> T:
        task = asyncio.ensure_future(main)
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, task.cancel)
        return await task

    try:
        with background_log():
            return asyncio.run(guarded())
    except asyncio.CancelledError:
        raise typer.Exit(EXIT_TERMINATED) from None
