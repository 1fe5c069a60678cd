"""The coordinator as operators' actions and commands see it."""

from __future__ import annotations

from typing import Protocol

from aos_gcs.mission.model.phase import Phase, Suspension
from aos_gcs.mission.sortie import Sortie
from aos_gcs.planning.settings import MissionSettings


class PlannedFlow(Protocol):
    """Phases of a mission and the plan that it flies by."""

    @property
    def sortie(self) -> Sortie:
        """The sortie by the present plan."""
        ...

    @property
    def heading(self) -> Phase:
        """The phase that the mission is in, or changes to by an action just taken."""
        ...

    def follow_plan(self, settings: MissionSettings) -> None:
        """Fly by other settings."""
        ...


class Flow(PlannedFlow, Protocol):
    """Changes of the flow of phases that an action may cause."""

    @property
    def suspension(self) -> Suspension:
        """Why no steps are made at present."""
        ...

    def redirect(self, phase: Phase) -> None:
        """End the present handler and go on with ``phase``."""
        ...

    def suspend(self, suspension: Suspension) -> None:
        """Make no further step."""
        ...

    def resume(self) -> None:
        """Go on where the mission was suspended."""
        ...

    def abort(self) -> None:
        """Note that an operator has aborted the mission."""
        ...

    def begin_new_sortie(self) -> None:
        """Make room for another sortie: this mission is over."""
        ...
