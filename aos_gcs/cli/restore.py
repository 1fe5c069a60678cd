"""The command ``aos-gcs restore``: set back what a killed mission has left on its vehicles."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

import typer

_EXIT_NOT_ALL = 1


def restore(
    config: Annotated[Path, typer.Argument(help="The mission's TOML file: links and folder of the records.")],
    wait: Annotated[float, typer.Option(min=1.0, max=600.0, help="Time to wait for the vehicles in seconds.")] = 30.0,
) -> None:
    """Set failsafe return heights back that a killed mission has left changed. Exit code 1: not on all vehicles.

    By the records, and only on vehicles whose motors stand still. Not for use while a mission flies: a port that it
    listens on is refused, but not a connection to a vehicle (tcpout, serial).
    """
    from aos_gcs.config.file import read_config  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.runtime.restoring import restore_return_settings  # noqa: PLC0415

    restorations = asyncio.run(restore_return_settings(read_config(config), wait))
    if not restorations:
        typer.echo("No mission has left return heights changed.")
    for one in restorations:
        values = ", ".join(f"{name} = {value:g}" for name, value in one.former.items())
        result = f"not restored: {one.problem}. Set by hand: {values}" if one.problem else f"restored: {values}"
        typer.echo(f"Vehicle {one.vehicle_id}: {result}")
    if any(one.problem for one in restorations):
        raise typer.Exit(_EXIT_NOT_ALL)
