"""Simulated sensing at two fidelities, both of which give strategies the same kind of observation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.imaging.model import FocalGrid, Frame, LeaderCriterion, StepAnalysis
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.step.visibility import area_in_view_px, choose_leader, distance_to_centre
from aos_gcs.lab.scenario import Fidelity, Scenario
from aos_gcs.lab.worlds import Target, TargetViews, World
from aos_gcs.swarm.model import Observation, TargetMasks

OWN_RADIUS_M = 3.0
"""An anomaly farther from the target than this shows something else."""

_BANDS = ("red", "green", "blue", "thermal")


@dataclass(frozen=True, slots=True, eq=False)
class SensedTarget:
    """Content of one moment's frames. Rasters lie around the target: their middle cell is below it."""

    observation: Observation
    """Observation for the strategy; vehicle ids count from 1."""
    seen: NDArray[np.bool_]
    """Cells of the target that at least one drone marks, shape (rows, columns)."""
    unoccluded: NDArray[np.bool_]
    """Cells that at least one drone would see without the forest, shape (rows, columns)."""
    area_m2: float
    """A: how much of the target is seen."""
    unoccluded_m2: float
    cell_m2: float
    """Area of a cell of the rasters."""

    @property
    def visibility(self) -> float:
        """V: the area seen over the area that the same views would show without the forest, from 0 to 1."""
        return min(1.0, self.area_m2 / self.unoccluded_m2) if self.unoccluded_m2 > 0.0 else 0.0


class SwarmSensor(Protocol):
    """Eyes of a swarm in a world."""

    def sense(self, positions_enu_m: NDArray[np.float64], target: Target, rng: np.random.Generator) -> SensedTarget:
        """Return what drones at these positions, shape (n, 3), see of the target; ``rng`` draws the cameras' noise."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class _Detection:
    """Anomaly that the swarm takes for the target, rightly or not."""

    area_m2: float
    centroid_enu_m: tuple[float, float, float] | None
    fitness: NDArray[np.float64]
    leader_id: int | None
    masks: TargetMasks | None


@dataclass(frozen=True, slots=True)
class GeometricSensor:
    """Perfect detection: a drone marks exactly the cells of the target that it sees."""

    world: World
    scenario: Scenario

    def sense(
        self,
        positions_enu_m: NDArray[np.float64],
        target: Target,
        rng: np.random.Generator,  # noqa: ARG002 - nothing here is noisy
    ) -> SensedTarget:
        """See :meth:`SwarmSensor.sense`."""
        poses = [nadir_pose(position) for position in positions_enu_m]
        views = self.world.view_target(poses, self.scenario.camera, target)
        counts = views.seen.sum(axis=0, dtype=np.uint16)
        detection = self._detect(views, counts, poses)
        return _sighting(
            positions_enu_m,
            views,
            detection,
            seen=counts > 0,
            area_m2=detection.area_m2,
            threshold=self.scenario.threshold,
        )

    def _detect(self, views: TargetViews, counts: NDArray[np.uint16], poses: list[Pose]) -> _Detection:
        rows, columns = np.nonzero(counts > 0)
        if len(rows) == 0:
            return _Detection(0.0, None, np.zeros(len(poses)), None, None)
        height, width = counts.shape
        grid = FocalGrid(views.west_m, views.north_m, views.resolution_m, height, width, height_m=0.0)
        cells = BlobCells(rows, columns, counts[rows, columns])
        camera = self.scenario.camera
        masks = _cropped_masks(views, rows, columns)
        if self.scenario.leader_criterion is LeaderCriterion.CONTRIBUTION:
            fitness = masks.marked.sum(axis=(1, 2)) * views.resolution_m**2
        else:
            fitness = np.array([area_in_view_px(cells, grid, camera, pose) for pose in poses])
        centroid_enu_m = cells.centroid_enu_m(grid)
        leader = choose_leader(fitness, lambda row: distance_to_centre(centroid_enu_m, camera, poses[row]))
        return _Detection(cells.area_m2(grid), centroid_enu_m, fitness, leader + 1, masks)


@dataclass(frozen=True, slots=True)
class ImagingSensor:
    """Rendered frames through the imaging engine of missions: what it marks is what counts."""

    world: World
    scenario: Scenario

    def sense(self, positions_enu_m: NDArray[np.float64], target: Target, rng: np.random.Generator) -> SensedTarget:
        """See :meth:`SwarmSensor.sense`."""
        camera = self.scenario.camera
        poses = [nadir_pose(position) for position in positions_enu_m]
        views = self.world.view_target(poses, camera, target)
        images = self.world.render(poses, camera, target, rng)
        frames = [
            Frame(vehicle_id, image, _BANDS, pose, camera)
            for vehicle_id, (image, pose) in enumerate(zip(images, poses, strict=True), start=1)
        ]
        # Cells of the truth's raster, so that what is marked can be laid upon it.
        settings = ImagingSettings(leader_criterion=self.scenario.leader_criterion, resolution_m=views.resolution_m)
        analysis = analyse_step(frames, settings)
        detection = _Detection(
            analysis.visibility_m2,
            None if analysis.blob is None else analysis.blob.centroid_enu_m,
            analysis.fitness,
            analysis.leader_id,
            _target_masks(analysis),
        )
        seen, area_m2 = np.zeros(views.seen.shape[1:], dtype=np.bool_), 0.0
        if detection.masks is not None and _is_near(detection, target):
            seen, area_m2 = _laid_on(detection.masks, views), analysis.visibility_m2
        return _sighting(
            positions_enu_m, views, detection, seen=seen, area_m2=area_m2, threshold=self.scenario.threshold
        )


def make_sensor(world: World, scenario: Scenario) -> SwarmSensor:
    """Return the sensor of the scenario's fidelity."""
    if scenario.fidelity is Fidelity.GEOMETRIC:
        return GeometricSensor(world, scenario)
    return ImagingSensor(world, scenario)


def _sighting(
    positions_enu_m: NDArray[np.float64],
    views: TargetViews,
    detection: _Detection,
    *,
    seen: NDArray[np.bool_],
    area_m2: float,
    threshold: float,
) -> SensedTarget:
    unoccluded = np.asarray(views.unoccluded.any(axis=0))
    unoccluded_m2 = float(np.count_nonzero(unoccluded)) * views.resolution_m**2
    in_view = unoccluded_m2 > 0.0 and detection.area_m2 >= threshold * unoccluded_m2
    centroid_enu_m = detection.centroid_enu_m if in_view else None
    observation = Observation(
        vehicle_ids=tuple(range(1, len(positions_enu_m) + 1)),
        positions_enu_m=positions_enu_m[:, :2],
        fitness=detection.fitness,
        target_in_view=in_view,
        target_enu_m=None if centroid_enu_m is None else np.array(centroid_enu_m[:2]),
        leader_id=detection.leader_id,
        heights_m=positions_enu_m[:, 2],
        masks=detection.masks if in_view else None,
    )
    return SensedTarget(observation, seen & unoccluded, unoccluded, area_m2, unoccluded_m2, views.resolution_m**2)


def _is_near(detection: _Detection, target: Target) -> bool:
    if detection.centroid_enu_m is None:
        return False
    offset_m = np.subtract(detection.centroid_enu_m[:2], target.position_enu_m)
    return bool(np.linalg.norm(offset_m) <= OWN_RADIUS_M)


def _target_masks(analysis: StepAnalysis) -> TargetMasks | None:
    masks = analysis.masks
    return None if masks is None else TargetMasks(masks.marked, masks.west_m, masks.north_m, masks.resolution_m)


def _cropped_masks(views: TargetViews, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> TargetMasks:
    """Return what each drone marks, within the bounds of the cells that any of them marks."""
    first_row, first_column = int(rows.min()), int(columns.min())
    marked = views.seen[:, first_row : int(rows.max()) + 1, first_column : int(columns.max()) + 1]
    west_m = views.west_m + first_column * views.resolution_m
    return TargetMasks(marked, west_m, views.north_m - first_row * views.resolution_m, views.resolution_m)


def _laid_on(masks: TargetMasks, views: TargetViews) -> NDArray[np.bool_]:
    """Return what any mask marks, on the raster of the views; both have edges at multiples of the same resolution."""
    rows, columns = np.nonzero(masks.marked.any(axis=0))
    rows = rows + round((views.north_m - masks.north_m) / views.resolution_m)
    columns = columns + round((masks.west_m - views.west_m) / views.resolution_m)
    height, width = views.seen.shape[1:]
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    laid = np.zeros((height, width), dtype=np.bool_)
    laid[rows[inside], columns[inside]] = True
    return laid
