"""Wire models of the relief about a mission."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import VertexModel, WireModel


class ReliefModel(WireModel):
    """Pictures of the ground's relief, from the mission's elevation model."""

    shading_url: str | None = Field(description="URL of the hill shading; null without an elevation model or origin.")
    contours_url: str | None = Field(description="URL of the contour lines; null where there is no shading.")
    contours_ft_url: str | None = Field(description="The same for contour lines at whole numbers of feet.")
    corners: list[VertexModel] = Field(description="Corners of the shading, clockwise from the north-western one.")


class ContourModel(WireModel):
    """One line of equal height."""

    altitude_amsl_m: float
    latitude_deg: list[float] = Field(description="Latitudes of its points.")
    longitude_deg: list[float] = Field(description="Longitudes of its points, as many.")


class ContoursModel(WireModel):
    """Contour lines of the ground about a mission."""

    interval_m: float = Field(description="Difference of height between neighbouring lines.")
    spacing_m: float = Field(description="Mean distance between neighbouring lines on the map.")
    lines: list[ContourModel]
