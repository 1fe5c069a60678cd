"""The hand-over on paper, and the flight log."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from aos_gcs.api.dependencies import Handovers
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.geometry.notations import Notation
from aos_gcs.handover.model import HandoverOptions, Paper

router = APIRouter(prefix="/api/handover", tags=["handover"])

_FAILURES: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (404, 422, 503)}


@router.get(
    ".pdf",
    response_class=Response,
    responses={200: {"content": {"application/pdf": {}}, "description": "The mission so far."}, **_FAILURES},
)
async def read_handover(
    handovers: Handovers,
    paper: Paper = Paper.A4,
    notation: Notation = Notation.DECIMAL,
    time_zone: Annotated[str, Query(max_length=64, description="As in the tz database: Europe/Vienna.")] = "UTC",
) -> Response:
    """Return the hand-over: summary, map, findings with pictures, assignment, flights and log."""
    pdf = await handovers.handover(HandoverOptions(paper, notation, time_zone))
    return Response(pdf, media_type="application/pdf", headers=_named("handover.pdf"))


@router.get(
    "/flights.csv",
    response_class=Response,
    responses={200: {"content": {"text/csv": {}}, "description": "One line per flight."}, **_FAILURES},
)
async def read_flights(handovers: Handovers) -> Response:
    """Return the flight log of all vehicles."""
    table = await handovers.flight_log()
    return Response(table, media_type="text/csv", headers=_named("flights.csv"))


def _named(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-cache"}
