"""The true state, as the simulators of real autopilots tell it on request: both flavours without a time."""

from __future__ import annotations

import math

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.vehicle.telemetry import Readings, body_quaternion, degrees_e7


def sim_state(readings: Readings) -> mavlink.MAVLink_message:
    """SIM_STATE (ArduPilot)."""
    kinematics = readings.kinematics
    geodetic = kinematics.true_geodetic
    latitude_e7, longitude_e7 = degrees_e7(geodetic.latitude_deg), degrees_e7(geodetic.longitude_deg)
    roll_rad, pitch_rad, heading_rad = kinematics.true_attitude_rad
    q_w, q_x, q_y, q_z = body_quaternion(roll_rad, pitch_rad, heading_rad)
    east_mps, north_mps, up_mps = kinematics.velocity_enu_mps
    roll_rate_radps, pitch_rate_radps, yaw_rate_radps = kinematics.rates_radps
    return mavlink.MAVLink_sim_state_message(
        q1=q_w,
        q2=q_x,
        q3=q_y,
        q4=q_z,
        roll=roll_rad,
        pitch=pitch_rad,
        yaw=(heading_rad + math.pi) % (2 * math.pi) - math.pi,
        xacc=0.0,
        yacc=0.0,
        zacc=0.0,
        xgyro=roll_rate_radps,
        ygyro=pitch_rate_radps,
        zgyro=yaw_rate_radps,
        lat=latitude_e7,
        lon=longitude_e7,
        alt=geodetic.altitude_amsl_m,
        std_dev_horz=0.0,
        std_dev_vert=0.0,
        vn=north_mps,
        ve=east_mps,
        vd=-up_mps,
        lat_int=latitude_e7,
        lon_int=longitude_e7,
    )


def hil_state_quaternion(readings: Readings) -> mavlink.MAVLink_message:
    """HIL_STATE_QUATERNION (PX4)."""
    kinematics = readings.kinematics
    geodetic = kinematics.true_geodetic
    east_mps, north_mps, up_mps = kinematics.velocity_enu_mps
    roll_rate_radps, pitch_rate_radps, yaw_rate_radps = kinematics.rates_radps
    return mavlink.MAVLink_hil_state_quaternion_message(
        time_usec=0,
        attitude_quaternion=body_quaternion(*kinematics.true_attitude_rad),
        rollspeed=roll_rate_radps,
        pitchspeed=pitch_rate_radps,
        yawspeed=yaw_rate_radps,
        lat=degrees_e7(geodetic.latitude_deg),
        lon=degrees_e7(geodetic.longitude_deg),
        alt=round(geodetic.altitude_amsl_m * 1e3),
        vx=round(north_mps * 100),
        vy=round(east_mps * 100),
        vz=round(-up_mps * 100),
        ind_airspeed=0,
        true_airspeed=0,
        xacc=0,
        yacc=0,
        zacc=0,
    )
