"""Rows of the laboratory's results, one per step."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StepRow:
    """One step of one run. None where there is nothing to tell."""

    initialisation: str
    strategy: str
    """Name and parameters, as in ``aos-apso(gamma=0.8)``."""
    step: int
    """Number of the step, from 1."""
    time_s: float
    """Time of the exposures since the start."""
    visibility: float
    """V: normalised visibility of this step's frames, from 0 to 1."""
    area_m2: float
    """A: area of the target that this step's frames show on the focal plane."""
    unoccluded_m2: float
    """Area that they would show without the forest."""
    history_visibility: float
    """V of all frames so far, laid on the target."""
    history_area_m2: float
    """A of all frames so far."""
    in_view: bool
    """The visibility has reached the threshold."""
    branch: str
    """``line`` or ``pso``, or what else a strategy calls what it is doing."""
    leader_id: int | None
    """Vehicle that the strategy follows; ids count from 1."""
    evolutionary_factor: float | None
    evolutionary_state: str | None
    c_s_m: float | None
    c_c_m: float | None
    east_m: list[float]
    """East coordinates of the drones in the order of their ids."""
    north_m: list[float]
    height_m: list[float]
    fitness: list[float]
    """Fitness of the drones in the unit of the leader criterion."""
    target_east_m: float
    """East coordinate of the target."""
    target_north_m: float
    target_error_m: float | None
    """Horizontal distance of this step's estimate from the target; None when it is not in view."""
    min_distance_m: float
    """Smallest horizontal distance between two drones at the exposures."""
    min_flight_distance_m: float
    """The same on the path there, had all flown straight and arrived together."""
    path_m: float
    """Mean way flown by a drone since the start."""
