"""Conversion of the viewer's results."""

from __future__ import annotations

from aos_gcs.api.convert.places import finite
from aos_gcs.api.models import viewer as wire
from aos_gcs.mission import viewing


def viewed_step(viewed: viewing.ViewedStep) -> wire.ViewedStepModel:
    """Convert the views of a step."""
    return wire.ViewedStepModel(
        step=viewed.step,
        focal_height_m=viewed.focal_height_m,
        min_height_m=viewed.min_height_m,
        max_height_m=viewed.max_height_m,
        kinds=list(viewed.kinds),
        frames=[
            wire.ViewedFrameModel(
                vehicle_id=frame.vehicle_id,
                utc_s=frame.utc_s,
                position_enu_m=frame.position_enu_m,
                width_px=frame.width_px,
                height_px=frame.height_px,
                kinds=list(frame.kinds),
                name=frame.name,
            )
            for frame in viewed.frames
        ],
    )


def focus_found(found: viewing.FocusFound) -> wire.FocusFoundModel:
    """Convert the result of autofocus."""
    return wire.FocusFoundModel(
        height_m=found.height_m, sigma_m=finite(found.sigma_m), found=found.found, reason=found.reason
    )
