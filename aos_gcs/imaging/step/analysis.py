"""Analysis of one step: from the vehicles' frames to the visibility, the leader and the target's position."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.imaging.model import Frame, KeptView, StepAnalysis
from aos_gcs.imaging.step.frame_checks import usable_frames
from aos_gcs.imaging.step.integration import integrate
from aos_gcs.imaging.step.judgement import judge
from aos_gcs.imaging.step.marking import FindMask, mark
from aos_gcs.imaging.step.settings import ImagingSettings


def analyse_step(
    frames: Sequence[Frame],
    settings: ImagingSettings,
    history: Sequence[KeptView] = (),
    known_mask: FindMask | None = None,
    settled_enu_m: Sequence[tuple[float, float]] = (),
) -> StepAnalysis:
    """Integrate frames, mark anomalies, and judge which blob is the largest and which vehicle leads.

    Blocks for tens of milliseconds: call it by a ``Worker``.

    Args:
        frames: at least one; sizes, altitudes and attitudes may differ. Of several frames of one vehicle the last
            stands for its present position; the others only take part in the integral. Frames that cannot be used, or
            do not see the focal plane, are skipped, and the result says why.
        settings: see :class:`~aos_gcs.imaging.step.settings.ImagingSettings`.
        history: views of the previous step's ``StepAnalysis.history``. They enlarge blobs that the frames mark, too; a
            blob of theirs alone is none. Leader, fitness and views of blobs are of the frames only.
        known_mask: a cached :func:`~aos_gcs.imaging.step.marking.find_mask` of these very frames, for callers that
            analyse them on several planes: masks do not depend on the plane.
        settled_enu_m: horizontal places that have been looked at; blobs there are seen, but lead no vehicle.

    Raises:
        UnusableFramesError: if no frame can be used; it gives the reasons.
        ImagingError: if there is no frame, or they lack a band that the detector needs.
    """
    usable = usable_frames(frames, settings.plane_height_m)
    integral = integrate(usable.frames, settings)
    marked = mark(usable.frames, integral, settings, known_mask)
    judgement = judge(marked, integral.grid, history, settings, settled_enu_m)
    return StepAnalysis(
        grid=integral.grid,
        integral=integral.mean,
        coverage=integral.coverage,
        anomaly_count=judgement.anomaly_count,
        blob=judgement.blob,
        vehicle_ids=judgement.vehicle_ids,
        fitness=judgement.fitness,
        leader_id=judgement.leader_id,
        masks=judgement.masks,
        sightings=judgement.sightings,
        skipped=usable.skipped,
        present_m2=judgement.present_m2,
        history=judgement.history,
        mark_digests={one.frame.vehicle_id: one.marks.digest() for one in marked},
    )
