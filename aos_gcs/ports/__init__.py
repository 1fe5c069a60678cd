"""Ports of the core to the world outside: vehicles with cameras, links, clocks, workers.

Drivers implement these protocols and the coordinator depends on nothing else, so that simulated, SITL and real
vehicles are flown by the same code. Everything that crosses is frozen data. Times are clock seconds (``Clock.now_s``)
unless a name says ``utc``.
"""

from aos_gcs.ports.capture import Capture, IntervalCaptures
from aos_gcs.ports.clock import Clock
from aos_gcs.ports.commands import Arm, Command, Disarm, Goto, Hold, Land, ReturnToLaunch, Takeoff
from aos_gcs.ports.driver import Driver, DriverContext, Fleet, FormerLinks, Notice, Severity
from aos_gcs.ports.setup import Geofence, LatLon, Safeguard, VehicleFacts
from aos_gcs.ports.telemetry import (
    CameraState,
    ComponentLink,
    FlightMode,
    LandedState,
    LinkQuality,
    ProvenLink,
    VehicleState,
)
from aos_gcs.ports.vehicle import Vehicle
from aos_gcs.ports.worker import ThreadWorker, Worker

__all__ = [
    "Arm",
    "CameraState",
    "Capture",
    "Clock",
    "Command",
    "ComponentLink",
    "Disarm",
    "Driver",
    "DriverContext",
    "Fleet",
    "FlightMode",
    "FormerLinks",
    "Geofence",
    "Goto",
    "Hold",
    "IntervalCaptures",
    "Land",
    "LandedState",
    "LatLon",
    "LinkQuality",
    "Notice",
    "ProvenLink",
    "ReturnToLaunch",
    "Safeguard",
    "Severity",
    "Takeoff",
    "ThreadWorker",
    "Vehicle",
    "VehicleFacts",
    "VehicleState",
    "Worker",
]
