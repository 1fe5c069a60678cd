"""Wire models of the viewer."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.viewing import FrameKind, ViewKind


class ViewedFrameModel(WireModel):
    """A frame that a step has."""

    vehicle_id: int
    utc_s: float = Field(description="Time of exposure.")
    position_enu_m: tuple[float, float, float] = Field(description="Position of the camera.")
    width_px: int
    height_px: int
    kinds: list[FrameKind]
    name: str = Field(description="Name of the picture's file in a survey; empty in missions.")


class ViewedStepModel(WireModel):
    """Views that a step offers."""

    step: int
    focal_height_m: float = Field(description="Height of the plane that the mission used.")
    min_height_m: float = Field(description="Height of the lowest plane that can be shown.")
    max_height_m: float
    kinds: list[ViewKind]
    frames: list[ViewedFrameModel]


class FocusFoundModel(WireModel):
    """The height at which frames agree best."""

    height_m: float
    sigma_m: float | None = Field(description="Standard deviation; null when nothing was found.")
    found: bool
    reason: str = Field(description="Reason why nothing was found; empty otherwise.")
