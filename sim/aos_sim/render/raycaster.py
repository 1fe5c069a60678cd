"""Ray casting with Embree, through the optional package ``embreex``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_sim.world.mesh import FloatArray

NO_HIT = -1


class RayCaster:
    """The first triangle that a ray meets.

    Immutable after construction; any number of threads may cast at once, truly in parallel, as Embree runs without
    the interpreter's lock.
    """

    def __init__(self, triangles_m: FloatArray) -> None:
        """Build the acceleration structure over triangles of shape (n, 3, 3).

        Raises:
            ConfigurationError: if embreex is not installed.
        """
        self._scene: Any = None
        try:
            from embreex.mesh_construction import TriangleMesh  # noqa: PLC0415  optional dependency
            from embreex.rtcore_scene import EmbreeScene  # noqa: PLC0415
        except ImportError as error:
            raise ConfigurationError("The simulator renders with embreex: install aos-gcs[sim].") from error
        if len(triangles_m) == 0:
            return
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, np.ascontiguousarray(triangles_m, dtype=np.float32))
        # Embree builds the structure on the first cast, which two threads must not do at the same time.
        self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing that a ray could hit."""
        return self._scene is None

    def first_hit(self, origin_m: NDArray[np.floating], directions: FloatArray) -> NDArray[np.int32]:
        """Return the index of the nearest triangle per ray, shape (n,), or ``NO_HIT``.

        Args:
            origin_m: Shape (3,), common to all rays, or (n, 3).
            directions: Of any length, shape (n, 3).
        """
        if self._scene is None:
            return np.full(len(directions), NO_HIT, dtype=np.int32)
        return np.asarray(self._scene.run(_origins(origin_m, directions), directions))

    def first_hit_with_distance(
        self, origin_m: NDArray[np.floating], directions: FloatArray
    ) -> tuple[NDArray[np.int32], FloatArray]:
        """Return what :meth:`first_hit` does, and the distance in lengths of the direction; infinite without a hit."""
        if self._scene is None:
            return self.first_hit(origin_m, directions), np.full(len(directions), np.inf, dtype=np.float32)
        hit = self._scene.run(_origins(origin_m, directions), directions, output=True)
        triangle = np.asarray(hit["primID"])
        return triangle, np.where(triangle == NO_HIT, np.float32(np.inf), hit["tfar"])

    def is_free(self, origin_m: FloatArray, directions: FloatArray) -> NDArray[np.bool_]:
        """Whether nothing stands in the way, shape (n,)."""
        if self._scene is None:
            return np.ones(len(directions), dtype=np.bool_)
        return np.asarray(self._scene.run(_origins(origin_m, directions), directions, query="OCCLUDED") == NO_HIT)


def _origins(origin_m: NDArray[np.floating], directions: FloatArray) -> FloatArray:
    return np.broadcast_to(np.asarray(origin_m, dtype=np.float32), directions.shape)
