"""Tiles rendered from recorded frames and rasters."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aos_gcs.errors import InputDataError
from aos_gcs.wall.model import Order, TileKind, TileName
from aos_gcs.wall.rendering import look, render_frame, render_raster
from tests.fakes.wall import START_UTC_S, WIDTH_PX, GrowingRecord

COLOURS = ("red", "green", "blue")


def test_temperatures_have_a_scale_in_degrees(record: GrowingRecord) -> None:
    record.add(3, START_UTC_S, bands=(*COLOURS, "thermal"))
    (facts,) = look(record.folder, 0, None, ()).newest
    assert facts.kinds == (TileKind.COLOUR, TileKind.THERMAL)
    colour, thermal = render_frame(record.folder, facts.number, [(TileKind.COLOUR, 64), (TileKind.THERMAL, 40)])
    assert colour.scale is None
    assert thermal.scale is not None
    assert (thermal.scale.low, thermal.scale.high) == pytest.approx((12.0, 34.0), abs=0.5)
    assert thermal.scale.is_celsius
    image = cv2.imdecode(np.frombuffer(thermal.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image[12, 12].sum() > 400
    assert image[2, 2].sum() < 100


@pytest.mark.parametrize("bands", [("thermal",), ("grey",), ("grey", "thermal")])
def test_cameras_of_any_bands_have_tiles(record: GrowingRecord, bands: tuple[str, ...]) -> None:
    record.add(1, START_UTC_S, bands=bands)
    (facts,) = look(record.folder, 0, None, ()).newest
    pictures = render_frame(record.folder, facts.number, [(kind, 400) for kind in facts.kinds])
    assert [(picture.width_px, picture.height_px) for picture in pictures] == [(80, 60)] * len(bands)


@pytest.mark.parametrize("kind", TileKind)
def test_a_tile_shows_what_the_whole_frame_shows(record: GrowingRecord, kind: TileKind) -> None:
    record.add(1, START_UTC_S, bands=("red", "green", "blue", "thermal", "grey"))
    (picture,) = render_frame(record.folder, 1, [(kind, 80)])
    image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    left, right = image[50, 5].astype(int), image[50, 70].astype(int)
    if kind is TileKind.COLOUR:
        assert left.max() + 40 < right.min()
    else:
        assert np.abs(left - right).max() < 5


def test_a_tile_of_a_kind_that_a_frame_lacks_is_not_due(record: GrowingRecord) -> None:
    record.add(1, START_UTC_S)
    missing, there = (Order(TileName(1, kind), WIDTH_PX, 0, 0) for kind in (TileKind.THERMAL, TileKind.COLOUR))
    assert look(record.folder, 0, None, (missing,)).rendered == ()
    (rendered,) = look(record.folder, 0, None, (missing, there)).rendered
    assert rendered.orders == (there,)


def test_a_known_frame_is_rendered_for_those_who_have_another_one(record: GrowingRecord) -> None:
    record.add(1, START_UTC_S)
    tile = TileName(1, TileKind.COLOUR)
    found = look(record.folder, 1, None, (Order(tile, WIDTH_PX, 1, 1), Order(tile, 72, 1, 0)))
    assert found.newest == ()
    assert [(one.number, len(one.pictures)) for one in found.rendered] == [(1, 1)]
    assert found.rendered[0].pictures[0].width_px == 72


def test_what_is_no_raster_is_refused() -> None:
    with pytest.raises(InputDataError, match="raster"):
        render_raster(b"nothing", 64)
