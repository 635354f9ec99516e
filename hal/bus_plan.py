"""What a tick costs on the wire, in bytes and seconds: counted on the frames that would be sent."""

from collections.abc import Sequence
from typing import NamedTuple

from hal.protocol import ServoProtocol
from hal.register_map import ServoModel

_BITS_PER_BYTE = 10  # 8N1
_RETURN_DELAY_S = 2e-6  # per count of the register, with every brand here


class Exchange(NamedTuple):
    """One write of all goals and one read of all states, on one bus, without stuffing."""

    tx_bytes: int
    rx_bytes: int
    return_delays: int  # waits for a servo's return delay


def cyclic(protocol: ServoProtocol, models: Sequence[ServoModel], *, fast: bool) -> Exchange:
    """Return the cost of a tick for servos that share one wire and one register layout."""
    ids = range(1, len(models) + 1)
    goal, feedback = models[0][models[0].cyclic.goal], models[0].feedback
    write = protocol.sync_write(goal.address, goal.size, [(servo_id, bytes(goal.size)) for servo_id in ids])
    request, reply = protocol.group_read(feedback.address, feedback.size, ids, fast=fast)
    return Exchange(len(write) + len(request), reply.size, reply.waits)


def wire_seconds(exchange: Exchange, baud: int, return_delay: int = 0) -> float:
    """Return how long the exchange keeps the wire busy; `return_delay` in counts of its register."""
    on_wire = (exchange.tx_bytes + exchange.rx_bytes) * _BITS_PER_BYTE / baud
    return on_wire + exchange.return_delays * return_delay * _RETURN_DELAY_S
