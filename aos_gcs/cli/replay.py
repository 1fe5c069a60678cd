"""``aos-gcs replay``: the dashboard on a recorded mission."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.cli.run import CODE_FILE_HELP, run_until_terminated

if TYPE_CHECKING:
    from aos_gcs.config.model import ApiConfig


def replay(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    *,
    host: Annotated[str, typer.Option(help="Network address on which the dashboard listens.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port of the dashboard.", min=0, max=65535)] = 8080,
    operator_code_file: Annotated[Path | None, typer.Option(help=CODE_FILE_HELP, dir_okay=False)] = None,
    verify: Annotated[
        bool,
        typer.Option(
            "--verify",
            help="Open no dashboard: compute every step again from the recorded frames and states, and compare masks, "
            "places, decisions and waypoints. Exit status 0: identical; 1: the first difference is printed.",
        ),
    ] = False,
) -> None:
    """Show a recorded mission on the dashboard, at any time of it, or verify its decisions.

    Operators control the playback for all clients; vehicles cannot be commanded. Ctrl-C ends it.
    """
    if verify:
        _verify(mission_dir)
        return
    from aos_gcs.config.file import dashboard_of  # noqa: PLC0415 - heavy, only for this command

    run_until_terminated(_show(mission_dir, dashboard_of(host, port, operator_code_file)))


def _verify(folder: Path) -> None:
    from aos_gcs.runtime.recorded.verification import verify_mission  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.store.reader import MissionReader  # noqa: PLC0415

    with MissionReader(folder) as reader:
        result = verify_mission(reader)
    if result.difference is not None:
        typer.echo(f"different: {result.difference}")
        raise typer.Exit(1)
    typer.echo(f"identical: {result.steps} steps computed again")


async def _show(folder: Path, config: ApiConfig) -> None:
    from aos_gcs.clock import LoopClock  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.runtime.dashboard.serving import open_dashboard  # noqa: PLC0415
    from aos_gcs.runtime.recorded.handover import HandoverPrinter  # noqa: PLC0415
    from aos_gcs.runtime.recorded.operation import ReplayedOperation  # noqa: PLC0415
    from aos_gcs.runtime.sign_in import operator_secrets  # noqa: PLC0415
    from aos_gcs.runtime.wall.live import make_wall  # noqa: PLC0415
    from aos_gcs.runtime.wall.video_maker import VideoMaker  # noqa: PLC0415

    secrets = operator_secrets(config)
    clock = LoopClock()
    with ReplayedOperation(folder, clock) as operation:
        shown = operation.replay
        viewer = await operation.viewer(shown.snapshot().mission_id)
        handovers = HandoverPrinter(lambda: operation.shown_folder, clock.utc_s)
        async with (
            open_dashboard(
                shown,
                config,
                secrets,
                replay=shown,
                viewer=viewer,
                operation=operation,
                sortie_choice=operation,
                handovers=handovers,
                terrain=operation.terrain,
                wall=make_wall(shown, lambda: operation.shown_folder, config, shown),
                videos=VideoMaker(lambda: operation.shown_folder, rest=0.0),
                folder=folder,
            ),
            asyncio.TaskGroup() as group,
        ):
            group.create_task(shown.run())
