"""Packets and images as no vehicle sends them, through the code that reads them from the network.

Run: python -m tests.fuzz_inputs packets [--count 1000000] [--seed 0]
     python -m tests.fuzz_inputs images [--count 50000] [--seed 0]

Nothing may be raised but errors of captures, for images. Every round has its own seed: what is raised names it, and
the round is repeated by ``--seed`` and ``--count``. Memory is compared with that after the first round.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import os
import random
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.images import decode_image
from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.mavlink.signing.signer import LinkSigner, SigningClock, ticks_of
from aos_gcs.errors import CaptureError
from tests.fakes.mavlink_vehicle import FakeVehicle
from tests.fuzz import damage

PACKETS_PER_ROUND: Final = 20_000
IMAGES_PER_ROUND: Final = 2_000
MAX_GROWTH_MIB: Final = 128
"""Most memory that may be added after the first round: the largest image that is decoded, several times."""
KEY, OTHER_KEY = hashlib.sha256(b"right").digest(), hashlib.sha256(b"wrong").digest()
UTC_S: Final = 1_800_000_000.0
MAX_PIXELS: Final = 1_000_000
_VEHICLES: Final = 5
_READ_KINDS: Final = (
    0,
    1,
    2,
    24,
    29,
    30,
    32,
    33,
    77,
    85,
    87,
    111,
    147,
    148,
    180,
    193,
    230,
    241,
    242,
    245,
    253,
    259,
    263,
    285,
)
"""Messages that the driver reads; half of all packets are of these."""


def rss_mib() -> float:
    """Return the memory of this process that is present."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def random_payload(size: int, draw: random.Random) -> bytes:
    """Return values at the ends of their ranges, not-a-numbers among them, as well as any others."""
    if draw.random() < 0.5:
        return draw.randbytes(size)
    patterns = (b"\0", b"\xff", b"\x7f", b"\x80", b"\0\0\xc0\x7f", b"\0\0\x80\x7f", b"\x01\0\0\0")
    return b"".join(draw.choice(patterns) for _ in range(size))[:size]


def random_message(draw: random.Random) -> bytes:
    """Return a packet with a valid checksum, of any sender, signed or not, with any values."""
    message_id = draw.choice(_READ_KINDS) if draw.random() < 0.5 else draw.choice(list(mavlink.mavlink_map))
    kind = mavlink.mavlink_map[message_id]
    encoder = mavlink.MAVLink(None, draw.choice((1, 2, 3, 4, 5, draw.randrange(256))), draw.choice((1, 1, 100, 154, 0)))
    encoder.seq = draw.randrange(256)
    key = draw.choice((None, None, KEY, OTHER_KEY))
    if key is not None:
        encoder.signing.secret_key, encoder.signing.sign_outgoing = key, True
        encoder.signing.timestamp = draw.choice((ticks_of(UTC_S), draw.randrange(2**48)))
        encoder.signing.link_id = draw.randrange(3)
    payload = random_payload(draw.choice((kind.unpacker.size, draw.randrange(1, 255))), draw) or b"\0"
    is_v1 = key is None and message_id < 256 and draw.random() < 0.1
    packet: bytes = mavlink.MAVLink_message(message_id, kind.msgname)._pack(
        encoder, kind.crc_extra, payload[: kind.unpacker.size] if is_v1 else payload, force_mavlink1=is_v1
    )
    return packet


def genuine_packet(vehicles: Sequence[FakeVehicle], draw: random.Random) -> bytes:
    """Return what a vehicle says; it flies, lands and restarts at any time."""
    vehicle = draw.choice(vehicles)
    vehicle.boot_ms = draw.randrange(5000) if draw.random() < 0.001 else vehicle.boot_ms + draw.randrange(200)
    if draw.random() < 0.01:
        vehicle.armed = not vehicle.armed
    return draw.choice((vehicle.heartbeat, vehicle.position, vehicle.home, vehicle.telemetry))()


def spoiled(packet: bytes, former: bytes, draw: random.Random) -> bytes:
    """Return a packet that was changed, cut off, joined with another one or only begun."""
    match draw.randrange(5):
        case 0:
            changed = bytearray(packet)
            for _ in range(draw.randrange(1, 4)):
                changed[draw.randrange(len(changed))] = draw.randrange(256)
            return bytes(changed)
        case 1:
            return packet[: draw.randrange(len(packet))]
        case 2:
            return former[: draw.randrange(len(former) + 1)] + packet[draw.randrange(len(packet)) :]
        case 3:
            return draw.randbytes(draw.randrange(60)) + packet + former
        case _:
            return packet[:1] + draw.randbytes(draw.randrange(300))


def feed_packets(count: int, seed: int) -> int:
    """Have one session read ``count`` packets; return how many of them it took for valid."""
    draw = random.Random(seed)
    clock = SigningClock(lambda: UTC_S, 0)
    session = MavlinkSession(254, 5.0, {1: LinkSigner(1, KEY, clock, accepts_unsigned=draw.random() < 0.5)})
    vehicles = [FakeVehicle(number) for number in range(1, _VEHICLES + 1)]
    peers = [PeerAddress(link, "h", port) for link in (0, 1) for port in range(1, 13)]
    now_s, due_s, valid, former = 0.0, 0.0, 0, b""
    for _ in range(count):
        kind = draw.random()
        packet = genuine_packet(vehicles, draw) if kind < 0.3 else random_message(draw)
        data = spoiled(packet, former, draw) if kind > 0.75 else packet
        former = packet
        now_s += draw.choice((0.0, 0.001, 0.01, 0.02))
        valid += sum(isinstance(event, tuple) for event in session.feed(data, draw.choice(peers), now_s))
        if now_s >= due_s:
            due_s = now_s + draw.choice((0.1, 0.1, 3.0))
            use_session(session, now_s)
    assert len(session.records) <= 254
    return valid


def use_session(session: MavlinkSession, now_s: float) -> None:
    """Do what the service does between packets."""
    session.poll(now_s)
    session.send_heartbeat(now_s)
    session.take_outgoing()
    for record in session.records.values():
        record.state(now_s)


def whole_images() -> list[bytes]:
    """Return one small file of each kind that cameras send."""
    rng = np.random.default_rng(5)
    colour = rng.integers(0, 256, (24, 32, 3), np.uint8)
    thermal = rng.integers(28_000, 31_000, (24, 32), np.uint16)
    single = [
        bytes(cv2.imencode(kind, image)[1])
        for kind, image in (
            (".png", colour),
            (".png", thermal),
            (".png", colour[..., 0]),
            (".tiff", colour),
            (".tiff", thermal),
            (".jpg", colour),
            (".jpg", colour[..., 0]),
        )
    ]
    return [*single, bytes(cv2.imencodemulti(".tiff", [colour, thermal])[1])]


def feed_images(count: int, seed: int) -> int:
    """Decode ``count`` damaged images; return how many of them could be read all the same."""
    rng, images, read = np.random.default_rng(seed), whole_images(), 0
    for _ in range(count):
        data = images[rng.integers(len(images))]
        if rng.random() < 0.5:
            data = damage(data, rng)
        else:
            head = bytearray(data)
            for _ in range(rng.integers(1, 5)):
                place = rng.integers(min(len(head), 160)) if rng.random() < 0.7 else rng.integers(len(head))
                value = rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.integers(256)])
                head[place : place + rng.integers(1, 5)] = bytes([value]) * int(rng.integers(1, 5))
            data = bytes(head)
        with contextlib.suppress(CaptureError):
            image, bands = decode_image(data, MAX_PIXELS)
            assert image.shape[2] == len(bands)
            read += 1
    return read


def run(feed: Callable[[int, int], int], count: int, per_round: int, seed: int) -> int:
    """Feed ``count`` inputs in rounds with seeds from ``seed`` on; return how many were valid.

    Raises:
        AssertionError: memory has grown.
        Exception: whatever the program has raised, with the seed of the round in a note.
    """
    valid, at_first_mib = 0, None
    for number, start in enumerate(range(0, count, per_round)):
        size = min(per_round, count - start)
        try:
            valid += feed(size, seed + number)
        except Exception as error:
            error.add_note(f"repeat it with --seed {seed + number} --count {size}")
            raise
        at_first_mib = rss_mib() if at_first_mib is None else at_first_mib
        growth_mib = rss_mib() - at_first_mib
        assert growth_mib <= MAX_GROWTH_MIB, f"{growth_mib:.0f} MiB more memory after {start + size} inputs"
    return valid


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("inputs", choices=("packets", "images"))
    parser.add_argument("--count", type=int, default=None)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    are_packets = arguments.inputs == "packets"
    count = arguments.count or (1_000_000 if are_packets else 50_000)
    feed, per_round = (feed_packets, PACKETS_PER_ROUND) if are_packets else (feed_images, IMAGES_PER_ROUND)
    begun_s = time.monotonic()
    valid = run(feed, count, per_round, arguments.seed)
    words = f"{count} {arguments.inputs}, {valid} found valid, 0 unexpected exceptions"
    sys.stdout.write(f"{words}, {rss_mib():.0f} MiB, {time.monotonic() - begun_s:.0f} s\n")


if __name__ == "__main__":
    main()
