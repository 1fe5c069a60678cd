"""What operators are told when the scan is over, and when."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import Mock

import pytest

from aos_gcs.groundmap.figures import GroundFigures
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.ground.covered_ground import CoveredGround
from aos_gcs.mission.search.scan.notices import tell_end
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.planning.legs import ScanLeg
from tests.fakes.notices import Notices
from tests.fakes.target_sightings import analysis
from tests.unit.mission.test_split import in_line, settings


@pytest.mark.parametrize(
    ("left_out_m", "covered", "text"),
    [
        (0.0, 0.98, "Scan complete: the whole area was scanned, nothing was found"),
        (0.0, 0.02, "Scan complete, nothing was found. Only 2 % of the area was in a usable frame: check the cameras"),
        (
            30.0,
            0.02,
            "Scan complete, nothing was found. 30 m of its legs were left out; 2 % of the area was in a frame",
        ),
    ],
)
def test_an_area_that_no_camera_has_shown_was_not_scanned(left_out_m: float, covered: float, text: str) -> None:
    heard = Notices()
    tell_end(heard, 0, left_out_m, covered)
    assert heard.texts[0].startswith(text)


def test_what_is_not_on_the_map_of_searched_ground_was_not_seen() -> None:
    ground = Mock(figures=GroundFigures(frames=3, left_out=90, seen_fraction=0.1, mean_views=0.2, detection=None))
    covered = CoveredGround(Mock(), Mock(), ground)
    assert covered.usable_fraction is None
    covered._coverage = Mock(covered_fraction=1.0)
    assert (covered.covered_fraction, covered.usable_fraction) == (1.0, 0.1)
    ground.figures = replace(ground.figures, left_out=3)
    assert covered.usable_fraction == 1.0


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
