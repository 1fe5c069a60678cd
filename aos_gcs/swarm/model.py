"""The ask/tell interface of swarm strategies.

A strategy is an immutable object with its parameters; the state is data outside of it, so that a run can be saved,
replayed and forked. Positions are horizontal ENU metres. Randomness is an argument.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class TargetMasks:
    """Masks of the target in each vehicle's own frame, on one north-up raster of the focal plane."""

    marked: NDArray[np.bool_]
    """Shape (n, rows, columns): row 0 is the northern edge, column 0 the western one."""
    west_m: float
    """East coordinate of the outer edge of column 0."""
    north_m: float
    """North coordinate of the outer edge of row 0."""
    resolution_m: float
    """Edge of a cell."""


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Observation of one step. ``n`` may differ from step to step."""

    vehicle_ids: tuple[int, ...]
    """Length n, the order of the rows below."""
    positions_enu_m: NDArray[np.float64]
    """Positions of the vehicles, shape (n, 2)."""
    fitness: NDArray[np.float64]
    """f(x_i, I(t)), shape (n,); NaN for a vehicle that delivered no frame."""
    target_in_view: bool
    """Visibility has reached the threshold T."""
    target_enu_m: NDArray[np.float64] | None = None
    """Estimated target position, shape (2,), when in view."""
    leader_id: int | None = None
    """The imaging's own choice, which has settled ties; else the argmax of ``fitness`` leads."""
    heights_m: NDArray[np.float64] | None = None
    """Heights of the vehicles above the focal plane, shape (n,), for strategies that reason about lines of sight; None
    where they are not known, or not all above 0."""
    masks: TargetMasks | None = None
    """Part of the target that each vehicle sees, when in view; the row of a vehicle without a frame is all False."""
    time_s: float | None = None
    """Time of the frames since an arbitrary start, for strategies that fit their steps to the time they take."""


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """Quantities of a strategy for operators and researchers; ``None`` where it has no such quantity."""

    branch: str
    """``line`` (the default branch), ``pso``, or a word of the strategy's own for what it is doing."""
    evolutionary_factor: float | None = None
    evolutionary_state: str | None = None
    c_s_m: float | None = None
    c_c_m: float | None = None
    leader_id: int | None = None


StateT = TypeVar("StateT")


class Strategy(Protocol[StateT]):
    """A swarm strategy: ``init`` once, then ``tell`` and ``ask`` in turn."""

    @property
    def name(self) -> str:
        """The name in the registry and on the command line."""
        ...

    @property
    def spacing_m(self) -> float:
        """Distance of the drones in the line, metres (c4): the smallest useful one between two samples."""
        ...

    def init(self, scan_direction_enu: NDArray[np.float64]) -> StateT:
        """Return the state before the first step.

        Args:
            scan_direction_enu: shape (2,), need not be normalised.
        """
        ...

    def tell(self, state: StateT, observation: Observation) -> StateT:
        """Return the state after an observation.

        Raises:
            ValueError: shapes do not fit, or there are fewer vehicles than the strategy needs, two as a rule.
        """
        ...

    def ask(self, state: StateT, rng: np.random.Generator) -> tuple[NDArray[np.float64], StateT]:
        """Return the next positions, shape (n, 2), in the order of the latest observation, and the new state.

        Raises:
            RuntimeError: nothing has been told since the last call.
        """
        ...

    def diagnostics(self, state: StateT) -> Diagnostics:
        """Describe the state after ``ask``."""
        ...
