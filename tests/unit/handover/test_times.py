"""Times of findings and of decisions on them in the hand-over."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path
from typing import Any

import pypdfium2 as pdfium
import pytest

from aos_gcs.handover.contents import read_handover
from aos_gcs.handover.model import HandoverOptions, ReportedFinding
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.runtime.recorded import handover as runtime
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.handed_over import FOUND, START_UTC_S, snapshot_of, state


def reported_of(tmp_path: Path, *states: Event) -> ReportedFinding:
    async def record() -> None:
        async with MissionRecorder.create(tmp_path, "m", {}, notify=lambda _: None) as recorder:
            for seq, event in enumerate(states, start=1):
                await recorder.record_event(replace(event, seq=seq))

    asyncio.run(record())
    with MissionReader(tmp_path / "m") as reader:
        (reported,) = read_handover(reader).findings
    return reported


@pytest.mark.parametrize(
    ("later", "decided_utc_s", "text"),
    [
        ({}, None, "Robin in an earlier sortie"),
        ({"found_in": "", "track_id": 4}, None, "Robin in an earlier sortie"),
        ({"operator": "Kim", "status": FindingStatus.REJECTED}, START_UTC_S + 3.0, "Kim at 2026-05-03 09:20:03 UTC"),
    ],
)
def test_a_decision_of_an_earlier_sortie_has_no_time_of_this_one(
    tmp_path: Path, later: dict[str, Any], decided_utc_s: float | None, text: str
) -> None:
    left = replace(FOUND, status=FindingStatus.CONFIRMED, operator="Robin", found_in="first", track_id=None)
    changed = replace(left, **later)
    reported = reported_of(tmp_path, state(0.0, up_m=0.0, findings=[left]), state(3.0, up_m=9.0, findings=[changed]))
    assert reported.decided_utc_s == decided_utc_s
    with pdfium.PdfDocument(runtime.make_handover(tmp_path / "m", HandoverOptions(), START_UTC_S)) as document:
        words = " ".join(page.get_textpage().get_text_range() for page in document).split()
    assert text in " ".join(words)


MARKED = replace(FOUND, track_id=None, sightings=0, found_at_s=-40.0, seen_at_s=-40.0, operator="Robin")


@pytest.mark.parametrize(
    ("at_s", "started_s", "found_utc_s"),
    [
        (-40.0, 60.0, START_UTC_S + 20.0),
        (0.0, None, START_UTC_S + 21.0),  # not started yet
        (0.0, 60.0, START_UTC_S + 21.0),  # an older record
    ],
)
def test_a_place_marked_before_the_launch_has_the_time_of_the_mark(
    tmp_path: Path, at_s: float, started_s: float | None, found_utc_s: float
) -> None:
    marked = replace(MARKED, found_at_s=at_s, seen_at_s=at_s)
    states = [state(0.0, up_m=0.0), state(21.0, up_m=0.0, findings=[marked]), state(70.0, up_m=0.0, findings=[marked])]
    started_utc_s = None if started_s is None else START_UTC_S + started_s
    dated = [replace(one, data=replace(snapshot_of(one), started_utc_s=started_utc_s)) for one in states]
    reported = reported_of(tmp_path, *dated)
    assert (reported.found_utc_s, reported.seen_utc_s) == (found_utc_s, found_utc_s)
