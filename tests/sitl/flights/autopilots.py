"""Real autopilots in software, started as docs/sitl.md says, each in a folder of its own."""

from __future__ import annotations

import math
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

PROGRAM = (sys.executable, "-m", "aos_gcs")
HERE = Path(__file__).resolve().parent
LATITUDE_DEG, LONGITUDE_DEG, ALTITUDE_AMSL_M = 48.3, 14.3, 260.0
PLACES_DEG = (14.29989, 14.30000, 14.30011, 14.30022)
"""Longitudes of the launch points, 8 m apart; the last one is for a vehicle too many."""
M_PER_DEG = 111_195.0
"""Metres per degree of latitude."""
STOP_S = 5.0
COPTER_LOITER = 5
"""ArduCopter's mode of a pilot who flies by the sticks."""
ANOTHER_STATION = (255, 190)
"""System and component id by which a pilot's station speaks."""
NOWHERE = 2**31 - 1
"""Latitude or longitude that a command does not name."""


@dataclass(frozen=True)
class Offsets:
    """Errors of one vehicle's altitude."""

    receiver_m: float = 0.0
    barometer_drift_mps: float = 0.0


@dataclass(frozen=True)
class Start:
    """A command line with its environment and files, by their names, in its folder."""

    arguments: Sequence[str]
    environment: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class ArduCopter:
    """ArduCopter's SITL."""

    binary: Path
    name: str = "arducopter"
    station_link: str = "udpin://127.0.0.1:14560"
    """Address to which all instances send."""
    api_port: int = 8098
    layer_spacing_m: float = 3.5
    measures_ground: bool = True
    """Whether its receivers report an RTK fix, from which the station knows the height of the ground below each."""

    def camera_links(self, count: int) -> list[str]:
        """Return the second port of each instance."""
        return [f"tcpout://127.0.0.1:{5762 + 10 * instance}" for instance in range(count)]

    def command(self, instance: int, system_id: int, home: tuple[float, float, float], offsets: Offsets) -> Start:
        """Return the command line of an instance."""
        place = ",".join(f"{value:.7f}" for value in home)
        arguments = [str(self.binary), "--model", "quad", "--speedup", "1", "--instance", str(instance), "--wipe"]
        arguments += ["--sysid", str(system_id), "--home", f"{place},0"]
        arguments += ["--serial0", f"udpclient:{self.station_link.removeprefix('udpin://')}"]
        arguments += ["--defaults", f"{HERE / 'copter.parm'},errors.parm"]
        errors = f"SIM_GPS1_ALT_OFS {offsets.receiver_m}\nSIM_BARO_DRIFT {offsets.barometer_drift_mps}\n"
        return Start(arguments, files={"errors.parm": errors})

    def take_over(self, instance: int) -> None:
        """Select the mode LOITER on the third port of an instance."""
        self.tell(
            instance,
            mavlink.MAVLink_set_mode_message(instance + 1, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, COPTER_LOITER),
        )

    def tell(self, instance: int, message: mavlink.MAVLink_message) -> None:
        """Send a message of another station to an instance, several times."""
        with socket.create_connection(("127.0.0.1", 5763 + 10 * instance), timeout=5.0) as link:
            for _ in range(5):
                link.sendall(message.pack(mavlink.MAVLink(None, *ANOTHER_STATION)))
                time.sleep(0.2)


@dataclass(frozen=True)
class Px4:
    """PX4's SITL with its own quadrotor (SIH)."""

    build: Path
    name: str = "px4"
    station_link: str = "udpin://127.0.0.1:14550"
    api_port: int = 8099
    layer_spacing_m: float = 8.0
    measures_ground: bool = False

    def camera_links(self, count: int) -> list[str]:
        """Return the port that each instance sends to for a companion computer."""
        return [f"udpin://127.0.0.1:{14540 + instance}" for instance in range(count)]

    def command(self, instance: int, system_id: int, home: tuple[float, float, float], offsets: Offsets) -> Start:
        """Return the command line of an instance; its receiver's error is a home that lies higher.

        PX4's start script gives each instance an id of its own: with another one, it is our own simulated PX4.
        """
        latitude_deg, longitude_deg, altitude_m = home
        if system_id != instance + 1:
            arguments = [*PROGRAM, "sim", "--vehicles", "1", "--autopilot", "px4", "--first-system-id", str(system_id)]
            arguments += ["--origin", f"{latitude_deg},{longitude_deg},{altitude_m}", "--no-render"]
            return Start([*arguments, "--link", self.station_link.replace("udpin", "udpout")])
        parameters = dict(line.split() for line in _lines(HERE / "px4.parm"))
        environment = {f"PX4_PARAM_{name}": value for name, value in parameters.items()}
        environment |= {"PX4_SYS_AUTOSTART": "10040", "PX4_SIMULATOR": "sihsim", "PX4_SIM_MODEL": "sihsim_quadx"}
        environment |= {"PX4_HOME_LAT": f"{latitude_deg}", "PX4_HOME_LON": f"{longitude_deg}"}
        environment |= {"PX4_HOME_ALT": f"{altitude_m + offsets.receiver_m}"}
        return Start([str(self.build / "bin/px4"), "-d", "-i", str(instance), str(self.build / "etc")], environment)

    def take_over(self, instance: int) -> None:
        """Stop an instance where it is, by DO_REPOSITION to no other place, as stations do for *pause*."""
        stop = mavlink.MAVLink_command_int_message(
            *(instance + 1, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_REPOSITION, 0, 0),
            *(-1.0, float(mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE), 0.0, math.nan, NOWHERE, NOWHERE, math.nan),
        )
        self.tell(instance, stop)

    def tell(self, instance: int, message: mavlink.MAVLink_message) -> None:
        """Send a message of another station to an instance."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            link.sendto(message.pack(mavlink.MAVLink(None, *ANOTHER_STATION)), ("127.0.0.1", 18570 + instance))


Kind: TypeAlias = ArduCopter | Px4
"""An autopilot that can be started."""


class Autopilots:
    """Instances that run; leaving the context ends those, and only those."""

    def __init__(self, kind: Kind, folder: Path) -> None:
        self.kind = kind
        self._folder = folder
        self._running: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Autopilots:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._running:
            process.terminate()
        for process in self._running:
            try:
                process.wait(STOP_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def start(self, system_id: int | None = None, offsets: Offsets | None = None) -> None:
        """Start the next instance; without a system id it gets that of its place."""
        instance = len(self._running)
        folder = self._folder / f"{self.kind.name}-{instance}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        home = (LATITUDE_DEG, PLACES_DEG[instance], ALTITUDE_AMSL_M)
        start = self.kind.command(instance, system_id or instance + 1, home, offsets or Offsets())
        for name, text in start.files.items():
            (folder / name).write_text(text, encoding="utf-8")
        with (folder / "output.log").open("wb") as output:
            self._running.append(
                subprocess.Popen(  # noqa: S603 - the binary that the caller names
                    start.arguments,
                    cwd=folder,
                    env=os.environ | dict(start.environment),
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                )
            )

    def take_over(self, instance: int) -> None:
        """Fly an instance as a pilot or another station does, by its own way of letting them."""
        self.kind.take_over(instance)

    def set_home(self, instance: int, east_m: float) -> None:
        """Set the home of an instance so far east of where it was started, as another station does."""
        longitude_deg = PLACES_DEG[instance] + east_m / (M_PER_DEG * math.cos(math.radians(LATITUDE_DEG)))
        home = mavlink.MAVLink_command_int_message(
            *(instance + 1, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_SET_HOME, 0, 0),
            *(0.0, 0.0, 0.0, math.nan, round(LATITUDE_DEG * 1e7), round(longitude_deg * 1e7), ALTITUDE_AMSL_M),
        )
        self.kind.tell(instance, home)

    def dead(self) -> list[int]:
        """Return the instances that have ended by themselves."""
        return [instance for instance, process in enumerate(self._running) if process.poll() is not None]


def _lines(path: Path) -> list[str]:
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line.strip() and not line.startswith("#")]
