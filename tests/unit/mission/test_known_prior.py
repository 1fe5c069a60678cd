"""Prior and segments of a mission in flight: read once, reported once when they cannot be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.search.ground.known_prior import KnownPrior
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import MissionSettings
from tests.fakes.fleet import ORIGIN
from tests.fakes.shapes import polygon, write_features

AREA = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
SETTINGS = MissionSettings(2, AREA, ImagingSettings())


async def test_files_are_read_once_and_for_each_area(tmp_path: Path) -> None:
    file = tmp_path / "a.geojson"
    name = write_features(file, [polygon(-100, -100, 100, 100, name="A", weight=1)])
    flown = replace(SETTINGS, search=SearchSettings(prior=name, segments=name))
    journal = Journal(LoopClock())
    known = KnownPrior(lambda: flown, journal)
    prior, segments = await known.over(ORIGIN), await known.segments(ORIGIN)
    assert prior is not None
    assert [segment.name for segment in segments] == ["A"]
    file.unlink()
    assert await known.over(ORIGIN) is prior
    assert await known.segments(ORIGIN) is segments
    assert journal.notice_count == 0
    flown = replace(flown, area_enu_m=((0.0, 0.0), (50.0, 0.0), (50.0, 50.0)))
    for _ in range(2):
        assert await known.over(ORIGIN) is None, "another area, and the file is gone"
    assert journal.notice_count == 1


async def test_without_files_there_is_nothing_to_read() -> None:
    journal = Journal(LoopClock())
    for settings in (SETTINGS, replace(SETTINGS, area_enu_m=(), search=SearchSettings(prior="gone.geojson"))):
        known = KnownPrior(lambda settings=settings: settings, journal)  # type: ignore[misc]
        assert await known.over(ORIGIN) is None
        assert await known.segments(ORIGIN) == ()
    lost = KnownPrior(lambda: replace(SETTINGS, search=SearchSettings(segments="gone.geojson")), journal)
    assert await lost.segments(ORIGIN) == await lost.segments(ORIGIN) == ()
    assert journal.notice_count == 1
