"""The parameters of ArduCopter (https://ardupilot.org/copter/docs/parameters.html), 4.1 and newer."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aos_drivers.vehicle.autopilots.setup import Found, Setup, after_silence, first_of, rally_safeguard, setting
from aos_drivers.vehicle.parameters.encoding import ParameterEncoding
from aos_gcs.ports import Safeguard

_ALTITUDE, _CIRCLE, _POLYGON = 1, 2, 4
"""Bits of FENCE_TYPE."""
_RETURN_OR_LAND = 1
_TIMEOUT_S = 5.0
"""Time-out of versions without FS_GCS_TIMEOUT."""
_LINK_LOSS: Mapping[int, str] = MappingProxyType(
    {
        1: "return",
        2: "return",
        3: "return on its own path",
        4: "return on its own path, or land",
        5: "land",
        6: "land as its mission says, or return",
        7: "stop, or land",
    }
)
_ALL = {"ARMING_SKIPCHK": "set ARMING_SKIPCHK to 0", "ARMING_CHECK": "set ARMING_CHECK to 1 (all)"}
_POSITION_LOST = frozenset({1, 3})
"""Values of FS_EKF_ACTION that land: without a pilot, ALT_HOLD drifts."""
_TERMINATE = 5
_LOW_BATTERY: Mapping[int, str] = MappingProxyType(
    {
        1: "land",
        2: "return",
        3: "return on its own path",
        4: "return on its own path, or land",
        6: "land as its mission says, or return",
        7: "stop, or land",
    }
)
_AT_FENCE: Mapping[int, str] = MappingProxyType(
    {
        1: "return, or land",
        2: "land",
        3: "return on its own path",
        4: "stop, or land",
        5: "return on its own path, or land",
    }
)


class ArduCopterSetup(Setup):
    """See the base class."""

    encoding = ParameterEncoding.CAST
    required = (
        ("FS_GCS_ENABLE",),
        ("MAV_GCS_SYSID", "SYSID_MYGCS"),
        ("MAV_GCS_SYSID_HI", "SYSID_MYGCS"),
        ("BATT_MONITOR",),
        ("ARMING_CHECK", "ARMING_SKIPCHK"),
        ("FS_EKF_ACTION",),
        ("FS_EKF_THRESH",),
        ("FS_THR_ENABLE",),
        ("FENCE_ENABLE",),
        ("FENCE_TYPE",),
        ("FENCE_ACTION",),
        ("FENCE_ALT_MAX",),
        ("FENCE_RADIUS",),
        ("RTL_ALT", "RTL_ALT_M"),
        ("RTL_CLIMB_MIN", "RTL_CLIMB_MIN_M"),
    )
    optional = ("FS_GCS_TIMEOUT",)

    def further(self, found: Found) -> tuple[tuple[str, ...], ...]:
        """See the base class. Without a monitor, the other parameters of the battery do not exist."""
        if not found["BATT_MONITOR"].value:
            return ()
        return ("BATT_FS_LOW_ACT",), ("BATT_LOW_VOLT",), ("BATT_LOW_MAH",)

    def link_loss(self, found: Found, our_system_id: int) -> Safeguard:
        """See the base class. It counts the heartbeats of certain system ids only."""
        action = round(found["FS_GCS_ENABLE"].value)
        text = setting(found, "FS_GCS_ENABLE")
        if not action:
            return Safeguard(False, f"none ({text})", "set FS_GCS_ENABLE to 1 (return)")
        lowest_name = first_of(found, "MAV_GCS_SYSID", "SYSID_MYGCS")
        lowest = round(found[lowest_name].value)
        highest = round(found["MAV_GCS_SYSID_HI"].value) if "MAV_GCS_SYSID_HI" in found else lowest
        if not lowest <= our_system_id <= max(lowest, highest):
            ids = f"{lowest}" if highest <= lowest else f"{lowest} to {highest}"
            return Safeguard(
                False,
                f"when ids {ids} fall silent, not ours, {our_system_id}",
                f"set {lowest_name} to {our_system_id}, or our own id to {lowest}",
            )
        return after_silence(_LINK_LOSS.get(action, "return"), found, ("FS_GCS_ENABLE", "FS_GCS_TIMEOUT"), _TIMEOUT_S)

    def arming_checks(self, found: Found) -> Safeguard:
        """See the base class. Up to 4.6 a bit, or 1, switches checks on; since 4.7 a bit switches one off."""
        name = first_of(found, "ARMING_SKIPCHK", "ARMING_CHECK")
        value, text = round(found[name].value), setting(found, name)
        if name == "ARMING_SKIPCHK":
            return Safeguard(True, f"all ({text})") if not value else Safeguard(False, f"some off ({text})", _ALL[name])
        if value & 1:
            return Safeguard(True, f"all ({text})")
        return Safeguard(False, f"{'some' if value else 'all'} off ({text})", _ALL[name])

    def other_failsafes(self, found: Found) -> Safeguard:
        """See the base class. Without a remote control there is none that can be lost."""
        ekf, remote = setting(found, "FS_EKF_ACTION"), setting(found, "FS_THR_ENABLE")
        if found["FS_EKF_THRESH"].value <= 0.0:
            return Safeguard(
                False, f"position lost: none ({setting(found, 'FS_EKF_THRESH')})", "set FS_EKF_THRESH to 0.8"
            )
        if round(found["FS_EKF_ACTION"].value) not in _POSITION_LOST:
            return Safeguard(False, f"position lost: does not land ({ekf})", "set FS_EKF_ACTION to 1 (land)")
        return Safeguard(True, f"position lost: land ({ekf}), remote control lost: {remote}")

    def return_place(self, found: Found, rally_points: int) -> Safeguard:
        """See the base class."""
        del found
        return rally_safeguard(rally_points) or Safeguard(True, "its launch point")

    def low_battery(self, found: Found) -> Safeguard:
        """See the base class. It needs a monitor, an action and a threshold."""
        if "BATT_FS_LOW_ACT" not in found:
            return Safeguard(False, "none: no battery monitor (BATT_MONITOR = 0)", "set BATT_MONITOR to its sensor")
        action = round(found["BATT_FS_LOW_ACT"].value)
        if action == _TERMINATE:
            return Safeguard(
                False, f"terminate ({setting(found, 'BATT_FS_LOW_ACT')})", "set BATT_FS_LOW_ACT to 2 (return)"
            )
        thresholds = [name for name in ("BATT_LOW_VOLT", "BATT_LOW_MAH") if name in found and found[name].value > 0.0]
        if not action:
            return Safeguard(False, "none (BATT_FS_LOW_ACT)", "set BATT_FS_LOW_ACT to 2 (return)")
        if not thresholds:
            return Safeguard(False, "none without a threshold", "set BATT_LOW_VOLT or BATT_LOW_MAH")
        at = " or ".join(setting(found, name) for name in thresholds)
        return Safeguard(True, f"{_LOW_BATTERY.get(action, f'action {action}')} at {at}")

    def at_fence(self, found: Found) -> Safeguard:
        """See the base class."""
        if not found["FENCE_ENABLE"].value:
            return Safeguard(False, f"none ({setting(found, 'FENCE_ENABLE')})", "set FENCE_ENABLE to 1")
        if not round(found["FENCE_TYPE"].value) & _POLYGON:
            return Safeguard(False, f"none ({setting(found, 'FENCE_TYPE')})", "set FENCE_TYPE to 5 (height, polygons)")
        action = round(found["FENCE_ACTION"].value)
        if not action:
            return Safeguard(False, f"report only ({setting(found, 'FENCE_ACTION')})", "set FENCE_ACTION to 1 (return)")
        return Safeguard(True, f"{_AT_FENCE.get(action, 'return')} ({setting(found, 'FENCE_ACTION')})")

    def ceiling_m(self, found: Found) -> float | None:
        """See the base class."""
        return found["FENCE_ALT_MAX"].value if round(found["FENCE_TYPE"].value) & _ALTITUDE else None

    def radius_m(self, found: Found) -> float | None:
        """See the base class."""
        return found["FENCE_RADIUS"].value if round(found["FENCE_TYPE"].value) & _CIRCLE else None

    def return_height_m(self, found: Found) -> float:
        """See the base class."""
        return found["RTL_ALT_M"].value if "RTL_ALT_M" in found else found["RTL_ALT"].value / 100.0

    def return_climb_m(self, found: Found) -> float:
        """See the base class."""
        return found["RTL_CLIMB_MIN_M"].value if "RTL_CLIMB_MIN_M" in found else found["RTL_CLIMB_MIN"].value / 100.0

    def return_parameters(self, found: Found, height_m: float) -> dict[str, float]:
        """See the base class. Near home RTL_CONE_SLOPE has it climb less, which is left to its owner."""
        height_name, climb_name = (
            first_of(found, "RTL_ALT_M", "RTL_ALT"),
            first_of(found, "RTL_CLIMB_MIN_M", "RTL_CLIMB_MIN"),
        )
        height = height_m if height_name == "RTL_ALT_M" else float(round(100.0 * height_m))
        return {height_name: height, climb_name: 0.0}

    def fence_parameters(self, found: Found, ceiling_m: float | None) -> dict[str, float]:
        """See the base class. A lowest height, bit 8 of FENCE_TYPE, is left to its owner."""
        kinds = round(found["FENCE_TYPE"].value) & ~(_ALTITUDE | _CIRCLE) | _POLYGON
        values = {
            "FENCE_TYPE": float(kinds if ceiling_m is None else kinds | _ALTITUDE),
            "FENCE_ACTION": found["FENCE_ACTION"].value or float(_RETURN_OR_LAND),
            "FENCE_ENABLE": 1.0,
        }
        return values if ceiling_m is None else {"FENCE_ALT_MAX": ceiling_m, **values}
