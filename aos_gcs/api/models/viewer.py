"""Wire models of looking at steps again."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.viewing import FrameKind, ViewKind


class ViewedFrameModel(WireModel):
    """A frame that a step has."""

    vehicle_id: int
    utc_s: float = Field(description="When it was exposed.")
    position_enu_m: tuple[float, float, float] = Field(description="Of the camera.")
    width_px: int
    height_px: int
    kinds: list[FrameKind]


class ViewedStepModel(WireModel):
    """What can be seen of a step."""

    step: int
    focal_height_m: float = Field(description="Of the plane that the mission has used.")
    min_height_m: float = Field(description="Lowest plane that can be looked at.")
    max_height_m: float
    kinds: list[ViewKind]
    frames: list[ViewedFrameModel]


class FocusFoundModel(WireModel):
    """The height at which frames agree best."""

    height_m: float
    sigma_m: float | None = Field(description="Standard deviation; null when nothing was found.")
    found: bool
    reason: str = Field(description="Why nothing was found; empty otherwise.")
