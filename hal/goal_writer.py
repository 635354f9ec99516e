"""The frames that bring every goal to its servo, in every tick."""

from collections.abc import Sequence

from hal.encoding import pack
from hal.protocol import ServoProtocol
from hal.register_map import Register
from hal.wired import Wired


class GoalWriter:
    """Writes the goals of a wire's servos: one sync write for all whose goal registers lie alike."""

    def __init__(self, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        self._protocol = protocol
        self._groups: dict[tuple[int, int], list[tuple[Wired, Register]]] = {}
        for servo in servos:
            register = servo.model[servo.model.cyclic.goal]
            self._groups.setdefault((register.address, register.size), []).append((servo, register))

    def frames(self, goals: Sequence[float]) -> bytes:
        """Return the frames that write the goals (rad, in the robot's joint order).

        Raises:
            ValueError: a goal is NaN or infinite.
        """
        return b"".join(
            self._protocol.sync_write(address, size, [
                (servo.id, pack(register, servo.calibration.ticks(goals[servo.slot]))) for servo, register in group])
            for (address, size), group in self._groups.items())
