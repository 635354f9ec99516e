"""What a Dynamixel answers at all, in either protocol: its status return level."""

from enum import IntEnum


class StatusReturnLevel(IntEnum):
    """What is answered; a ping always is."""

    PING = 0
    READ = 1
    ALL = 2


_PING, _READ = 0x01, 0x02  # instructions, alike in both protocols
_ANSWERED_FROM = {_PING: StatusReturnLevel.PING, _READ: StatusReturnLevel.READ}


def answers(level: int, instruction: int) -> bool:
    """Tell whether a servo with that level answers an instruction that is for it alone."""
    return level >= _ANSWERED_FROM.get(instruction, StatusReturnLevel.ALL)
