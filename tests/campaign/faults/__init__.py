"""The faults that a campaign draws."""

from __future__ import annotations

from collections.abc import Mapping

from tests.campaign.faults.base import Fault
from tests.campaign.faults.people import OperatorActs, PilotHovers, PilotTakesOver
from tests.campaign.faults.radio import BadRadio, Forgery, LatePackets, LinkCut, Spoofing, Twin
from tests.campaign.faults.sensors import (
    ClockJump,
    HeightReset,
    HeightRunsAway,
    PositionJump,
    ReportedJump,
    WindRises,
)
from tests.campaign.faults.station import Freeze, Kill
from tests.campaign.faults.sweeps import ErraticCameras, HungImaging, Laggard, SlowCamera
from tests.campaign.faults.vehicles import DeadCamera, LowBattery, Reboot

FAULTS: tuple[type[Fault], ...] = (
    BadRadio,
    LatePackets,
    LinkCut,
    Spoofing,
    Forgery,
    Twin,
    WindRises,
    PositionJump,
    HeightReset,
    HeightRunsAway,
    ReportedJump,
    ClockJump,
    LowBattery,
    DeadCamera,
    Reboot,
    PilotTakesOver,
    PilotHovers,
    OperatorActs,
    Freeze,
    Kill,
    SlowCamera,
    ErraticCameras,
    Laggard,
    HungImaging,
)

KNOWN_DEFECTS: Mapping[type[Fault], str] = {}
"""Faults that are not drawn, with the defect that they show."""
