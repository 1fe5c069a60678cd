"""One of each kind of record, for tests of what is recorded and read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord
from aos_gcs.mission.model.findings import TargetEstimate
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import Task, VehicleSnapshot
from aos_gcs.ports import Capture, Severity, VehicleState
from aos_gcs.store.frame_files import FrameRow, write_frames

ORIGIN = GeodeticPosition(48.33, 14.33, 301.25)


def notice_event(seq: int, text: str = "hello") -> Event:
    return Event(seq, 1000.0 + seq, EventKind.NOTICE, NoticeRecord(Severity.INFO, text, None, float(seq)))


def frame_row(folder: Path, step: int, frame: Capture) -> FrameRow:
    """Write the file of a frame into a mission folder, and return its row."""
    (row,) = write_frames(folder, [(step, frame)])
    assert isinstance(row, FrameRow)
    return row


def step_record(step: int) -> StepRecord:
    return StepRecord(
        step=step,
        elapsed_s=12.5 * step,
        phase=Phase.SCAN,
        visibility_m2=0.1 * step,
        threshold_m2=0.3,
        branch="line",
        evolutionary_factor=1 / 3,
        evolutionary_state="convergence",
        c_s_m=1.0,
        c_c_m=2.0,
        leader_id=2,
        target_enu_m=(1.0, 2.0, 0.0),
        fitness={1: 0.5, 2: 0.75},
        missing={3: "no frame within 5 s"},
        waypoints=(WaypointRecord(1, (0.1, 0.2, 35.0), None, WaypointVerdict.HELD, "outside of the fence"),),
        imaging_ms=20.0,
        work_ms=50.0,
        loop_lag_p99_ms=1.0,
    )


def snapshot() -> MissionSnapshot:
    vehicle = VehicleSnapshot(VehicleState(1, position=ORIGIN), Task.SWARM, 35.0, (0.0, 0.0, 35.0), 0.1, None, None)
    return MissionSnapshot(
        mission_id="m",
        strategy="aos-apso",
        phase=Phase.SCAN,
        suspension=Suspension.NONE,
        outcome=Outcome.OPEN,
        message="scanning",
        elapsed_s=30.0,
        step=2,
        origin=ORIGIN,
        area_enu_m=((0.0, 0.0), (10.0, 0.0), (10.0, 10.0)),
        fence_enu_m=((-5.0, -5.0), (15.0, -5.0), (15.0, 15.0)),
        vehicles=(vehicle,),
        preflight=(),
        target=TargetEstimate((1.0, 2.0, 0.0), 0.4, 3),
        min_separation_m=1.5,
    )


def capture(vehicle_id: int = 1) -> Capture:
    image = np.random.default_rng(vehicle_id).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    return Capture(
        vehicle_id=vehicle_id,
        image_index=4,
        utc_s=1234.5,
        image=image,
        bands=("red", "green", "blue"),
        position=ORIGIN,
        R_cam2enu=nadir_pose([0.0, 0.0, 0.0], heading_rad=0.3).R_cam2enu,
        camera=CameraModel.from_fov(8, 6, 0.87),
    )
