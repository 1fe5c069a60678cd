"""Wire models shared by the others: their base, points on the map, and errors.

Angles are degrees, lengths metres, times seconds; positions carry ENU metres about the mission's origin and, when that
origin is known, WGS84 degrees beside them. ``null`` always means *not known*, never zero.
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class WireModel(BaseModel):
    """Base of all wire models: unknown fields are refused, instances are not changed after they are made."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class GeodeticModel(WireModel):
    """A WGS84 position with its altitude above mean sea level."""

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: float


class PositionModel(WireModel):
    """A point in the mission's ENU frame, with its place on the globe when the origin is known."""

    east_m: float
    north_m: float
    up_m: float
    latitude_deg: float | None
    longitude_deg: float | None


class VertexModel(WireModel):
    """A corner of a polygon or a picture on the ground plane."""

    east_m: float
    north_m: float
    latitude_deg: float | None
    longitude_deg: float | None


class ScanLegModel(WireModel):
    """One sweep of the swarm's line, given by the path of its middle."""

    start: VertexModel
    end: VertexModel


class ErrorModel(WireModel):
    """The body of every error."""

    id: str = Field(description="Stable, for programs.")
    message: str = Field(description="Sentence for people: what is wrong and what to do.")
