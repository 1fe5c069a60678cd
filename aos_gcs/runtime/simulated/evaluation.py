"""Score of a simulated mission by the simulator's truth."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.walks import Walk
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.frames.sampling import to_frame
from aos_gcs.runtime.simulated.truth_file import check_world, read_world
from aos_gcs.store.reader import MissionReader

TRUTH_GROUP = "aos_gcs.truths"
"""Entry points of simulators; ``unoccluded_areas_m2`` is described in ``aos_sim.truth``."""

HERE_M = 3.0
"""A blob, or a claim, farther from the person than this is of something else."""


@dataclass(frozen=True, slots=True)
class Score:
    """The result of a simulated mission. ``None`` where there is nothing to measure."""

    found: bool
    """The same as ``person_found``."""
    person_found: bool
    """Whether a claim, a finding that was announced as a possible person, lies within 3 m of a person."""
    claims: int
    """Claims that operators have not rejected."""
    false_claims: int
    """Claims of these that lie near no person."""
    person_probability: float | None
    """Probability of the claim nearest to a person; None without a claim or temperatures."""
    target_error_m: float | None
    """Horizontal distance of that claim from that person."""
    target_height_error_m: float | None
    """Height of that claim above the ground at that person; of one who walks, where it was at first."""
    time_to_detection_s: float | None
    """Time from the start to the first claim."""
    visibility_max: float | None
    """Largest visible area of the person in one step over the area that the same views would cover without forest."""
    visibility_final: float | None
    """The same in the last step."""
    steps: int
    vehicles: int
    landed: int
    min_separation_m: float | None
    """Smallest true 3-D distance between two vehicles."""
    min_height_above_ground_m: float | None
    """Smallest true height of a vehicle above ground that is not level, away from its launch point."""
    mission_dir: str

    def lines(self) -> list[str]:
        """Return one line of text per value."""
        return [
            f"{name.replace('_', ' ')}: {f'{value:.2f}' if isinstance(value, float) else value}"
            for name, value in asdict(self).items()
        ]


def score_mission(snapshot: MissionSnapshot, folder: Path, world_file: Path, report_file: Path | None) -> Score:
    """Compare a mission with the files that the simulator has written.

    Mission and world may have origins of their own.

    Raises:
        InputDataError: the mission folder or the world file cannot be read, or the file tells of another world.
    """
    world = read_world(world_file)
    check_world(world_file, world, snapshot)
    report: dict[str, Any] = {}
    if report_file is not None and report_file.exists():
        report = json.loads(report_file.read_text(encoding="utf-8"))
    persons = _Persons(world, snapshot.origin)
    claims = [finding for finding in snapshot.findings if finding.is_claimed and finding.stands]
    with MissionReader(folder) as reader:
        times_utc_s = {step.step: _time_utc_s(reader, step.step) for step in reader.steps()}
        errors_m = [persons.distance_m(claim.position_enu_m, times_utc_s.get(claim.step)) for claim in claims]
        visibilities = _visibilities(reader, world, persons, times_utc_s)
        outcome = reader.outcome()
    hits = sum(error_m <= HERE_M for error_m in errors_m)
    nearest = min(zip(errors_m, claims, strict=True), key=lambda pair: pair[0], default=None)
    height_error_m = None
    if nearest is not None and persons.exist:
        height_error_m = persons.height_above_m(nearest[1].position_enu_m, times_utc_s.get(nearest[1].step))
    found_at_s = None if outcome is None else outcome.summary.get("time_to_detection_s")
    return Score(
        found=hits > 0,
        person_found=hits > 0,
        claims=len(claims),
        false_claims=len(claims) - hits,
        person_probability=None if nearest is None else nearest[1].person_confidence,
        target_error_m=None if nearest is None or not persons.exist else nearest[0],
        target_height_error_m=height_error_m,
        time_to_detection_s=found_at_s if isinstance(found_at_s, float) else None,
        visibility_max=max(visibilities, default=None),
        visibility_final=visibilities[-1] if visibilities else None,
        steps=snapshot.step,
        vehicles=sum(vehicle.takes_part for vehicle in snapshot.vehicles),
        landed=sum(vehicle.task is Task.LANDED for vehicle in snapshot.vehicles),
        min_separation_m=report.get("min_separation_m"),
        min_height_above_ground_m=report.get("min_height_above_ground_m"),
        mission_dir=str(folder),
    )


class _Persons:
    """Places of the persons, in the mission's frame."""

    def __init__(self, world: Mapping[str, Any], mission_origin: GeodeticPosition | None) -> None:
        self._frame = LocalFrame(GeodeticPosition(**world["origin"]))
        self._mission_frame = self._frame if mission_origin is None else LocalFrame(mission_origin)
        self._targets: list[dict[str, Any]] = world["targets"]
        self._start_utc_s = float(world.get("start_utc_s", 0.0))

    @property
    def exist(self) -> bool:
        """Whether there is one."""
        return bool(self._targets)

    def distance_m(self, position_enu_m: Sequence[float], utc_s: float | None) -> float:
        """Return the horizontal distance from the nearest person at a time; infinite where there is none.

        Args:
            position_enu_m: a place in the mission's frame.
            utc_s: time by the simulation's clock; None: when the world began.
        """
        return float(np.linalg.norm(self._offsets_m(position_enu_m, utc_s)[:, :2], axis=1).min(initial=math.inf))

    def height_above_m(self, position_enu_m: Sequence[float], utc_s: float | None) -> float:
        """Return the height of a place above the nearest person's; there is one at least. Arguments as above."""
        offsets_m = self._offsets_m(position_enu_m, utc_s)
        return float(offsets_m[np.argmin(np.linalg.norm(offsets_m[:, :2], axis=1)), 2])

    def _offsets_m(self, position_enu_m: Sequence[float], utc_s: float | None) -> NDArray[np.float64]:
        """Return where a place lies as seen from each person, shape (persons, 3)."""
        at_s = 0.0 if utc_s is None else utc_s - self._start_utc_s
        places = [self._place_enu_m(target, at_s) for target in self._targets]
        return np.asarray(np.array(position_enu_m) - np.array(places).reshape(-1, 3))

    def _place_enu_m(self, target: Mapping[str, Any], at_s: float) -> NDArray[np.float64]:
        place_enu_m = np.array(target["position_enu_m"], dtype=np.float64)
        if target.get("walk") is not None:
            place_enu_m[:2] += Walk(**target["walk"]).at(at_s)[0]
        return self._mission_frame.to_enu(self._frame.to_geodetic(place_enu_m))


def _time_utc_s(reader: MissionReader, step: int) -> float | None:
    """Return the mean time of a step's frames; None without one."""
    times_utc_s = [entry.utc_s for entry in reader.frames(step)]
    return sum(times_utc_s) / len(times_utc_s) if times_utc_s else None


def _visibilities(
    reader: MissionReader, world: Mapping[str, Any], persons: _Persons, times_utc_s: Mapping[int, float | None]
) -> list[float]:
    """Return the normalised visibility of each step."""
    frame = LocalFrame(GeodeticPosition(**world["origin"]))
    steps = reader.steps()
    views = []
    for step in steps:
        frames = [to_frame(entry.load(), frame) for entry in reader.frames(step.step)]
        views.append([(image.pose, image.camera) for image in frames])
    areas_m2 = _truth()(world, views, times_utc_s=[times_utc_s[step.step] or 0.0 for step in steps])
    visibilities = []
    for step, area_m2 in zip(steps, areas_m2, strict=True):
        place = step.target_enu_m
        own = place is not None and persons.distance_m(place, times_utc_s[step.step]) <= HERE_M
        # What earlier views add is left out, as the area is that of the step's own views.
        seen_m2 = step.visibility_m2 if step.visibility_present_m2 is None else step.visibility_present_m2
        visibilities.append(min(1.0, seen_m2 / area_m2) if own and area_m2 > 0.0 else 0.0)
    return visibilities


def _truth() -> Callable[..., list[float]]:
    for point in entry_points(group=TRUTH_GROUP):
        truth: Callable[..., list[float]] = point.load()
        return truth
    raise ConfigurationError("No simulator is installed that knows the truth; install aos-gcs[sim].")
