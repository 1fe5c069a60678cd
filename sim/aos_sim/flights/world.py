"""Flights of the laboratory (``aos_gcs.lab.flights``): a forest with bodies in it, and a swarm above it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import Pose
from aos_gcs.lab.flights import FlightParameters, Place
from aos_gcs.ports import Clock, Vehicle
from aos_sim.errors.cameras import ErringCameras
from aos_sim.errors.model import ErrorModel, error_model
from aos_sim.flights.conditions import study_conditions
from aos_sim.flights.swarm import FlownSwarm
from aos_sim.flights.vehicle import FlownVehicle
from aos_sim.render.renderer import Renderer
from aos_sim.swarm import DEFAULT_ORIGIN, GRID_M, MAX_VEHICLES, home_positions_enu_m
from aos_sim.vehicle.battery import Battery
from aos_sim.world.person import Posture
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from aos_sim.world.terrain import is_file
from aos_sim.world.terrain_file import write_geotiff

FOV_RAD = math.radians(50.0)
MAX_OF_A_KIND = 2
"""Animals, stones, cloths, stumps and puddles: none to so many of each."""
_AREA_SAMPLES = 200
"""Samples of the ground per side of the search area."""
BACKDROP_STRIDE = 2
"""Forest is rendered in every second pixel where no body is; its statistics are those of full frames."""


class FlownFleet:
    """The vehicles of a flight (``aos_gcs.ports.Fleet``)."""

    def __init__(self, vehicles: Sequence[FlownVehicle]) -> None:
        self._vehicles = {vehicle.vehicle_id: vehicle for vehicle in vehicles}

    def vehicles(self) -> Mapping[int, Vehicle]:
        """Return all vehicles by id."""
        return self._vehicles


class SimulatedFlight:
    """See :class:`aos_gcs.lab.flights.Flight`.

    Args:
        scene: the world.
        errors: errors of vehicles and cameras, and the wind.
        vehicles: number of vehicles.
        image_size_px: edge of the square images.
        seed: of all errors.
        launch_spacing_m: distance of neighbouring launch points.
        battery: battery of each vehicle; None: the usual one.

    Raises:
        ConfigurationError: a value is out of its range.
    """

    def __init__(
        self,
        scene: Scene,
        errors: ErrorModel,
        vehicles: int,
        image_size_px: int,
        seed: int,
        *,
        launch_spacing_m: float = GRID_M,
        battery: Battery | None = None,
    ) -> None:
        if not 1 <= vehicles <= MAX_VEHICLES:
            raise ConfigurationError(f"vehicles must lie within 1 and {MAX_VEHICLES}, got {vehicles}.")
        self._launch_spacing_m = launch_spacing_m
        self._battery = battery
        self._scene = scene
        self._errors = errors
        self._vehicles = vehicles
        self._camera = CameraModel.from_fov(image_size_px, image_size_px, FOV_RAD)
        self._seed = seed
        self._renderer = Renderer(scene, wind=errors.wind)
        self._swarm: FlownSwarm | None = None
        self._start_utc_s: float | None = None

    @property
    def origin(self) -> GeodeticPosition:
        """See :attr:`aos_gcs.lab.flights.Flight.origin`."""
        return DEFAULT_ORIGIN

    @property
    def area_enu_m(self) -> tuple[Place, ...]:
        """See :attr:`aos_gcs.lab.flights.Flight.area_enu_m`."""
        return tuple(map(_place, self._scene.area_enu_m))

    @property
    def persons_enu_m(self) -> Sequence[Place]:
        """See :attr:`aos_gcs.lab.flights.Flight.persons_enu_m`."""
        return [_place(person.position_enu_m) for person in self._scene.persons]

    def persons_at(self, utc_s: float) -> Sequence[Place]:
        """See :meth:`aos_gcs.lab.flights.Flight.persons_at`."""
        at_s = 0.0 if self._start_utc_s is None else utc_s - self._start_utc_s
        return [_place(person.position_enu_m) for person in self._scene.persons_at(at_s)]

    @property
    def postures(self) -> Sequence[str]:
        """See :attr:`aos_gcs.lab.flights.Flight.postures`."""
        return [str(person.posture) for person in self._scene.persons]

    @property
    def highest_ground_m(self) -> float:
        """See :attr:`aos_gcs.lab.flights.Flight.highest_ground_m`."""
        relief = self._scene.relief
        if relief is None:
            return 0.0
        corners_enu_m = self._scene.area_enu_m
        west_south, east_north = corners_enu_m.min(axis=0), corners_enu_m.max(axis=0)
        axes = (np.linspace(low, high, _AREA_SAMPLES) for low, high in zip(west_south, east_north, strict=True))
        return float(relief.height_m(*np.meshgrid(*axes)).max())

    def write_ground(self, path: Path) -> bool:
        """See :meth:`aos_gcs.lab.flights.Flight.write_ground`."""
        if self._scene.relief is not None:
            write_geotiff(path, self._scene.relief, self.origin)
        return self._scene.relief is not None

    @property
    def min_height_above_ground_m(self) -> float | None:
        """See :attr:`aos_gcs.lab.flights.Flight.min_height_above_ground_m`."""
        return None if self._swarm is None else self._swarm.min_height_above_ground_m

    @property
    def min_separation_m(self) -> float | None:
        """See :attr:`aos_gcs.lab.flights.Flight.min_separation_m`."""
        return None if self._swarm is None else self._swarm.min_separation_m

    @property
    def landed(self) -> int:
        """See :attr:`aos_gcs.lab.flights.Flight.landed`."""
        return self._vehicles if self._swarm is None else self._swarm.landed

    def fleet(self, clock: Clock) -> FlownFleet:
        """See :meth:`aos_gcs.lab.flights.Flight.fleet`."""
        self._start_utc_s = clock.utc_s()
        frame, relief = LocalFrame(self.origin), self._scene.relief
        homes_enu_m = home_positions_enu_m(self._vehicles, relief, self._launch_spacing_m)
        swarm = self._swarm = FlownSwarm(
            clock, frame, homes_enu_m, self._errors, self._seed, relief=relief, battery=self._battery
        )
        cameras = ErringCameras(self._errors, self._camera, self._seed)
        return FlownFleet(
            [
                FlownVehicle(swarm, row, clock, frame, cameras=cameras, view=self._view, seed=self._seed)
                for row in range(self._vehicles)
            ]
        )

    def _view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:
        return self._renderer.view(pose, camera, at_s, BACKDROP_STRIDE)


def build_simulated_flight(settings: FlightParameters) -> SimulatedFlight:
    """Build a flight; see :class:`aos_gcs.lab.flights.FlightBuilder`."""
    conditions = study_conditions(settings.conditions)
    errors = conditions.errors(error_model(settings.errors))
    scene = conditions.scene(build_scene(conditions.drawn(_scene_parameters(settings))))
    return SimulatedFlight(
        scene,
        errors,
        settings.vehicles,
        settings.image_size_px,
        settings.seed,
        launch_spacing_m=settings.launch_spacing_m,
    )


def _scene_parameters(settings: FlightParameters) -> SceneParameters:
    """Draw what lies in the forest; a person's posture does not hang on whether there is one."""
    rng = np.random.default_rng([settings.seed, 0xF1])
    animals, stones, cloths, stumps, waters = (int(count) for count in rng.integers(0, MAX_OF_A_KIND + 1, 5))
    if is_file(settings.terrain):
        raise ConfigurationError(
            f"--terrain must be flat, hills or slope:PERCENT, as flights have no place of their own, got "
            f"{settings.terrain!r}."
        )
    return SceneParameters(
        seed=settings.seed,
        trees_per_ha=settings.trees_per_ha,
        side_m=settings.side_m,
        persons=int(settings.has_person),
        posture=list(Posture)[int(rng.integers(len(Posture)))],
        animals=animals,
        stones=stones,
        cloths=cloths,
        stumps=stumps,
        waters=waters,
        terrain=settings.terrain,
        dressed=True,
    )


def _place(position_enu_m: NDArray[np.float64]) -> Place:
    return float(position_enu_m[0]), float(position_enu_m[1])
