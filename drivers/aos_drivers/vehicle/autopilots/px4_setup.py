"""The parameters of PX4 (https://docs.px4.io/main/en/advanced_config/parameter_reference.html), 1.14 and newer."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aos_drivers.vehicle.autopilots.setup import Found, Setup, setting
from aos_drivers.vehicle.parameters.encoding import ParameterEncoding
from aos_gcs.ports import Safeguard

_LINK_LOSS: Mapping[int, str] = MappingProxyType({1: "hold", 2: "return", 3: "land", 5: "terminate", 6: "disarm"})
_LOW_BATTERY: Mapping[int, str] = MappingProxyType(
    {1: "return when critical", 2: "land when critical", 3: "return when critical, land when nearly empty"}
)
_AT_FENCE: Mapping[int, str] = MappingProxyType({2: "hold", 3: "return", 4: "terminate", 5: "land"})
_HOLD = 2


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
    )

    def link_loss(self, found: Found, our_system_id: int) -> Safeguard:
        """See the base class. It counts the heartbeats of every ground station."""
        del our_system_id
        action = round(found["NAV_DLL_ACT"].value)
        text = setting(found, "NAV_DLL_ACT")
        if not action:
            return Safeguard(False, f"none ({text})", "set NAV_DLL_ACT to 2 (return)")
        after = f"after {found['COM_DL_LOSS_T'].value:g} s"
        return Safeguard(True, f"{_LINK_LOSS.get(action, f'action {action}')} {after} ({text})")

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
            "GF_ACTION": action if action >= _HOLD else float(_HOLD),
        }
