"""What a tick costs on the wire, in bytes and seconds: counted on the frames that would be sent."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from hal.feedback import Reader, readers
from hal.goal_writer import GoalWriter
from hal.protocol import ServoProtocol
from hal.wired import Wired

_BITS_PER_BYTE = 10  # 8N1
SHARE_OF_TICK = 0.9  # that an exchange may take, whatever is missing
_PACKET = 62  # bytes that an FTDI adapter hands over without waiting (AN232B-04)
_STALEST = 0.05  # s between two samples of a joint, where they are spread over ticks


class Exchange(NamedTuple):
    """One write of all goals and one read of all states, on one bus, without stuffing."""

    tx_bytes: int
    rx_bytes: int
    return_delays: int  # waits for a servo's return delay
    round_trips: int = 1  # requests that wait for the answer to the one before

    def seconds(self, baud: int, *, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """Return how long it takes; the servos' return delay and the adapter's latency in s."""
        on_wire = (self.tx_bytes + self.rx_bytes) * _BITS_PER_BYTE / baud
        return on_wire + self.return_delays * return_delay + self.round_trips * latency

    def __add__(self, other: tuple[int, ...]) -> "Exchange":  # type: ignore[override]
        return Exchange(*map(sum, zip(self, other, strict=True)))


class Cycle(NamedTuple):
    """What goes over a bus in every tick, and what is spread over as many as it takes."""

    always: Exchange
    spread: tuple[Exchange, ...]  # one for each servo that is read by itself

    @property
    def whole(self) -> Exchange:
        """One write of all goals and one read of all states."""
        return sum(self.spread, self.always)

    def seconds(self, baud: int, rate_hz: int, *, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """Return how long a tick's part of it takes at least, at a rate."""
        wait = {"return_delay": return_delay, "latency": latency}
        always = self.always.seconds(baud, **wait)
        if not self.spread:
            return always
        ticks = max(math.floor(_STALEST * rate_hz), 1)
        one = max(exchange.seconds(baud, **wait) for exchange in self.spread)
        return always + math.ceil(len(self.spread) / ticks) * one

    def taken(self, baud: int, rate_hz: int, *, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """Return how long a tick's exchange takes (s) when all answer: as many of the single reads as there is time."""
        wait = {"return_delay": return_delay, "latency": latency}
        seconds = self.always.seconds(baud, **wait)
        for place, exchange in enumerate(self.spread):
            one = exchange.seconds(baud, **wait)
            if place and seconds + one > SHARE_OF_TICK / rate_hz:
                break
            seconds += one
        return seconds

    def held_back(self, baud: int, timer: float) -> float:
        """Return how long (s) an adapter with a latency timer keeps the end of a reply that came without a pause."""
        trips = self.always.round_trips
        size = self.spread[0].rx_bytes if self.spread else self.always.rx_bytes // trips
        byte = _BITS_PER_BYTE / baud
        left = size % min(_PACKET, math.floor(timer / byte) + 1)
        return timer - (left - 1) * byte if left else 0.0

    def largest_rate(self, baud: int, share: float, *, return_delay: float = 0.0, latency: float = 0.0) -> int:
        """Return the largest rate (Hz) at which a tick's part takes no more than a share of the tick; 0 if none."""
        wait = {"return_delay": return_delay, "latency": latency}
        most = int(share / self.always.seconds(baud, **wait))
        return next((rate for rate in range(most, 0, -1) if self.seconds(baud, rate, **wait) * rate <= share), 0)


def cycle(protocol: ServoProtocol, servos: Sequence[Wired], *, fast: bool) -> Cycle:
    """Return the cost of a tick on a wire; `fast`: each servo that may know the fast reads does."""
    able = {servo.id for servo in servos if fast and servo.model.fast_sync_read_firmware is not None}
    return cycle_of(protocol, servos, readers(protocol, servos, able))


def cycle_of(protocol: ServoProtocol, servos: Sequence[Wired], by: Sequence[Reader]) -> Cycle:
    """Return the cost of a tick in which these readers read the feedback of a wire's servos."""
    goals = GoalWriter(protocol, servos).frames(_middle(servos))
    always, spread = Exchange(len(goals), 0, 0, 0), []
    for reader in by:
        for reading in reader.everyone():
            cost = Exchange(len(reading.request), reading.reply.size, reading.reply.waits)
            if reader.spreads:
                spread.append(cost)
            else:
                always += cost
    return Cycle(always, tuple(spread))


def _middle(servos: Sequence[Wired]) -> list[float]:
    """Return goals that every servo can pack: where its encoder has its centre."""
    goals = [0.0] * (1 + max(servo.slot for servo in servos))
    for servo in servos:
        goals[servo.slot] = servo.calibration.zero
    return goals


class Remedy(NamedTuple):
    """Something that would make a bus carry more ticks a second."""

    what: str
    largest_rate_hz: int


def remedies(
    protocol: ServoProtocol, servos: Sequence[Wired], baud: int, share: float
) -> list[Remedy]:
    """Return what would raise the largest rate, the most first: a faster baud, another bus, firmware.

    The plan as it is has return delay 0 and, where every firmware of a model may have it, the fast read.
    """
    now = cycle(protocol, servos, fast=True).largest_rate(baud, share)
    common = set.intersection(*({*servo.model.baud_rates} for servo in servos))
    found = [
        Remedy(f"{faster} baud", cycle(protocol, servos, fast=True).largest_rate(faster, share))
        for faster in sorted(rate for rate in common if rate > baud)]
    if len(servos) > 1:
        half = cycle(protocol, servos[: (len(servos) + 1) // 2], fast=True)
        found.append(Remedy("two buses of half as many servos", half.largest_rate(baud, share)))
    return sorted((each for each in found if each.largest_rate_hz > now), key=lambda each: -each.largest_rate_hz)


def costs(protocol: ServoProtocol, servos: Sequence[Wired], baud: int, share: float) -> list[Remedy]:
    """Return what would lower the largest rate: servos as they leave the factory, old firmware, a slow adapter."""
    fast, plain = cycle(protocol, servos, fast=True), cycle(protocol, servos, fast=False)
    delays = [servo.model["return_delay_time"] for servo in servos]
    delay = max((register.default or 0) * register.si_scale for register in delays)
    found = [Remedy(f"the factory's return delay of {1e6 * delay:.0f} us", fast.largest_rate(
        baud, share, return_delay=delay))] if delay else []
    if plain != fast:
        found.append(Remedy("firmware without fast sync read", plain.largest_rate(baud, share)))
    for timer in (1e-3, 16e-3):
        found.append(Remedy(
            f"an adapter that holds replies back for {1e3 * timer:.0f} ms", fast.largest_rate(
                baud, share, latency=fast.held_back(baud, timer))))
    return found
