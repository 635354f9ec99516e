"""The watchdogs inside a wire's servos: who hears no instruction for too long stops where it is, and holds.

    arm       write the time: the last step of a start, and the first after a pause
    feed      any instruction on the wire does, so the cycle does
    disarm    write 0: before a pause, and when torque goes off
    trip      the register reads as something else than was written, and goals are refused; in silence, since nobody
              answers a sync write. So it is read with the servo's condition, and taken for granted of a servo that is
              heard again after as long a silence. Then: write 0, goal = where it is, arm

Nobody acknowledges these writes either. One that is lost shows as a trip, and is made up for.
Source: ROBOTIS e-Manual, "Bus Watchdog".
"""

import math
from collections.abc import Collection, Sequence

from hal.encoding import pack
from hal.protocol import ServoProtocol
from hal.wired import Wired


class Watchdogs:
    """Those of one wire; none, if its servos have none.

    Attributes:
        trips: how many were found, or taken for granted.
    """

    def __init__(self, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        self.trips = 0
        self._protocol = protocol
        self._servos = {servo.slot: servo for servo in servos if servo.model.watchdog is not None}
        self._due: set[int] = set()  # slots of those that are to be armed

    @property
    def due(self) -> Collection[int]:
        """The slots of the servos that are to be armed with the next goals."""
        return self._due

    @property
    def shortest(self) -> float:
        """The shortest time of them, s; infinite where there are none."""
        return min(
            (servo.model.arming.watchdog.time_ms / 1e3 for servo in self._servos.values()
             if servo.model.arming.watchdog is not None), default=math.inf)

    def arm_all(self) -> None:
        """Arm all of them with the next goals."""
        self._due.update(self._servos)

    def arm_again(self, tripped: Collection[int]) -> None:
        """Arm those that have tripped with the next goals."""
        self.trips += len(tripped)
        self._due.update(tripped)

    def may_have_tripped(self, slot: int, silence: float) -> bool:
        """Tell whether a servo that was unheard for so long, s, may have heard nothing for too long itself."""
        servo = self._servos.get(slot)
        watchdog = servo.model.arming.watchdog if servo is not None else None
        return watchdog is not None and silence > watchdog.time_ms / 1e3

    def armed(self, goal_frames: bytes) -> bytes:
        """Return the goals' frames between those that clear and arm whoever is due; then nobody is."""
        due = [servo for slot, servo in self._servos.items() if slot in self._due]
        self._due.clear()
        return self._write(due, clear=True) + goal_frames + self._write(due)

    def disarmed(self) -> bytes:
        """Return what disarms all; whoever was due is not any more."""
        self._due.clear()
        return self._write(list(self._servos.values()), clear=True)

    def _write(self, servos: Sequence[Wired], *, clear: bool = False) -> bytes:
        groups: dict[tuple[int, int], list[tuple[int, bytes]]] = {}
        for servo in servos:
            assert servo.model.watchdog is not None
            register, counts = servo.model.watchdog
            data = pack(register, 0 if clear else counts)
            groups.setdefault((register.address, register.size), []).append((servo.id, data))
        return b"".join(self._protocol.sync_write(*place, items) for place, items in groups.items())
