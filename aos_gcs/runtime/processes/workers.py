"""The service's worker processes: what takes much time or memory, or comes from outside, runs apart from the flight."""

from __future__ import annotations

from typing import Final

from aos_gcs.workers.process import WorkerSettings

_GIB: Final = 2**30

ANALYSIS: Final = WorkerSettings(
    name="Image analysis",
    memory_bytes=4 * _GIB,
    timeout_s=15.0,
    modules=(
        "aos_gcs.imaging.pictures",
        "aos_gcs.imaging.registration.pose_errors",
        "aos_gcs.imaging.focus.step",
        "aos_gcs.imaging.step.analysis",
        "aos_gcs.mission.search.ground.coverage",
        "aos_gcs.mission.search.targets.persons",
    ),
)
"""Analyses the frames of each step; the vehicles hold their positions until it has a result. A call and the start of a
new process take less than the phase's handler may be busy (``aos_gcs.mission.handler_watch.WORK_S``)."""

GROUND: Final = WorkerSettings(
    name="Map of searched ground", memory_bytes=2 * _GIB, timeout_s=15.0, modules=("aos_gcs.groundmap.work",)
)
"""Keeps the map of the searched ground; nothing waits for it."""

VIEWS: Final = WorkerSettings(
    name="Viewing of recorded frames",
    memory_bytes=4 * _GIB,
    timeout_s=20.0,
    modules=("aos_gcs.runtime.recorded.step_views",),
)
"""Computes what the dashboard asks for beyond the pictures of each step."""

HANDOVER: Final = WorkerSettings(
    name="The hand-over",
    memory_bytes=4 * _GIB,
    timeout_s=120.0,
    modules=("aos_gcs.runtime.recorded.handover",),
)
"""Makes a hand-over on paper when somebody asks for one, and ends."""

WALL: Final = WorkerSettings(
    name="Live pictures", memory_bytes=2 * _GIB, timeout_s=5.0, modules=("aos_gcs.wall.rendering",)
)
"""Renders tiles while somebody watches; the flight knows nothing of it."""

VIDEO: Final = WorkerSettings(
    name="The video of the wall",
    memory_bytes=2 * _GIB,
    timeout_s=2 * 3600.0,
    modules=("aos_gcs.runtime.wall.video",),
    niceness=15,
)
"""Makes a video of the wall when somebody asks for one, and ends; the other workers go first."""

DECODING: Final = WorkerSettings(name="Image decoding", memory_bytes=2 * _GIB, timeout_s=5.0, modules=("cv2",))
"""Decodes the files of cameras. One that it cannot decode costs one frame."""
