"""Diagnosis of a connection from the counts of a traffic. No I/O."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import LinkAddress
from aos_drivers.mavlink.doctor.traffic import Sender, Traffic
from aos_drivers.mavlink.signing.signer import SignatureCheck
from aos_drivers.vehicle.record import VehicleRecord

POSITION_HZ = 5.0
_NEEDED = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: "HEARTBEAT",
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: "GLOBAL_POSITION_INT",
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: "EXTENDED_SYS_STATE",
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: "SYS_STATUS",
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: "GPS_RAW_INT",
}
_LOWEST_SHARE = 0.5
_HIGH_LOSS = 0.1
_SILENT_S = 3.0
_NOTHING = {
    "udpin": "vehicles must send to an address of this computer and to port {port}, and the firewall must let UDP in; "
    "another program that receives the same traffic (a router, another ground station) must forward it",
    "udpout": "check that {host} is switched on and reachable (ping it) and listens on port {port}",
    "tcpout": "connected, but no data received: check that port {port} is the MAVLink port of the other end",
    "tcpin": "no connection yet: vehicles or their router must connect to port {port} of this computer",
    "serial": "check the cable, that the radio is paired and that the vehicle's port is set to MAVLink",
}
_NO_MAVLINK = {
    "serial": "the baud rate is probably wrong: {port} here; it must be that of the radio or of the vehicle's port",
}


class Level(StrEnum):
    """Severity of a diagnosis."""

    OK = "ok"
    HINT = "hint"
    PROBLEM = "problem"


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One result of the diagnosis."""

    level: Level
    code: str
    """Identifier that stays the same across versions; for programs."""
    text: str
    system_id: int | None = None


@dataclass(frozen=True, slots=True)
class Examination:
    """Input of the diagnosis."""

    links: Sequence[LinkAddress]
    our_system_id: int
    traffic: Traffic
    records: Mapping[int, VehicleRecord]
    """The vehicles as a mission would see them, by system id."""
    elsewhere: Sequence[int]
    """Other usual UDP ports of this computer at which MAVLink arrives."""
    ended_at_s: float


def diagnose(examination: Examination) -> list[Diagnosis]:
    """Return all diagnoses, the links' first."""
    diagnoses = [diagnosis for link in range(len(examination.links)) for diagnosis in _check_link(examination, link)]
    diagnoses += _check_ground_stations(examination)
    by_system: dict[int, list[Sender]] = defaultdict(list)
    for sender in examination.traffic.senders:
        if sender.is_autopilot:
            by_system[sender.system_id].append(sender)
    for system_id, senders in by_system.items():
        own = [
            *_check_signatures(examination, system_id, senders),
            *_check_identity(examination, system_id, senders),
            *_check_quality(examination, system_id, senders),
        ]
        if not any(diagnosis.level is Level.PROBLEM for diagnosis in own):
            own.append(Diagnosis(Level.OK, "vehicle", _describe(examination, system_id, senders), system_id))
        diagnoses += own
    return diagnoses


def _check_link(examination: Examination, link: int) -> Iterator[Diagnosis]:
    address = examination.links[link]
    senders = [sender for sender in examination.traffic.senders if sender.peer.link == link]
    if not examination.traffic.bytes_by_link[link]:
        advice = _NOTHING[address.kind].format(host=address.host, port=address.port)
        yield Diagnosis(Level.PROBLEM, "no_packets", f"nothing arrives on {address.text}: {advice}")
        if address.kind == "udpin" and examination.elsewhere:
            ports = ", ".join(str(port) for port in examination.elsewhere)
            text = (
                f"MAVLink arrives at port {ports} of this computer instead: use that port, or change the vehicles' port"
            )
            yield Diagnosis(Level.PROBLEM, "wrong_port", text)
    elif not senders:
        advice = _NO_MAVLINK.get(address.kind, "another program sends to this port")
        advice = advice.format(port=address.port)
        text = f"bytes arrive on {address.text}, but no MAVLink: {advice}"
        yield Diagnosis(Level.PROBLEM, "no_mavlink", text)
    elif not any(sender.is_autopilot for sender in senders):
        text = f"MAVLink arrives on {address.text}, but no heartbeat of a vehicle: check the wiring of the autopilot"
        yield Diagnosis(Level.PROBLEM, "no_vehicle", text)


def _check_ground_stations(examination: Examination) -> Iterator[Diagnosis]:
    ours = examination.our_system_id
    for sender in examination.traffic.senders:
        if sender.system_id == ours:
            text = f"{sender.peer} uses the same system id as this station, {ours}: change one (link.system_id)"
            yield Diagnosis(Level.PROBLEM, "ground_station_clash", text, ours)
        elif sender.is_ground_station:
            text = f"another ground station, system id {sender.system_id}, is on the link: it may change message rates"
            yield Diagnosis(Level.HINT, "other_ground_station", text, sender.system_id)


def _check_signatures(examination: Examination, system_id: int, senders: Sequence[Sender]) -> Iterator[Diagnosis]:
    for sender in senders:
        signing = examination.links[sender.peer.link].signing
        where = f"vehicle {system_id} at {sender.peer}"
        if sender.mavlink1_packets == sender.packets:
            text = (
                f"{where} uses MAVLink 1 only, which has neither signing nor most camera messages: set "
                "SERIALn_PROTOCOL (ArduPilot) or MAV_PROTO_VER (PX4) to 2"
            )
            yield Diagnosis(Level.PROBLEM, "mavlink_1", text, system_id)
        if signing is None:
            if sender.signed_packets:
                text = f"{where} signs its packets and may refuse ours: append its key to the link with ?sign=FILE"
                yield Diagnosis(Level.PROBLEM, "key_missing", text, system_id)
            continue
        checks = sender.signature_checks
        if checks[SignatureCheck.WRONG_KEY]:
            text = f"{where} signs with another key than {signing.key_file}: set the same key on both sides"
            yield Diagnosis(Level.PROBLEM, "wrong_key", text, system_id)
        if checks[SignatureCheck.UNSIGNED]:
            level = Level.HINT if signing.accepts_unsigned else Level.PROBLEM
            unsigned = checks[SignatureCheck.UNSIGNED]
            text = f"{where} does not sign {unsigned} of {sender.packets} packets: set the key on the vehicle"
            yield Diagnosis(level, "unsigned", text, system_id)
        if checks[SignatureCheck.REPLAYED] and not checks[SignatureCheck.GOOD]:
            text = f"{where} signs with times that are too old: its clock, or that of this computer, is wrong"
            yield Diagnosis(Level.PROBLEM, "late_signatures", text, system_id)


def _check_identity(examination: Examination, system_id: int, senders: Sequence[Sender]) -> Iterator[Diagnosis]:
    boards = {sender.uid for sender in senders if sender.uid is not None}
    record = examination.records.get(system_id)
    addresses = " and ".join(str(sender.peer) for sender in senders)
    if len(boards) > 1 or (record is not None and record.identity.is_ambiguous(examination.ended_at_s)):
        reason = "the boards differ" if len(boards) > 1 else "not provably one vehicle"
        text = (
            f"two vehicles use system id {system_id}, at {addresses} ({reason}): change the id of one of them "
            "(MAV_SYSID, SYSID_THISMAV or MAV_SYS_ID)"
        )
        yield Diagnosis(Level.PROBLEM, "duplicate_id", text, system_id)
    elif len(senders) > 1:
        text = f"vehicle {system_id} is received over {len(senders)} addresses, {addresses}: each can replace the other"
        yield Diagnosis(Level.OK, "several_links", text, system_id)


def _check_quality(examination: Examination, system_id: int, senders: Sequence[Sender]) -> Iterator[Diagnosis]:
    silent_s = examination.ended_at_s - max(sender.heard_at_s for sender in senders)
    if silent_s > _SILENT_S:
        text = f"vehicle {system_id} has sent nothing for {silent_s:.0f} s: check its power and its distance"
        yield Diagnosis(Level.PROBLEM, "silent", text, system_id)
        return
    record = examination.records.get(system_id)
    if record is None:  # its packets were refused, which has been reported
        return
    if record.autopilot.name == "unknown":
        text = f"vehicle {system_id} runs neither ArduCopter nor PX4: it is displayed but never commanded"
        yield Diagnosis(Level.HINT, "unknown_autopilot", text, system_id)
        return
    wanted_hz = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0, **record.autopilot.stream_rates_hz(POSITION_HZ)}
    for message_id, name in _NEEDED.items():
        rate_hz = examination.traffic.rate_hz(system_id, message_id, examination.ended_at_s)
        if rate_hz < _LOWEST_SHARE * wanted_hz[message_id]:
            text = (
                f"vehicle {system_id} sends {name} at {rate_hz:.1f} Hz; a mission asks for {wanted_hz[message_id]:g} "
                "Hz: the radio may be too slow, or another ground station lowers the rates"
            )
            yield Diagnosis(Level.PROBLEM, "slow_stream", text, system_id)
    loss = record.loss_fraction() or 0.0
    if loss > _HIGH_LOSS:
        text = f"vehicle {system_id} loses {100 * loss:.0f} % of its packets: check antennas, distance and channel"
        yield Diagnosis(Level.PROBLEM, "loss", text, system_id)


def _describe(examination: Examination, system_id: int, senders: Sequence[Sender]) -> str:
    record = examination.records.get(system_id)
    name = record.autopilot.name if record is not None else "autopilot unknown"
    rate_hz = examination.traffic.rate_hz(system_id, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, examination.ended_at_s)
    return f"vehicle {system_id} ({name}) at {senders[0].peer}: positions at {rate_hz:.1f} Hz"
