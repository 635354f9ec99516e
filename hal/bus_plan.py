"""What a tick costs on the wire, in bytes and seconds. Source: e-Manual, Protocol 2.0, frame layouts."""

from collections.abc import Sequence
from typing import NamedTuple

from hal.register_map import ServoModel

_BITS_PER_BYTE = 10  # 8N1
_RETURN_DELAY_S = 2e-6  # per count of the Return Delay Time register


class Exchange(NamedTuple):
    """One write of all goals and one read of all states, on one bus."""

    tx_bytes: int
    rx_bytes: int
    return_delays: int  # waits for a servo's Return Delay Time


def dynamixel(servos: int, goal_bytes: int, feedback_bytes: int, *, fast: bool) -> Exchange:
    """Return the cost of a sync write and a sync read, or fast sync read, without stuffing."""
    write = 14 + servos * (1 + goal_bytes)
    request = 14 + servos
    if fast:
        return Exchange(write + request, 8 + servos * (feedback_bytes + 4), 1)
    return Exchange(write + request, servos * (feedback_bytes + 11), servos)


def cyclic(models: Sequence[ServoModel]) -> Exchange:
    """Return the cost of a tick for servos that share one wire and one register layout, on their best firmware."""
    model = models[0]
    feedback = model.feedback
    size = feedback[-1].end - feedback[0].address
    fast = all(m.fast_sync_read_firmware is not None for m in models)
    return dynamixel(len(models), model[model.cyclic.goal].size, size, fast=fast)


def wire_seconds(exchange: Exchange, baud: int, return_delay: int = 0) -> float:
    """Return how long the exchange keeps the wire busy; `return_delay` in counts of its register."""
    on_wire = (exchange.tx_bytes + exchange.rx_bytes) * _BITS_PER_BYTE / baud
    return on_wire + exchange.return_delays * return_delay * _RETURN_DELAY_S
