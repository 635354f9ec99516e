"""The frames that bring every goal to its servo, in every tick."""

from collections.abc import Sequence

from hal.encoding import column
from hal.protocol import ServoProtocol
from hal.register_map import Register
from hal.wired import Wired


class GoalWriter:
    """Writes the goals of a wire's servos: one sync write for all whose goal registers lie alike."""

    def __init__(self, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        groups: dict[Register, list[Wired]] = {}
        for servo in servos:
            groups.setdefault(servo.model[servo.model.cyclic.goal], []).append(servo)
        self._groups = [_Group(protocol, register, group) for register, group in groups.items()]

    def frames(self, goals: Sequence[float]) -> bytes:
        """Return the frames that write the goals (rad, in the robot's joint order).

        Raises:
            ValueError: a goal is NaN or infinite, or its register does not hold it.
        """
        return b"".join([group.frame(goals) for group in self._groups])


class _Group:
    """Servos that share a sync write."""

    def __init__(self, protocol: ServoProtocol, register: Register, servos: Sequence[Wired]) -> None:
        ids = [servo.id for servo in servos]
        self._pack = column(register, ids)
        self._calibrations = [(servo.slot, servo.calibration) for servo in servos]
        self._scales = [
            (servo.slot, calibration.centre, calibration.direction, calibration.zero, calibration.radians_per_tick)
            for servo, calibration in zip(servos, [servo.calibration for servo in servos], strict=True)]
        self._write = protocol.sync_writer(register.address, register.size, ids)

    def frame(self, goals: Sequence[float]) -> bytes:
        try:
            counts = [
                round(centre + direction * (goals[slot] - zero) / scale)  # as Calibration.ticks, at once
                for slot, centre, direction, zero, scale in self._scales]
        except (ValueError, OverflowError):
            counts = [calibration.ticks(goals[slot]) for slot, calibration in self._calibrations]  # says which
        return self._write(self._pack(counts))
