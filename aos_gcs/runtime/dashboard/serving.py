"""The dashboard of a mission: the application by its configuration, and a server around it."""

from __future__ import annotations

import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from aos_gcs.api.app import create_app
from aos_gcs.api.basemap_file import MISSION_BASEMAP, check_basemap
from aos_gcs.api.server import serve, serve_on
from aos_gcs.api.tls import server_context
from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.config.model import ApiConfig
from aos_gcs.handover.model import HandoverControl
from aos_gcs.mission.control import FindingCommands, MissionView, ReplayControl
from aos_gcs.mission.viewing import OperationView, SortieChoice, ViewControl
from aos_gcs.planning.settings import TerrainSettings
from aos_gcs.runtime.encryption import tls_files
from aos_gcs.runtime.sign_in import OperatorSecrets, announce
from aos_gcs.wall.board import Wall
from aos_gcs.wall.video import VideoControl


@asynccontextmanager
async def serve_flight(
    listener: socket.socket,
    mission: MissionMirror,
    config: ApiConfig,
    operators: OperatorSecrets,
    *,
    viewer: ViewControl,
    handovers: HandoverControl,
    operation: OperationView,
    wall: Wall,
    videos: VideoControl,
    folder: Path,
) -> AsyncIterator[None]:
    """Serve the dashboard of a mission in another process for as long as the context is entered.

    Args:
        listener: socket that listens for clients.
        mission: mission to show and to command.
        config: files of the dashboard.
        operators: code by which operators sign in, and who has.
        viewer: views of recorded frames.
        handovers: hand-overs of the record.
        operation: sorties of its operation.
        wall: live pictures of its cameras.
        videos: videos of them.
        folder: mission folder.
    """
    app = create_app(
        mission,
        operator_code=operators.code,
        operator_file=operators.file,
        accounts=operators.accounts,
        anyone_observes=config.anyone_observes,
        allowed_hosts=config.allowed_hosts,
        trusted_proxies=config.trusted_proxies,
        commands=mission,
        viewer=viewer,
        handovers=handovers,
        operation=operation,
        plans_folder=config.plans_folder,
        basemap_file=config.basemap or folder / MISSION_BASEMAP,
        wall=wall,
        videos=videos,
        upstream=mission,
    )
    files = tls_files(config)
    async with serve_on(app, listener, None if files is None else server_context(files)):
        yield


@asynccontextmanager
async def open_dashboard(
    mission: MissionView,
    config: ApiConfig,
    operators: OperatorSecrets,
    *,
    findings: FindingCommands | None = None,
    replay: ReplayControl | None = None,
    viewer: ViewControl | None = None,
    handovers: HandoverControl | None = None,
    operation: OperationView | None = None,
    sortie_choice: SortieChoice | None = None,
    terrain: TerrainSettings | None = None,
    wall: Wall | None = None,
    videos: VideoControl | None = None,
    folder: Path | None = None,
) -> AsyncIterator[None]:
    """Serve the dashboard of a mission that is only shown, for as long as the context is entered.

    Args:
        mission: mission to show.
        config: address and files of the dashboard.
        operators: code by which operators sign in.
        findings: decisions about the findings of a survey; None for missions.
        replay: control of the replay.
        viewer: views of recorded frames.
        handovers: hand-overs of the record.
        operation: sorties of the mission's operation; None for surveys.
        sortie_choice: choice of the sortie that is replayed.
        terrain: elevation model of the mission.
        wall: pictures of its cameras at the time of the replay; None for surveys.
        videos: videos of them; None for surveys.
        folder: mission folder, whose base map is shown where the configuration names none.

    Raises:
        LinkError: its port cannot be opened.
        ConfigurationError: its base map cannot be shown.
    """
    if config.basemap is not None:
        check_basemap(config.basemap)
    app = create_app(
        mission,
        operator_code=operators.code,
        operator_file=operators.file,
        accounts=operators.accounts,
        anyone_observes=config.anyone_observes,
        findings=findings,
        replay=replay,
        viewer=viewer,
        handovers=handovers,
        operation=operation,
        sortie_choice=sortie_choice,
        plans_folder=config.plans_folder,
        basemap_file=config.basemap or (None if folder is None else folder / MISSION_BASEMAP),
        terrain=terrain,
        wall=wall,
        videos=videos,
    )
    async with serve(app, config.host, config.port) as address:
        announce(address, config, operators.code)
        yield
