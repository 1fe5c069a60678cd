"""Proposals of others after a restart of the station: they are in its record."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from aos_gcs.clock import machine_utc_s
from aos_gcs.config.file import parse_config
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.proposals import ProposalUse
from aos_gcs.mission.proposals import Proposals
from aos_gcs.runtime.service import open_service
from aos_gcs.store.last_mission import last_proposals
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.program import unused_port
from tests.fakes.records import snapshot
from tests.unit.sharing.test_proposals import proposal


async def _record(root: Path) -> Proposals:
    desk, now_s = Proposals(), machine_utc_s()
    desk.take([proposal(uid, received_utc_s=now_s, stale_utc_s=now_s + 60.0) for uid in ("a", "b")])
    desk.decide(1, ProposalUse.DISMISSED, "Ada", now_s)
    async with MissionRecorder.create(root, "1-former", {}, notify=lambda _: None) as recorder:
        await recorder.record_event(Event(1, now_s, EventKind.SNAPSHOT, replace(snapshot(), proposals=desk.all())))
    return desk


@pytest.mark.parametrize("receive", [True, False])
@pytest.mark.usefixtures("threaded_workers")
async def test_the_station_that_follows_has_the_proposals_and_decisions_of_the_one_before(
    tmp_path: Path, receive: bool
) -> None:
    former = await _record(tmp_path)
    tables = {
        "link": {"urls": [f"udpin://127.0.0.1:{unused_port()}"]},
        "mission": {"area_enu_m": [[0, 0], [9, 0], [9, 9]], "vehicle_ids": [1, 2]},
        "api": {"enabled": False},
        "record": {"folder": tmp_path},
        "tak": {"url": f"udp://239.2.3.1:{unused_port()}", "interface": "127.0.0.1", "receive": receive},
    }
    async with open_service(parse_config(tables, source="test")) as service:
        assert service.mission.view.snapshot().proposals == (former.all() if receive else ())


async def test_without_a_record_that_can_be_read_there_are_none(tmp_path: Path) -> None:
    assert last_proposals(tmp_path / "missing") == ()
    await _record(tmp_path)
    (tmp_path / "2-damaged").mkdir()
    (tmp_path / "2-damaged" / "mission.sqlite").write_bytes(b"no database")
    assert last_proposals(tmp_path) == ()
