"""The operation that the shown mission belongs to."""

from __future__ import annotations

import dataclasses
from typing import Any

from fastapi import APIRouter

from aos_gcs.api.convert.places import percent
from aos_gcs.api.dependencies import Operation
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.operation import OperationModel, SortieModel
from aos_gcs.mission.model.operation import SortieRecord

router = APIRouter(prefix="/api/operation", tags=["operation"], responses={404: {"model": ErrorModel}})


@router.get("", responses={422: {"model": ErrorModel}})
async def read_operation(operation: Operation) -> OperationModel:
    """Return the sorties of the operation; a mission that no other one has followed is its only sortie."""
    return OperationModel(sorties=[_sortie(sortie) for sortie in await operation.sorties()])


def _sortie(sortie: SortieRecord) -> SortieModel:
    fields: dict[str, Any] = dataclasses.asdict(sortie)
    covered_fraction = fields.pop("covered_fraction")
    return SortieModel(**fields, covered_percent=percent(covered_fraction))
