"""Indirect addressing: a servo's condition, whose registers lie apart, gathered so that one short read brings it.

Where the gathered data begins depends on the firmware, and the sources disagree. A servo tells it by itself: after a
start, the first indirect address points at the first byte of indirect data.
Source: ROBOTIS e-Manual, "Indirect Address"; for the conflict, ROBOTIS's control tables for the XL330.

A servo that restarts forgets all this. Its indirect data is then 0 throughout, so its torque reads as off, as it is.
"""

from collections.abc import Callable

from hal.condition import Probe, probe
from hal.protocol import ServoProtocol
from hal.register_map import Register, ServoModel
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
    base = model[_DATA.format(1)].address
    addresses, mapped = mapping(model)
    found = read(addresses, len(mapped))
    if found != mapped:
        if int.from_bytes(found[:_WIDTH], "little") != base:
            return None
        write(addresses, mapped)
        if read(addresses, len(mapped)) != mapped:
            return None
    fields: list[tuple[Register, int]] = []
    offset = 0
    for name in model.condition:
        fields.append((model[name], offset))
        offset += model[name].size
    return probe(protocol, servo, base, fields)


def mapping(model: ServoModel) -> tuple[int, bytes]:
    """Return where the indirect addresses begin, and what they are to be for the condition to be gathered."""
    wanted = [address for name in model.condition for address in range(model[name].address, model[name].end)]
    return model[_ADDRESS.format(1)].address, b"".join(address.to_bytes(_WIDTH, "little") for address in wanted)
