"""The parameters of PX4 (https://docs.px4.io/main/en/advanced_config/parameter_reference.html), 1.14 and newer."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aos_drivers.vehicle.autopilots.setup import Found, Setup, after_silence, rally_safeguard, setting
from aos_drivers.vehicle.parameters.encoding import ParameterEncoding
from aos_gcs.ports import Safeguard

_LINK_LOSS: Mapping[int, str] = MappingProxyType({1: "hold", 2: "return", 3: "land"})
_LOW_BATTERY: Mapping[int, str] = MappingProxyType(
    {1: "return when critical", 2: "land when critical", 3: "return when critical, land when nearly empty"}
)
_AT_FENCE: Mapping[int, str] = MappingProxyType({2: "hold", 3: "return", 5: "land"})
_HOLD = 2
_FALLS: Mapping[int, str] = MappingProxyType({5: "terminate", 6: "disarm"})
"""Actions at a lost link that stop the motors in the air."""
_TERMINATE = 4
"""Action at the geofence that does."""
_EXCEPT_HOLD = 1 << 1
"""Bit of COM_DLL_EXCEPT: we fly in Hold."""
_LINK_LOSS_S = 10.0


class Px4Setup(Setup):
    """See the base class."""

    encoding = ParameterEncoding.BYTEWISE
    required = (
        ("NAV_DLL_ACT",),
        ("COM_DL_LOSS_T",),
        ("COM_LOW_BAT_ACT",),
        ("GF_ACTION",),
        ("GF_MAX_VER_DIST",),
        ("GF_MAX_HOR_DIST",),
        ("RTL_RETURN_ALT",),
        ("RTL_TYPE",),
        ("NAV_RCL_ACT",),
    )
    optional = ("COM_DLL_EXCEPT",)

    def link_loss(self, found: Found, our_system_id: int) -> Safeguard:
        """See the base class. It counts the heartbeats of every ground station."""
        del our_system_id
        action = round(found["NAV_DLL_ACT"].value)
        text = setting(found, "NAV_DLL_ACT")
        if not action:
            return Safeguard(False, f"none ({text})", "set NAV_DLL_ACT to 2 (return)")
        if action in _FALLS:
            return Safeguard(False, f"{_FALLS[action]} ({text})", "set NAV_DLL_ACT to 2 (return)")
        if "COM_DLL_EXCEPT" in found and round(found["COM_DLL_EXCEPT"].value) & _EXCEPT_HOLD:
            except_text = setting(found, "COM_DLL_EXCEPT")
            return Safeguard(False, f"not in Hold, in which it flies ({except_text})", "set COM_DLL_EXCEPT to 0")
        described = _LINK_LOSS.get(action, f"action {action}")
        return after_silence(described, found, ("NAV_DLL_ACT", "COM_DL_LOSS_T"), _LINK_LOSS_S)

    def arming_checks(self, found: Found) -> Safeguard:
        """See the base class. PX4 has no switch for all of them."""
        del found
        return Safeguard(True, "on")

    def other_failsafes(self, found: Found) -> Safeguard:
        """See the base class. Without a position estimate PX4 always descends."""
        action, text = round(found["NAV_RCL_ACT"].value), setting(found, "NAV_RCL_ACT")
        if action in _FALLS:
            return Safeguard(False, f"remote control lost: {_FALLS[action]} ({text})", "set NAV_RCL_ACT to 2 (return)")
        return Safeguard(True, f"position lost: descend, remote control lost: {text}")

    def return_place(self, found: Found, rally_points: int) -> Safeguard:
        """See the base class. Types other than 0 follow a mission, or end where one lands."""
        text = setting(found, "RTL_TYPE")
        if found["RTL_TYPE"].value:
            return Safeguard(False, f"where a mission may end ({text})", "set RTL_TYPE to 0 (launch point)")
        return rally_safeguard(rally_points) or Safeguard(True, f"its launch point ({text})")

    def low_battery(self, found: Found) -> Safeguard:
        """See the base class."""
        action = round(found["COM_LOW_BAT_ACT"].value)
        text = setting(found, "COM_LOW_BAT_ACT")
        if not action:
            return Safeguard(False, f"a warning only ({text})", "set COM_LOW_BAT_ACT to 3 (return, then land)")
        return Safeguard(True, f"{_LOW_BATTERY.get(action, f'action {action}')} ({text})")

    def at_fence(self, found: Found) -> Safeguard:
        """See the base class."""
        action = round(found["GF_ACTION"].value)
        text = setting(found, "GF_ACTION")
        if action == _TERMINATE:
            return Safeguard(False, f"terminate ({text})", "set GF_ACTION to 2 (hold)")
        if action < _HOLD:
            return Safeguard(False, f"{'a warning only' if action else 'none'} ({text})", "set GF_ACTION to 2 (hold)")
        return Safeguard(True, f"{_AT_FENCE.get(action, f'action {action}')} ({text})")

    def ceiling_m(self, found: Found) -> float | None:
        """See the base class; 0 means no limit."""
        return found["GF_MAX_VER_DIST"].value or None

    def radius_m(self, found: Found) -> float | None:
        """See the base class; 0 means no limit."""
        return found["GF_MAX_HOR_DIST"].value or None

    def return_height_m(self, found: Found) -> float:
        """See the base class."""
        return found["RTL_RETURN_ALT"].value

    def return_climb_m(self, found: Found) -> float:
        """See the base class; PX4 has nothing like it."""
        del found
        return 0.0

    def return_parameters(self, found: Found, height_m: float) -> dict[str, float]:
        """See the base class. Near home RTL_CONE_ANG has it climb less, which is left to its owner."""
        del found
        return {"RTL_RETURN_ALT": height_m}

    def fence_parameters(self, found: Found, ceiling_m: float | None) -> dict[str, float]:
        """See the base class."""
        action = found["GF_ACTION"].value
        return {
            "GF_MAX_VER_DIST": ceiling_m or 0.0,
            "GF_MAX_HOR_DIST": 0.0,
            "GF_ACTION": action if action in _AT_FENCE else float(_HOLD),
        }
