"""Searched ground of the scripted mission."""

from __future__ import annotations

from aos_gcs.groundmap.figures import DetectionFigures, GroundFigures, SegmentFigures

SEGMENTS = (
    SegmentFigures("A 1", 12_000.0, 0.7, 0.55, probability=0.6, success=0.33),
    SegmentFigures("Ravine north of the old chapel", 4_500.0, 0.12, None, probability=None, success=None),
)
GROUND = GroundFigures(
    80,
    0,
    0.63,
    4.3,
    DetectionFigures(standing=0.51, sitting=0.7, lying=0.88),
    success=0.41,
    segments=SEGMENTS,
)
"""Searched ground from the first step on."""
