"""The dashboard beside a mission: the addresses that operators and observers open."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.api.access.operator_file import FILE_NAME, OperatorFile
from aos_gcs.api.access.operators import random_code, read_code
from aos_gcs.api.app import create_app
from aos_gcs.api.basemap_file import check_basemap
from aos_gcs.api.server import serve
from aos_gcs.config.model import ApiConfig
from aos_gcs.mission.control import MissionCommands, MissionView, ReplayControl
from aos_gcs.mission.viewing import ViewControl

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class OperatorSecrets:
    """The code by which operators sign in, and the file that remembers who has."""

    code: str
    file: OperatorFile | None = None


def operator_secrets(config: ApiConfig, folder: Path | None = None) -> OperatorSecrets:
    """Return the code of the file that the configuration names, or else that of earlier starts, or a random one.

    Args:
        config: address and files of the dashboard.
        folder: folder in which code and sign-ins outlast a restart; None: neither does.

    Raises:
        ConfigurationError: the file of the code cannot be used.
    """
    given = None if config.operator_code_file is None else read_code(config.operator_code_file)
    if folder is None or not config.enabled:
        return OperatorSecrets(given or random_code())
    file = OperatorFile(folder / FILE_NAME)
    return OperatorSecrets(given or file.code(random_code()), file)


@asynccontextmanager
async def open_dashboard(
    mission: MissionView,
    config: ApiConfig,
    operators: OperatorSecrets,
    *,
    commands: MissionCommands | None = None,
    replay: ReplayControl | None = None,
    viewer: ViewControl | None = None,
) -> AsyncIterator[None]:
    """Serve the dashboard for as long as the context is entered, unless it is switched off.

    Args:
        mission: mission to show.
        config: address and files of the dashboard.
        operators: code by which operators sign in, and who has.
        commands: commands to the mission; None where it is only shown.
        replay: control of the replay; None for a mission in flight.
        viewer: views of recorded frames.

    Raises:
        LinkError: its port cannot be opened.
        ConfigurationError: its base map cannot be shown.
    """
    if not config.enabled:
        yield
        return
    if config.basemap is not None:
        check_basemap(config.basemap)
    app = create_app(
        mission,
        operator_code=operators.code,
        operator_file=operators.file,
        commands=commands,
        replay=replay,
        viewer=viewer,
        plans_folder=config.plans_folder,
        basemap_file=config.basemap,
    )
    async with serve(app, config.host, config.port) as address:
        _log.info("Dashboard for observers: %s", address.url)
        if config.operator_code_file is None:
            # Behind the #, it is sent to no server and stands in no log of requests.
            _log.info("Dashboard for operators: %s#code=%s", address.url, operators.code)
        else:
            _log.info("Operators sign in there with the code in %s.", config.operator_code_file)
        yield
