"""Telemetry messages: pure functions from one vehicle's readings to MAVLink."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import LocalFrame
from aos_sim.clock import SimTime
from aos_sim.vehicle.battery import CELLS
from aos_sim.vehicle.kinematics import EnuPoint, Kinematics

UNKNOWN_U8 = 255
UNKNOWN_U16 = 65535
RANGEFINDER_CM = (20, 5000)
"""Least and greatest distance that rangefinders measure."""
GPS_FIX_AFTER_S = 2.0
SATELLITES = 18
SEA_LEVEL_HPA = 1013.25
ATMOSPHERE_M = 44330.77
ATMOSPHERE_EXPONENT = 5.25588
"""Constants of the standard atmosphere."""

POSITION_ONLY_TYPE_MASK = (
    mavlink.POSITION_TARGET_TYPEMASK_VX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
)

SENSORS = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    | mavlink.MAV_SYS_STATUS_AHRS
    | mavlink.MAV_SYS_STATUS_PREARM_CHECK
)


@dataclass(frozen=True, slots=True)
class Readings:
    """Everything that telemetry tells of one vehicle at one instant."""

    now: SimTime
    kinematics: Kinematics
    home_enu_m: EnuPoint
    target_enu_m: EnuPoint
    frame: LocalFrame
    airborne: bool
    landed_state: int
    ready_to_arm: bool
    position_known: bool
    """The estimator has a position."""
    fence_breached: bool
    voltage_v: float
    current_a: float
    consumed_mah: float
    remaining: float

    @property
    def gps_fixed(self) -> bool:
        """Whether the receiver has a fix."""
        return self.now.s >= GPS_FIX_AFTER_S


def degrees_e7(angle_deg: float) -> int:
    """Return MAVLink's integer of a latitude or longitude."""
    return round(angle_deg * 1e7)


def global_position_int(readings: Readings) -> mavlink.MAVLink_message:
    """GLOBAL_POSITION_INT; zeros until the estimator has a position, as real autopilots send."""
    kinematics = readings.kinematics
    if not readings.position_known:
        return mavlink.MAVLink_global_position_int_message(readings.now.boot_ms, 0, 0, 0, 0, 0, 0, 0, UNKNOWN_U16)
    east_mps, north_mps, up_mps = kinematics.velocity_enu_mps
    geodetic = kinematics.geodetic
    return mavlink.MAVLink_global_position_int_message(
        time_boot_ms=readings.now.boot_ms,
        lat=degrees_e7(geodetic.latitude_deg),
        lon=degrees_e7(geodetic.longitude_deg),
        alt=round(geodetic.altitude_amsl_m * 1e3),
        relative_alt=round((kinematics.position_enu_m[2] - readings.home_enu_m[2]) * 1e3),
        vx=round(north_mps * 100),
        vy=round(east_mps * 100),
        vz=round(-up_mps * 100),
        hdg=round(math.degrees(kinematics.heading_rad) * 100) % 36000,
    )


def local_position_ned(readings: Readings) -> mavlink.MAVLink_message:
    """LOCAL_POSITION_NED about home."""
    home, here = readings.home_enu_m, readings.kinematics.position_enu_m
    east_mps, north_mps, up_mps = readings.kinematics.velocity_enu_mps
    return mavlink.MAVLink_local_position_ned_message(
        readings.now.boot_ms, here[1] - home[1], here[0] - home[0], home[2] - here[2], north_mps, east_mps, -up_mps
    )


def gps_raw_int(readings: Readings) -> mavlink.MAVLink_message:
    """GPS_RAW_INT of a receiver with the errors of this vehicle's."""
    fixed = readings.gps_fixed
    geodetic, errors = readings.kinematics.receiver_geodetic, readings.kinematics.errors
    horizontal_m, vertical_m = errors.accuracy_m
    east_mps, north_mps, _ = readings.kinematics.velocity_enu_mps
    course_deg = math.degrees(math.atan2(east_mps, north_mps)) % 360.0
    return mavlink.MAVLink_gps_raw_int_message(
        time_usec=readings.now.boot_us,
        fix_type=errors.fix_type if fixed else mavlink.GPS_FIX_TYPE_NO_FIX,
        lat=degrees_e7(geodetic.latitude_deg) if fixed else 0,
        lon=degrees_e7(geodetic.longitude_deg) if fixed else 0,
        alt=round(geodetic.altitude_amsl_m * 1e3) if fixed else 0,
        eph=70 if fixed else UNKNOWN_U16,
        epv=90 if fixed else UNKNOWN_U16,
        vel=round(math.hypot(east_mps, north_mps) * 100),
        cog=round(course_deg * 100) % 36000,
        satellites_visible=SATELLITES if fixed else 0,
        h_acc=round(horizontal_m * 1e3) if fixed else 0,
        v_acc=round(vertical_m * 1e3) if fixed else 0,
    )


def scaled_pressure(readings: Readings) -> mavlink.MAVLink_message:
    """SCALED_PRESSURE of the barometer, in the standard atmosphere."""
    altitude_m = readings.frame.origin.altitude_amsl_m + readings.kinematics.barometer_up_m
    pressure_hpa = SEA_LEVEL_HPA * (1.0 - altitude_m / ATMOSPHERE_M) ** ATMOSPHERE_EXPONENT
    return mavlink.MAVLink_scaled_pressure_message(readings.now.boot_ms, pressure_hpa, 0.0, 2500)


def distance_sensor(readings: Readings) -> mavlink.MAVLink_message:
    """DISTANCE_SENSOR of a rangefinder that looks down; what is out of its reach is one step beyond it."""
    return mavlink.MAVLink_distance_sensor_message(
        time_boot_ms=readings.now.boot_ms,
        min_distance=RANGEFINDER_CM[0],
        max_distance=RANGEFINDER_CM[1],
        current_distance=min(round(readings.kinematics.range_m * 100), RANGEFINDER_CM[1] + 1),
        type=mavlink.MAV_DISTANCE_SENSOR_LASER,
        id=0,
        orientation=mavlink.MAV_SENSOR_ROTATION_PITCH_270,
        covariance=UNKNOWN_U8,
    )


def attitude(readings: Readings) -> mavlink.MAVLink_message:
    """ATTITUDE."""
    kinematics = readings.kinematics
    yaw_rad = (kinematics.heading_rad + math.pi) % (2 * math.pi) - math.pi
    return mavlink.MAVLink_attitude_message(
        readings.now.boot_ms, kinematics.roll_rad, kinematics.pitch_rad, yaw_rad, *kinematics.rates_radps
    )


def attitude_quaternion(readings: Readings) -> mavlink.MAVLink_message:
    """ATTITUDE_QUATERNION: body forward-right-down to NED."""
    kinematics = readings.kinematics
    quaternion = body_quaternion(kinematics.roll_rad, kinematics.pitch_rad, kinematics.heading_rad)
    return mavlink.MAVLink_attitude_quaternion_message(readings.now.boot_ms, *quaternion, *kinematics.rates_radps)


def body_quaternion(roll_rad: float, pitch_rad: float, yaw_rad: float) -> tuple[float, float, float, float]:
    """Return (w, x, y, z) of body to NED: the rotations about z, y, x; spelt out, as 50 Hz telemetry needs it often."""
    cr, sr = math.cos(roll_rad / 2), math.sin(roll_rad / 2)
    cp, sp = math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
    cy, sy = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def vfr_hud(readings: Readings) -> mavlink.MAVLink_message:
    """VFR_HUD."""
    kinematics = readings.kinematics
    east_mps, north_mps, up_mps = kinematics.velocity_enu_mps
    speed_mps = math.hypot(east_mps, north_mps)
    return mavlink.MAVLink_vfr_hud_message(
        airspeed=speed_mps,
        groundspeed=speed_mps,
        heading=round(math.degrees(kinematics.heading_rad)) % 360,
        throttle=50 if readings.airborne else 0,
        alt=kinematics.geodetic.altitude_amsl_m,
        climb=up_mps,
    )


def sys_status(readings: Readings, present: int = SENSORS) -> mavlink.MAVLink_message:
    """SYS_STATUS; the bit for the pre-arm checks follows ``ready_to_arm``, whether it is ``present`` or not.

    So does that of the fence: ground stations that know it take an unhealthy one for a breach.
    """
    health = SENSORS
    if not readings.fence_breached:
        health |= mavlink.MAV_SYS_STATUS_GEOFENCE
    if not readings.ready_to_arm:
        health &= ~(mavlink.MAV_SYS_STATUS_PREARM_CHECK | mavlink.MAV_SYS_STATUS_AHRS)
    return mavlink.MAVLink_sys_status_message(
        onboard_control_sensors_present=present,
        onboard_control_sensors_enabled=present,
        onboard_control_sensors_health=health,
        load=250,
        voltage_battery=round(readings.voltage_v * 1e3),
        current_battery=round(readings.current_a * 100),
        battery_remaining=round(readings.remaining * 100),
        drop_rate_comm=0,
        errors_comm=0,
        errors_count1=0,
        errors_count2=0,
        errors_count3=0,
        errors_count4=0,
    )


def battery_status(readings: Readings) -> mavlink.MAVLink_message:
    """BATTERY_STATUS with the voltage of each cell."""
    cell_mv = round(readings.voltage_v * 1e3 / CELLS)
    return mavlink.MAVLink_battery_status_message(
        id=0,
        battery_function=mavlink.MAV_BATTERY_FUNCTION_ALL,
        type=mavlink.MAV_BATTERY_TYPE_LIPO,
        temperature=2500,
        voltages=[cell_mv] * CELLS + [UNKNOWN_U16] * (10 - CELLS),
        current_battery=round(readings.current_a * 100),
        current_consumed=round(readings.consumed_mah),
        energy_consumed=-1,
        battery_remaining=round(readings.remaining * 100),
    )


def extended_sys_state(readings: Readings) -> mavlink.MAVLink_message:
    """EXTENDED_SYS_STATE."""
    return mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, readings.landed_state)


def home_position(readings: Readings) -> mavlink.MAVLink_message:
    """HOME_POSITION."""
    home = readings.frame.to_geodetic(readings.home_enu_m)
    return mavlink.MAVLink_home_position_message(
        latitude=degrees_e7(home.latitude_deg),
        longitude=degrees_e7(home.longitude_deg),
        altitude=round(home.altitude_amsl_m * 1e3),
        x=0.0,
        y=0.0,
        z=0.0,
        q=[1.0, 0.0, 0.0, 0.0],
        approach_x=0.0,
        approach_y=0.0,
        approach_z=0.0,
        time_usec=readings.now.boot_us,
    )


def position_target_global_int(readings: Readings) -> mavlink.MAVLink_message:
    """POSITION_TARGET_GLOBAL_INT: where the vehicle is being flown."""
    target = readings.frame.to_geodetic(readings.target_enu_m)
    return mavlink.MAVLink_position_target_global_int_message(
        time_boot_ms=readings.now.boot_ms,
        coordinate_frame=mavlink.MAV_FRAME_GLOBAL_INT,
        type_mask=POSITION_ONLY_TYPE_MASK,
        lat_int=degrees_e7(target.latitude_deg),
        lon_int=degrees_e7(target.longitude_deg),
        alt=target.altitude_amsl_m,
        vx=0.0,
        vy=0.0,
        vz=0.0,
        afx=0.0,
        afy=0.0,
        afz=0.0,
        yaw=0.0,
        yaw_rate=0.0,
    )


def system_time(readings: Readings) -> mavlink.MAVLink_message:
    """SYSTEM_TIME."""
    return mavlink.MAVLink_system_time_message(readings.now.utc_us, readings.now.boot_ms)


ESTIMATOR_FLAGS_WITH_POSITION = 0x33F
"""Attitude, velocities, positions (relative and absolute) and their predictions; bits are EKF_STATUS_FLAGS' as well
as ESTIMATOR_STATUS_FLAGS'."""

ESTIMATOR_FLAGS_WITHOUT_POSITION = 0xA5
"""Attitude, vertical velocity and height; constant-position mode (bit 0x80)."""


def estimator_flags(readings: Readings) -> int:
    """Return the flags of EKF_STATUS_REPORT and ESTIMATOR_STATUS."""
    return ESTIMATOR_FLAGS_WITH_POSITION if readings.position_known else ESTIMATOR_FLAGS_WITHOUT_POSITION


def ekf_status_report(readings: Readings) -> mavlink.MAVLink_message:
    """EKF_STATUS_REPORT (ArduPilot)."""
    return mavlink.MAVLink_ekf_status_report_message(estimator_flags(readings), 0.05, 0.05, 0.05, 0.05, 0.0)


def estimator_status(readings: Readings) -> mavlink.MAVLink_message:
    """ESTIMATOR_STATUS (PX4); the bit of a constant position is set while the vehicle stands on the ground, too."""
    flags = estimator_flags(readings) | (0 if readings.airborne else mavlink.ESTIMATOR_CONST_POS_MODE)
    accuracies_m = readings.kinematics.errors.accuracy_m if readings.position_known else (100.0, 100.0)
    return mavlink.MAVLink_estimator_status_message(
        readings.now.boot_us, flags, 0.05, 0.05, 0.05, 0.05, 0.0, 0.0, *accuracies_m
    )


def vibration(readings: Readings) -> mavlink.MAVLink_message:
    """VIBRATION of a vehicle with balanced propellers."""
    level_mps2 = 8.0 if readings.airborne else 0.2
    return mavlink.MAVLink_vibration_message(readings.now.boot_us, level_mps2, level_mps2, level_mps2, 0, 0, 0)


MessageBuilder = Callable[[Readings], mavlink.MAVLink_message]

COMMON_MESSAGES: Mapping[int, MessageBuilder] = {
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: sys_status,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: system_time,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: gps_raw_int,
    mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: scaled_pressure,
    mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: distance_sensor,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: attitude,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: attitude_quaternion,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: local_position_ned,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: global_position_int,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: vfr_hud,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: position_target_global_int,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: battery_status,
    mavlink.MAVLINK_MSG_ID_VIBRATION: vibration,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: home_position,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: extended_sys_state,
}


def autopilot_version(capabilities: int, flight_sw_version: int, uid: int) -> mavlink.MAVLink_message:
    """Return AUTOPILOT_VERSION with what the simulation knows of it; unknown fields are 0."""
    return mavlink.MAVLink_autopilot_version_message(
        capabilities=capabilities,
        flight_sw_version=flight_sw_version,
        middleware_sw_version=0,
        os_sw_version=0,
        board_version=0,
        flight_custom_version=[0] * 8,
        middleware_custom_version=[0] * 8,
        os_custom_version=[0] * 8,
        vendor_id=0,
        product_id=0,
        uid=uid,
        uid2=list(uid.to_bytes(18, "little")),
    )
