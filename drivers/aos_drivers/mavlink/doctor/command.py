"""The command ``aos-gcs doctor``: listen on links for a while and diagnose them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from contextlib import AsyncExitStack
from dataclasses import asdict
from typing import Annotated

import typer

from aos_drivers.background import BackgroundTasks
from aos_drivers.links.address import LinkAddress, PeerAddress, parse_link
from aos_drivers.links.opener import Endpoint, LinkOpener
from aos_drivers.mavlink.doctor.diagnosis import POSITION_HZ, Diagnosis, Examination, Level, diagnose
from aos_drivers.mavlink.doctor.traffic import Traffic
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.mavlink.signing.keyring import Keyring
from aos_gcs.clock import LoopClock
from aos_gcs.errors import LinkError
from aos_gcs.ports import Clock

_TICK_S = 0.1
_USUAL_PORTS = (14550, 14540, 14551, 14555, 14445)
_EXIT_PROBLEMS = 1
_MARKS = {Level.OK: "ok      ", Level.HINT: "hint    ", Level.PROBLEM: "PROBLEM "}


def doctor(
    links: Annotated[list[str], typer.Argument(help="Links, as in the configuration, such as udpin://0.0.0.0:14550.")],
    seconds: Annotated[float, typer.Option(min=4.0, max=600.0, help="Listening time in seconds.")] = 12.0,
    system_id: Annotated[int, typer.Option(min=1, max=255, help="MAVLink system id of this station.")] = 254,
    as_json: Annotated[bool, typer.Option("--json", help="Write the results as JSON.")] = False,
) -> None:
    """Diagnose the connection to vehicles. Exit code 0: healthy, 1: problems, 2: cannot listen.

    Sends heartbeats and requests for messages as a mission does, but no command that moves a vehicle.
    """
    addresses = [parse_link(text) for text in links]
    diagnoses = asyncio.run(_examine_now(addresses, system_id, seconds))
    typer.echo(_as_json(diagnoses) if as_json else _as_text(diagnoses, seconds))
    if any(diagnosis.level is Level.PROBLEM for diagnosis in diagnoses):
        raise typer.Exit(_EXIT_PROBLEMS)


async def _examine_now(addresses: Sequence[LinkAddress], system_id: int, duration_s: float) -> list[Diagnosis]:
    return diagnose(await examine(addresses, system_id, duration_s, LoopClock()))


class _Listener:
    """Passes received bytes to the traffic and to a session like that of a mission, and sends the session's packets."""

    def __init__(self, session: MavlinkSession, traffic: Traffic, clock: Clock) -> None:
        self._session = session
        self._traffic = traffic
        self._clock = clock
        self.endpoints: dict[int, Endpoint] = {}

    def receive(self, data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        now_s = self._clock.now_s() - waited_s
        self._traffic.feed(data, peer, now_s)
        self._session.feed(data, peer, now_s)
        self._flush()

    async def listen(self, until_s: float) -> None:
        while (now_s := self._clock.now_s()) < until_s:
            self._session.poll(now_s)
            if self._session.is_heartbeat_due(now_s):
                self._session.send_heartbeat(now_s)
            self._flush()
            await self._clock.sleep(_TICK_S)

    def _flush(self) -> None:
        for outgoing in self._session.take_outgoing():
            if outgoing.peer.link in self.endpoints:
                self.endpoints[outgoing.peer.link].send(outgoing.packet, outgoing.peer)


async def examine(addresses: Sequence[LinkAddress], system_id: int, duration_s: float, clock: Clock) -> Examination:
    """Listen for ``duration_s``; the rates of messages are those of the second half, after they have been requested.

    Raises:
        ConfigurationError: a key cannot be used.
        LinkError: a link cannot be opened.
    """
    async with AsyncExitStack() as stack:
        keyring = await asyncio.to_thread(Keyring, addresses, clock)
        stack.push_async_callback(asyncio.to_thread, keyring.close)
        session = MavlinkSession(system_id, POSITION_HZ, keyring.signers)
        traffic = Traffic({link: signer.with_empty_memory() for link, signer in keyring.signers.items()})
        listener = _Listener(session, traffic, clock)
        tasks = await stack.enter_async_context(BackgroundTasks(_ignore))
        opener = LinkOpener(stack, tasks, clock, listener.receive, _ignore)
        for link, address in enumerate(addresses):
            endpoint, peer = await opener.open(link, address)
            listener.endpoints[link] = endpoint
            if peer is not None:
                session.add_peer(peer)
        elsewhere = await _listen_elsewhere(stack, tasks, addresses, clock)
        start_s = clock.now_s()
        await listener.listen(start_s + duration_s / 2)
        traffic.start_rates(clock.now_s())
        await listener.listen(start_s + duration_s)
        ports = sorted({_USUAL_PORTS[sender.peer.link] for sender in elsewhere.senders})
        return Examination(addresses, system_id, traffic, session.records, ports, clock.now_s())


async def _listen_elsewhere(
    stack: AsyncExitStack, tasks: BackgroundTasks, addresses: Sequence[LinkAddress], clock: Clock
) -> Traffic:
    """Listen on the usual ports that are free, which vehicles may be configured to send to."""
    traffic = Traffic({})
    hosts = [address.host for address in addresses if address.kind == "udpin"]
    taken = {address.port for address in addresses}

    def receive(data: bytes, peer: PeerAddress, waited_s: float = 0.0, /) -> None:
        traffic.feed(data, peer, clock.now_s() - waited_s)

    opener = LinkOpener(stack, tasks, clock, receive, _ignore)
    for number, port in enumerate(_USUAL_PORTS):
        if hosts and port not in taken:
            try:
                await opener.open(number, LinkAddress("udpin", hosts[0], port, f"udpin://{hosts[0]}:{port}"))
            except LinkError:
                continue  # in use by another program, which then is where its packets go
    return traffic


def _ignore(_event: object) -> None:
    """Ignore changes of the links: they show in the traffic."""


def _as_text(diagnoses: Sequence[Diagnosis], seconds: float) -> str:
    lines = [f"Listened for {seconds:g} s."]
    lines += [f"{_MARKS[diagnosis.level]}{diagnosis.text}" for diagnosis in diagnoses]
    problems = sum(diagnosis.level is Level.PROBLEM for diagnosis in diagnoses)
    lines.append("No problems found." if not problems else f"Problems found: {problems}.")
    return "\n".join(lines)


def _as_json(diagnoses: Sequence[Diagnosis]) -> str:
    is_healthy = all(diagnosis.level is not Level.PROBLEM for diagnosis in diagnoses)
    return json.dumps({"healthy": is_healthy, "findings": [asdict(diagnosis) for diagnosis in diagnoses]}, indent=2)
