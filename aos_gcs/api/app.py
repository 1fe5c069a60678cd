"""The application: routes, errors, protection and the dashboard around one mission."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Collection, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from fastapi import FastAPI

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.body_limit import BodyLimitMiddleware
from aos_gcs.api.access.desk import AccountDesk
from aos_gcs.api.access.operator_file import OperatorFile
from aos_gcs.api.access.operators import Access
from aos_gcs.api.access.peer_limits import PeerLimitMiddleware, PeerLimits
from aos_gcs.api.access.plan_check_turns import PlanChecks
from aos_gcs.api.access.proxies import ProxyMiddleware, TrustedProxies
from aos_gcs.api.access.request_checks import RolesMiddleware, SameOriginMiddleware, SecurityHeadersMiddleware
from aos_gcs.api.access.sign_in_log import SignInLog
from aos_gcs.api.control_desk import ControlDesk
from aos_gcs.api.convert.wall import WallMessages
from aos_gcs.api.errors import add_error_handlers
from aos_gcs.api.events.hub import EventHub, Upstream, loop_time_s
from aos_gcs.api.models.service import CapabilitiesModel
from aos_gcs.api.once import Once
from aos_gcs.api.openapi import add_routes, make_document
from aos_gcs.api.page import add_page
from aos_gcs.api.relief_maps import ReliefMaps
from aos_gcs.api.routers.plans import IMPORT_PATH
from aos_gcs.clock import machine_utc_s
from aos_gcs.handover.model import HandoverControl
from aos_gcs.mission.control import FindingCommands, MissionCommands, MissionView, ReplayControl
from aos_gcs.mission.viewing import OperationView, SortieChoice, ViewControl
from aos_gcs.planning.settings import TerrainSettings
from aos_gcs.store.plan_folder import PlanFolder
from aos_gcs.wall.board import Wall
from aos_gcs.wall.video import VideoControl


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    async with asyncio.TaskGroup() as group:
        tasks = [group.create_task(app.state.hub.run())]
        if app.state.wall is not None:
            tasks.append(group.create_task(app.state.wall.run()))
        if app.state.videos is not None:
            tasks.append(group.create_task(app.state.videos.run()))
        if app.state.desk is not None:
            tasks.append(group.create_task(app.state.desk.sessions.follow()))
        yield
        for task in tasks:
            task.cancel()


def create_app(
    mission: MissionView,
    static_folder: Path | None = None,
    *,
    allowed_hosts: Collection[str] = (),
    trusted_proxies: Sequence[str] = (),
    operator_code: str | None = None,
    operator_file: OperatorFile | None = None,
    accounts: AccountFile | None = None,
    anyone_observes: bool = False,
    commands: MissionCommands | None = None,
    findings: FindingCommands | None = None,
    replay: ReplayControl | None = None,
    viewer: ViewControl | None = None,
    handovers: HandoverControl | None = None,
    operation: OperationView | None = None,
    sortie_choice: SortieChoice | None = None,
    plans_folder: Path = Path("plans"),
    basemap_file: Path | None = None,
    terrain: TerrainSettings | None = None,
    wall: Wall | None = None,
    videos: VideoControl | None = None,
    upstream: Upstream | None = None,
    now_s: Callable[[], float] = loop_time_s,
) -> FastAPI:
    """Make the application for one mission.

    Args:
        mission: mission that is shown.
        static_folder: the dashboard's build; by default the one inside the package.
        allowed_hosts: host names, beside localhost and IP addresses, under which the page may be opened.
        trusted_proxies: addresses and networks of proxies whose headers about clients are believed.
        operator_code: code for signing in as an operator; without one every client is an operator.
        operator_file: remembers who is signed in; without it they sign in again after a restart.
        accounts: accounts of everybody, in the place of the operator code.
        anyone_observes: with accounts, those who have not signed in observe.
        commands: commands to the mission; None where it is only shown.
        findings: decisions about the findings of a survey, which has no vehicles; None for missions.
        replay: replay of the mission; None for a live one.
        viewer: viewer of its frames; None where they are not recorded.
        handovers: hand-overs of its record; None where there is none.
        operation: sorties of its operation, and their frames; None where nothing is recorded.
        sortie_choice: choice of the sortie that is replayed; None for a live mission.
        plans_folder: folder of saved plans.
        basemap_file: a PMTiles file to show below the mission; without one the page has a metric grid.
        terrain: elevation model of a mission that cannot be commanded; others tell theirs.
        wall: live pictures of its cameras; None where they are not recorded.
        videos: videos of them; None where they are not recorded.
        upstream: process in which the mission flies; None: this one.
        now_s: clock in real seconds, for the mission's silence and the wait after wrong codes.
    """
    # The interactive documentation of FastAPI loads scripts from the internet, which a field laptop has not.
    app = FastAPI(title="aos-gcs", docs_url=None, redoc_url=None, openapi_url="/api/openapi.json", lifespan=_lifespan)
    app.state.mission = mission
    app.state.commands = commands
    app.state.findings = commands or findings
    app.state.replay = replay
    app.state.viewer = viewer
    app.state.handovers = handovers
    app.state.operation = operation
    app.state.sortie_choice = sortie_choice
    app.state.basemap_file = basemap_file
    app.state.terrain = terrain
    app.state.wall = wall
    app.state.wall_messages = None if wall is None else WallMessages(wall, loop_time_s)
    app.state.videos = videos
    app.state.reliefs = ReliefMaps()
    app.state.plans = PlanFolder(plans_folder)
    app.state.plan_checks = PlanChecks()
    capabilities = CapabilitiesModel(
        planning=commands is not None,
        viewer=viewer is not None,
        findings=app.state.findings is not None,
        operation=operation is not None,
        survey=findings is not None,
        handover=handovers is not None,
        wall=wall is not None,
        video=videos is not None,
    )
    app.state.hub = EventHub(mission, replay, capabilities, now_s, upstream)
    app.state.access = Access(operator_code, now_s, operator_file, accounts, anyone_observes=anyone_observes)
    proxies = TrustedProxies(trusted_proxies)
    app.state.desk = _desk(app.state.access)
    app.state.control = None if commands is None else ControlDesk(app.state.access, app.state.hub, commands)
    if commands is not None and app.state.access.is_required:
        app.state.hub.show_control(app.state.access.control)
    app.state.limits = PeerLimits(now_s, app.state.access.addresses, proxies)
    app.state.once = Once()
    app.add_middleware(BodyLimitMiddleware, streaming_paths=[IMPORT_PATH])
    app.add_middleware(RolesMiddleware, access=app.state.access)
    app.add_middleware(SameOriginMiddleware, allowed_hosts=allowed_hosts)
    app.add_middleware(SecurityHeadersMiddleware)
    app.add_middleware(PeerLimitMiddleware, limits=app.state.limits, access=app.state.access)
    app.add_middleware(ProxyMiddleware, proxies=proxies)
    add_error_handlers(app)
    add_routes(app)
    add_page(app, static_folder)
    app.openapi = make_document  # type: ignore[method-assign]  # FastAPI's documented way to extend the document
    return app


def _desk(access: Access) -> AccountDesk | None:
    if access.accounts is None:
        return None
    path = access.accounts.file.path
    return AccountDesk(access.accounts, SignInLog(path.with_name(f"{path.stem}.sign-ins.jsonl")), machine_utc_s)
