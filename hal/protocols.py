"""Which module speaks which protocol."""

from hal import dynamixel1_protocol, dynamixel_protocol, feetech_protocol
from hal.protocol import ServoProtocol
from hal.register_map import ServoModel

_PROTOCOLS: dict[str, ServoProtocol] = {
    "dynamixel-2.0": dynamixel_protocol,
    "dynamixel-1.0": dynamixel1_protocol,
    "feetech-sts": feetech_protocol,
    "feetech-scs": feetech_protocol,
}


def protocol_of(model: ServoModel) -> ServoProtocol:
    """Return the protocol that a servo model speaks."""
    return _PROTOCOLS[model.protocol]


def protocol_named(name: str) -> ServoProtocol:
    """Return the protocol of a name, as servo models have it."""
    return _PROTOCOLS[name]
