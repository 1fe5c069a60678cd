"""``aos-gcs sharing``: what live sharing would send of a recorded mission."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import ConfigurationError, InputDataError


def sharing(
    config: Annotated[Path, typer.Argument(help="TOML file with the receivers.", dir_okay=False)],
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
) -> None:
    """Print what live sharing would send of a recorded mission's last state, and send nothing.

    Each line is one message. Secrets are neither needed nor printed.
    """
    from aos_gcs.clock import machine_utc_s  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.config.file import read_config  # noqa: PLC0415
    from aos_gcs.config.settings import sharing_settings  # noqa: PLC0415
    from aos_gcs.sharing.preview import preview  # noqa: PLC0415
    from aos_gcs.store.reader import MissionReader  # noqa: PLC0415

    settings = sharing_settings(read_config(config))
    if not settings.any:
        raise ConfigurationError(f"{config} names no receiver: give it a section [tak], [caltopo] or [webhook].")
    with MissionReader(mission_dir) as reader:
        snapshot = reader.last_snapshot()
    if snapshot is None:
        raise InputDataError(f"{mission_dir} holds no state of its mission.")
    for message in preview(settings, snapshot, machine_utc_s()):
        typer.echo(message)
