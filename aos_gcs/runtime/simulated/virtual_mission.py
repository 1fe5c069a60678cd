"""A whole mission in virtual time, by the coordinator, its safety checks and imaging, over a simulated flight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.lab.flights import Flight
from aos_gcs.lab.spacing import USUAL, Spacing
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import OutcomeRecord
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import FlightSettings, MissionSettings, PreflightSettings, RegistrationSettings
from aos_gcs.ports import Capture
from aos_gcs.runtime.simulated.demo_terrain import above_ground
from aos_gcs.runtime.simulated.virtual_time import InlineWorker, run

SPLIT = "split"
"""Name of the continuous search with a split swarm."""


@dataclass(slots=True)
class StepTrace:
    """Recorder (``aos_gcs.mission.journal.Recorder``) that keeps steps and conclusions in memory, nothing else."""

    steps: dict[int, StepRecord] = field(default_factory=dict)
    conclusions: dict[int, ConclusionRecord] = field(default_factory=dict)

    async def record_event(self, event: Event) -> None:
        """Drop an event."""

    async def record_frame(self, step: int, frame: Capture) -> None:
        """Drop a frame."""

    async def record_picture(self, picture: Picture) -> None:
        """Drop a raster."""

    async def record_step(self, step: StepRecord, strategy_state: Mapping[str, object]) -> None:  # noqa: ARG002
        """Keep a step."""
        self.steps[step.step] = step

    async def record_search(self, search: SearchRecord) -> None:
        """Drop the settings."""

    async def record_decision(self, decision: DecisionRecord) -> None:
        """Drop what a decision depended on."""

    async def record_conclusion(self, conclusion: ConclusionRecord) -> None:
        """Keep a conclusion."""
        self.conclusions[conclusion.step] = conclusion

    async def record_action(self, action: ActionRecord) -> None:
        """Drop an action."""

    async def record_settings(self, settings: SettingsRecord) -> None:
        """Drop the settings of a vehicle."""

    async def record_outcome(self, outcome: OutcomeRecord) -> None:
        """Drop the outcome."""

    async def flush(self, *, frames: bool = True) -> None:
        """Return at once."""


@dataclass(frozen=True, slots=True, eq=False)
class FlownMission:
    """A mission that has ended."""

    snapshot: MissionSnapshot
    """The state at its end."""
    steps: tuple[StepRecord, ...]
    conclusions: Mapping[int, ConclusionRecord]
    """What was concluded, by step."""


def mission_settings(
    flight: Flight,
    vehicles: int,
    strategy: str,
    seed: int,
    *,
    ground: Path | None = None,
    spacing: Spacing = USUAL,
    follow: bool = False,
    search: SearchSettings | None = None,
) -> MissionSettings:
    """Return the settings of an unattended search of a simulated area; what is not named is as in every mission.

    Layers count from the origin: over relief they are as much higher as the area's highest ground, or, where a mission
    knows its ground, as the highest below all that it flies over.

    Args:
        flight: the world.
        vehicles: number of vehicles.
        strategy: name of the swarm's strategy.
        seed: of the strategy's draws.
        ground: elevation model that the mission knows; None: the ground counts as level.
        spacing: how far apart the vehicles fly.
        follow: whether the layers follow the ground that the mission knows.
        search: how the area is searched; None: as by default.
    """
    usual = FlightSettings()
    settings = MissionSettings(
        vehicles=vehicles,
        any_vehicles=True,
        area_enu_m=flight.area_enu_m,
        imaging=ImagingSettings(),
        origin=flight.origin,
        strategy=strategy,
        seed=seed,
        flight=replace(
            usual,
            lowest_layer_m=usual.lowest_layer_m + flight.highest_ground_m,
            layer_spacing_m=spacing.layers_m,
        ),
        search=SearchSettings() if search is None else search,
        preflight=PreflightSettings(
            upload_fence=True, set_return_height=ground is not None, overrides=spacing.overrides
        ),
        uncertainty=_uncertainty(spacing),
        registration=RegistrationSettings(enabled=spacing.accuracy_m is not None),
        auto_start=True,
        auto_return=True,
    )
    return settings if ground is None else above_ground(settings, ground, follow=follow)


def search_settings(mode: str) -> SearchSettings | None:
    """Return the settings of a search mode by its name; None for an empty one: those by default.

    ``split`` is the continuous one in which vehicles that are not needed for a close look scan on.

    Raises:
        ConfigurationError: there is no such mode.
    """
    if not mode:
        return None
    if mode == SPLIT:
        return SearchSettings(split=True)
    try:
        return SearchSettings(SearchMode(mode))
    except ValueError as error:
        raise ConfigurationError(f"--search must be one of {', '.join((*SearchMode, SPLIT))}, got {mode!r}.") from error


def _uncertainty(spacing: Spacing) -> Uncertainty:
    if spacing.accuracy_m is None:
        return Uncertainty()
    horizontal_m, vertical_m = spacing.accuracy_m
    return Uncertainty(position_horizontal_m=horizontal_m, position_vertical_m=vertical_m)


def fly(
    flight: Flight, settings: MissionSettings, trace: StepTrace | None = None, *, legs: Sequence[ScanLeg] = ()
) -> FlownMission:
    """Fly a mission from the launch to the last landing; a flight can be flown once.

    Args:
        flight: the world, with its vehicles.
        settings: settings of the mission.
        trace: recorder of the mission, where more is needed than steps and conclusions; None: these alone.
        legs: legs that are known before the start and flown in this order; none: the mission plans its own.

    Raises:
        ConfigurationError: the settings do not fit together.
    """
    return run(_fly(flight, settings, StepTrace() if trace is None else trace, legs))


async def _fly(flight: Flight, settings: MissionSettings, trace: StepTrace, legs: Sequence[ScanLeg]) -> FlownMission:
    clock = LoopClock()
    journal = Journal(clock)
    mission = Coordinator(
        f"virtual-{settings.seed}",
        settings,
        fleet=flight.fleet(clock),
        clock=clock,
        journal=journal,
        recorder=trace,
        loop_monitor=LoopMonitor(period_s=0.5),
        imaging=InlineWorker(),
        pictures=False,
    )
    mission.sortie.search.decider.progress.plan(legs)
    async with journal.recorded(trace):
        await mission.run()
    steps = tuple(trace.steps[number] for number in sorted(trace.steps))
    return FlownMission(mission.view.snapshot(), steps, trace.conclusions)
