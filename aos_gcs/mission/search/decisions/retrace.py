"""Decisions of a recorded search, made again by the functions that made them in flight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.reference_surface import LEVEL
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.imaging.model import Frame, KeptView, KnownPlaces, StepAnalysis
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, FormedLine, Group, SearchRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.decisions.ledger import step_record
from aos_gcs.mission.search.decisions.split import Split
from aos_gcs.mission.search.frames.ground_in_view import ground_in_view
from aos_gcs.mission.search.frames.sampling import to_frame
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.persons import Judgement, PersonWatch, watch_persons
from aos_gcs.planning.terrain.ground import ground_of_limits
from aos_gcs.planning.terrain.layer_surface import layer_surface
from aos_gcs.ports import Capture, Severity


@dataclass(frozen=True, slots=True, eq=False)
class Retraced:
    """A step's decision as it was made again."""

    record: StepRecord
    following: Phase
    marks: Mapping[int, str]
    """Digest of the cells that the frame of each vehicle marks."""
    settled_enu_m: tuple[tuple[float, float], ...]
    strategy_state: Mapping[str, object]


class _Unheard:
    """Journal that nobody reads; the record says what time it is."""

    now_s = 0.0

    def elapsed_s(self) -> float:
        return self.now_s

    def notice(
        self, severity: Severity, text: str, vehicle_id: int | None = None, *, track_id: int | None = None
    ) -> None:
        pass


class Retrace:
    """A search from its record: ``decide`` and ``conclude`` for each step that has them, in their order.

    Args:
        search: what all steps have in common.
    """

    def __init__(self, search: SearchRecord) -> None:
        self._settings = search.settings
        self._frame = LocalFrame(search.origin)
        self._journal = _Unheard()
        self._findings = Findings()
        self._decider = Decider(
            search.settings,
            self._journal,
            self._findings,
            left_for_later=search.left_for_later,
            forget=self._forget,
            covered_fraction=lambda: None,
        )
        self._history: tuple[KeptView, ...] = ()
        self._persons = PersonWatch()
        self._split: Split | None = None
        """Split of the latest step of the scanning group."""
        self._scan_persons = PersonWatch()
        """Watch of their frames."""
        self._frames: list[Frame] = []
        self._analysis: StepAnalysis | None = None
        self._limits: SafetyLimits | None = None
        self._ground: GroundRaster | None = None
        self._surface = LEVEL
        self._following = Phase.SCAN
        self.decided = 0
        """Number of decisions made again."""
        self.concluded = 0
        """Number of conclusions made again."""

    def decide(self, record: DecisionRecord, captures: Sequence[Capture]) -> Retraced:
        """Analyse the frames of a step again, and decide.

        Args:
            record: what the decision depended on.
            captures: recorded frames of the step.

        Raises:
            ImagingError: the frames cannot be analysed.
            ConfigurationError: the elevation model that it flew by cannot be used.
            InputDataError: a file of that cannot be read.
        """
        decider, situation = self._decider, record.situation
        self._findings.adopt(record.edits_before_analysis)
        if record.line is not None:
            self._form_line(record.line)
        if (is_scan := record.group is Group.SCAN) and decider.split is not self._split:
            self._split, self._scan_persons = decider.split, PersonWatch()
        settled_enu_m = decider.settled_enu_m
        if is_scan and decider.split is not None:
            settled_enu_m = decider.split.passed_enu_m
        frames = [self._placed(capture, record) for capture in captures]
        imaging = replace(self._settings.imaging, plane_height_m=record.focal_height_m)
        places = KnownPlaces(settled_enu_m, (self._scan_persons if is_scan else self._persons).suspects_enu_m)
        analysis = analyse_step(frames, imaging, () if is_scan else self._history, places=places)
        if is_scan:
            self._watch_scan(frames, analysis)
        else:
            self._frames, self._analysis, self._history = frames, analysis, analysis.history
        self._findings.adopt(record.edits)
        self._journal.now_s = situation.now_s
        self._survey(situation.traffic.limits)
        detours, surface = situation.traffic.detours(), self._surface
        decision = decider.decide(
            record.phase,
            situation,
            detours,
            analysis,
            self._ground,
            surface=surface,
            may_sweep=record.may_sweep,
            group=record.group,
        )
        if not is_scan:
            self._following = decision.following
        self.decided += 1
        return Retraced(
            record=step_record(
                record.step,
                record.phase,
                situation.now_s,
                decider,
                analysis=analysis,
                decision=decision,
                missing=analysis.skipped,
            ),
            following=decision.following,
            marks=analysis.mark_digests,
            settled_enu_m=settled_enu_m,
            strategy_state=decider.strategy_state(),
        )

    def conclude(self, record: ConclusionRecord) -> ConclusionRecord:
        """Judge the frames of the latest decision again, and conclude.

        Raises:
            RuntimeError: no decision was made before; a defect of the caller.
        """
        if self._analysis is None:
            raise RuntimeError("nothing has been decided yet")
        self._findings.adopt(record.edits)
        self._journal.now_s = record.now_s
        tracker, judgements = self._decider.tracker, dict[int, Judgement]()
        if record.judged:
            usable = [frame for frame in self._frames if frame.vehicle_id in self._analysis.vehicle_ids]
            self._persons, judgements = watch_persons(
                self._persons,
                usable,
                self._analysis.grid.height_m,
                tracker.places_enu_m(),
                self._settings.uncertainty,
                ground=ground_in_view(self._settings, self._ground, self._analysis.grid),
            )
        following = self._decider.conclude(self._following, judgements)
        targets = tracker.estimates()
        self._findings.observe(targets, record.step, record.now_s)
        self._findings.merge(targets)
        self.concluded += 1
        return replace(record, following=following, targets=targets)

    def _watch_scan(self, frames: Sequence[Frame], analysis: StepAnalysis) -> None:
        """Take in what the frames of the scanning group show of warm bodies; their tracks are those of the look."""
        usable = [frame for frame in frames if frame.vehicle_id in analysis.vehicle_ids]
        self._scan_persons, _ = watch_persons(
            self._scan_persons,
            usable,
            analysis.grid.height_m,
            {},
            self._settings.uncertainty,
            ground=ground_in_view(self._settings, self._ground, analysis.grid),
        )

    def _survey(self, limits: SafetyLimits) -> None:
        """Take in the ground and the surface of the layers, which are those of the limits as long as these stay."""
        if limits == self._limits:
            return
        terrain, speed_mps = self._settings.terrain, self._settings.flight.cruise_speed_mps
        self._ground = ground_of_limits(terrain, self._frame.origin, limits)
        self._surface = layer_surface(terrain, self._ground, limits, speed_mps)
        self._limits = limits

    def _form_line(self, line: FormedLine) -> None:
        progress = self._decider.progress
        if not progress.legs:
            progress.take_up(line.legs, line.leg)
        if line.leg > progress.leg:
            # The wanted probability was reached, by a map that is no part of the record.
            self._decider.goes_on_to_looks()
        # Stretches flown again were chosen by the map of searched ground, which is no part of the record.
        progress.extend(line.legs[len(progress.legs) :])
        self._decider.begin_line(line.formed)

    def _placed(self, capture: Capture, record: DecisionRecord) -> Frame:
        frame = to_frame(capture, self._frame, record.speeds_mps.get(capture.vehicle_id, 0.0))
        return replace(frame, pose=record.poses.get(capture.vehicle_id, frame.pose))

    def _forget(self) -> None:
        self._history, self._persons = (), self._persons.without_steps()
