"""What operators are told when the scan is over, and when."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.deciding import Decider
from aos_gcs.mission.search.findings import Findings
from aos_gcs.planning.legs import ScanLeg
from tests.fakes.notices import Notices
from tests.fakes.target_sightings import analysis
from tests.unit.test_mission_split import in_line, settings


def test_who_is_announced_in_the_step_that_ends_the_scan_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """An ArduCopter in software was told one person, and found the second one in the same step."""
    heard, traffic = Notices(), in_line(10)
    decider = Decider(settings(10), heard, Findings(), forget=lambda: None, covered_fraction=lambda: 1.0)
    decider.progress.plan([ScanLeg((0.0, 0.0), (0.0, 1.0), 20.0)])
    decision = decider.decide(Phase.SCAN, traffic, traffic.traffic.detours(), analysis())
    assert (decision.following, heard.texts) == (Phase.RETURN, [])
    monkeypatch.setattr(Findings, "persons", lambda _: [object()])
    decider.tell_end()
    assert heard.texts == ["Scan complete: the whole area was scanned, 1 possible person was found"]
