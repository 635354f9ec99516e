"""Indirect addressing: a servo's condition, whose registers lie apart, gathered so that one short read brings it.

Where the gathered data begins depends on the firmware, and the sources disagree. A servo tells it by itself: after a
start, the first indirect address points at the first byte of indirect data.
Source: ROBOTIS e-Manual, "Indirect Address"; for the conflict, ROBOTIS's control tables for the XL330.

A servo that restarts forgets all this. Its indirect data is then 0 throughout, so its torque reads as off, as it is.
"""

from collections.abc import Callable

from hal.condition import Probe, probe
from hal.protocol import ServoProtocol
from hal.register_map import Register
from hal.wired import Wired

_ADDRESS, _DATA = "indirect_address_{}", "indirect_data_{}"
_WIDTH = 2  # bytes of an address

Read = Callable[[int, int], bytes]  # address and size
Write = Callable[[int, bytes], None]


def gather(protocol: ServoProtocol, servo: Wired, read: Read, write: Write) -> Probe | None:
    """Map a servo's condition and return the read that brings it; None if its map is not where its table says.

    Args:
        protocol: what it speaks.
        servo: the servo; its model's table is that of its firmware.
        read: reads bytes of its table.
        write: writes bytes there.

    Raises:
        BusError: it does not answer.
    """
    model = servo.model
    if _ADDRESS.format(1) not in model.by_name:
        return None
    fields: list[tuple[Register, int]] = []
    wanted: list[int] = []
    for name in model.condition:
        fields.append((model[name], len(wanted)))
        wanted += range(model[name].address, model[name].end)
    base, addresses = model[_DATA.format(1)].address, model[_ADDRESS.format(1)].address
    mapped = b"".join(address.to_bytes(_WIDTH, "little") for address in wanted)
    found = read(addresses, len(mapped))
    if found != mapped:
        if int.from_bytes(found[:_WIDTH], "little") != base:
            return None
        write(addresses, mapped)
        if read(addresses, len(mapped)) != mapped:
            return None
    return probe(protocol, servo, base, fields)
