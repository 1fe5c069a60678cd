"""Planning: check, import, save and apply."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from typing import Annotated, Any

import pydantic
from fastapi import APIRouter, Depends, Path, Query, Request

from aos_gcs.api.access.operators import cookie_name
from aos_gcs.api.convert import plans as plan_convert
from aos_gcs.api.dependencies import (
    IN_CONTROL,
    Checks,
    Commands,
    CommandsIfAny,
    CurrentSession,
    Mission,
    Plans,
    SeenState,
)
from aos_gcs.api.errors import NotFoundError, TooLargeError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.plans import ImportedShapeModel, PlanModel, PlanReportModel, SavedPlanModel, StrategyModel
from aos_gcs.errors import ConfigurationError, InputDataError, MissionError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.input_values import problem_texts
from aos_gcs.planning.checks.advice import propose
from aos_gcs.planning.checks.check import OUT_OF_MEMORY, examine_plan
from aos_gcs.planning.checks.sites import Homes, planned_boundaries
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan, available_options, plan_of
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.planning.shape_files import MAX_FILE_BYTES, import_shapes
from aos_gcs.planning.terrain.profile import LegProfile, plan_profile

router = APIRouter(tags=["plans"])

IMPORT_PATH = "/api/plan/import"
_REFUSED: dict[int | str, dict[str, Any]] = {403: {"model": ErrorModel}, 422: {"model": ErrorModel}}
PlanName = Annotated[str, Path(max_length=64)]
Replaces = Annotated[
    str | None,
    Query(description="Version of the plan that may be replaced, `none` for a new name; by default any version."),
]


@router.get("/api/plan", responses={409: {"model": ErrorModel}})
async def read_plan(mission: Mission, commands: Commands) -> PlanModel:
    """Return the plan that the mission flies by."""
    origin, plan = mission.snapshot().origin, plan_of(commands.settings)
    if origin is None and plan.area_enu_m:
        raise MissionError("The plan cannot be shown in degrees before a vehicle has reported its home.")
    return plan_convert.plan_to_wire(plan, origin or plan_convert.NO_ORIGIN)


@router.get("/api/plan/strategies")
async def read_strategies() -> list[StrategyModel]:
    """Return the available strategies with their parameters."""
    return [plan_convert.strategy(options) for options in available_options()]


async def _turn(request: Request, session: CurrentSession, checks: Checks) -> AsyncIterator[None]:
    client = request.cookies.get(cookie_name(request)) or (request.client.host if request.client else "")
    async with checks.turn(session.role, client):
        yield


@router.post(
    "/api/plan/check",
    responses=_REFUSED | {429: {"model": ErrorModel}},
    dependencies=[Depends(_turn, scope="function")],
)
async def check(body: PlanModel, mission: Mission, commands: Commands) -> PlanReportModel:
    """Return the problems of a plan, an estimate, and proposals; also for observers."""
    snapshot = mission.snapshot()
    origin = plan_convert.plan_origin(body, snapshot.origin)
    plan = plan_convert.plan_from_wire(plan_convert.complete(body, commands.settings), origin)
    homes_enu_m = plan_convert.homes(snapshot.vehicles, snapshot.origin)
    # A tenth of a second and more: too long for the loop that commands vehicles.
    return await asyncio.to_thread(_report, plan, commands.settings, homes_enu_m, origin)


@router.post(
    "/api/plan/apply",
    responses=_REFUSED | {status: {"model": ErrorModel} for status in (409, 428)},
    dependencies=[IN_CONTROL],
)
async def apply(
    body: PlanModel, mission: Mission, commands: Commands, session: CurrentSession, seen: SeenState
) -> PlanModel:
    """Apply this plan, before the start only. Connecting and preflight start again."""
    origin = mission.snapshot().origin
    if origin is None:
        raise MissionError(
            "The mission's origin is not known yet: wait until a vehicle has reported its home, or give "
            "mission.origin_deg in the configuration."
        )
    plan = plan_convert.plan_from_wire(plan_convert.complete(body, commands.settings), origin)
    await commands.apply_plan(plan, operator=session.name, seen=seen)
    return plan_convert.plan_to_wire(plan_of(commands.settings), origin)


@router.post(
    IMPORT_PATH,
    responses=_REFUSED | {413: {"model": ErrorModel}},
    openapi_extra={"requestBody": {"required": True, "content": {"application/octet-stream": {}}}},
)
async def import_file(request: Request) -> list[ImportedShapeModel]:
    """Return the shapes of a file (GeoJSON, KML, QGroundControl's .plan), which is the body as it is."""
    content = bytearray()
    async for chunk in request.stream():
        content += chunk
        if len(content) > MAX_FILE_BYTES:
            megabytes = MAX_FILE_BYTES // 1024**2
            raise TooLargeError(f"The file is larger than {megabytes} MiB; remove what is not needed.")
    shapes = await asyncio.to_thread(import_shapes, bytes(content))
    return [plan_convert.imported(shape) for shape in shapes]


@router.get("/api/plans")
async def list_plans(plans: Plans) -> list[SavedPlanModel]:
    """Return the names of the saved plans."""
    entries = await asyncio.to_thread(plans.entries)
    return [SavedPlanModel(name=entry.name, saved_utc_s=entry.saved_utc_s, version=entry.version) for entry in entries]


@router.get("/api/plans/{name:path}", responses={404: {"model": ErrorModel}, 422: {"model": ErrorModel}})
async def read_saved_plan(name: PlanName, plans: Plans, commands: CommandsIfAny) -> PlanModel:
    """Return a saved plan. What it leaves to the mission is as the mission is set."""
    text = await asyncio.to_thread(plans.read, name)
    if text is None:
        raise NotFoundError(f"There is no plan '{name}'.")
    try:
        plan = PlanModel.model_validate_json(text)
    except pydantic.ValidationError as error:
        problems = "; ".join(problem_texts(error.errors(), "the file"))
        raise InputDataError(f"The plan '{name}' is damaged: {problems}.") from error
    return plan if commands is None else plan_convert.complete(plan, commands.settings)


@router.put("/api/plans/{name:path}", responses=_REFUSED | {409: {"model": ErrorModel}})
async def save_plan(name: PlanName, body: PlanModel, plans: Plans, replaces: Replaces = None) -> PlanModel:
    """Save a plan, finished or not."""
    text = body.model_dump_json(indent=2, exclude=plan_convert.left_open(body))
    await asyncio.to_thread(plans.write, name, text, replaces)
    return body


@router.delete("/api/plans/{name:path}", status_code=204, responses=_REFUSED | {404: {"model": ErrorModel}})
async def delete_plan(name: PlanName, plans: Plans) -> None:
    """Remove a saved plan."""
    if not await asyncio.to_thread(plans.delete, name):
        raise NotFoundError(f"There is no plan '{name}'.")


def _report(
    plan: MissionPlan, settings: MissionSettings, homes_enu_m: Homes, origin: GeodeticPosition
) -> PlanReportModel:
    try:
        return _examined(plan, settings, homes_enu_m, origin)
    except MemoryError as error:
        raise ConfigurationError(OUT_OF_MEMORY) from error


def _examined(
    plan: MissionPlan, settings: MissionSettings, homes_enu_m: Homes, origin: GeodeticPosition
) -> PlanReportModel:
    found = examine_plan(plan, settings, homes_enu_m, origin)
    fence_enu_m = planned_boundaries(plan, homes_enu_m).fence_enu_m if found.legs else plan.fence_enu_m or ()
    picture = plan_convert.PlanPicture(_profile(plan, settings, homes_enu_m, origin, found.legs), fence_enu_m)
    estimate = found.estimate
    proposals = () if estimate is None else propose(plan, settings.imaging.plane_height_m, estimate.viewed)
    return plan_convert.report(plan, found.problems, proposals, found.estimate, picture=picture, origin=origin)


def _profile(
    plan: MissionPlan,
    settings: MissionSettings,
    homes_enu_m: Homes,
    origin: GeodeticPosition,
    legs: Sequence[ScanLeg],
) -> tuple[LegProfile, ...]:
    try:
        return plan_profile(plan, settings, origin, homes_enu_m, legs)
    except (ConfigurationError, InputDataError):
        return ()  # the check of the plan has named what is wrong with the elevation model
