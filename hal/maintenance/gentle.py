"""One servo moved slowly and weakly, and left as it was found.

The goal itself creeps, so that no servo needs a profile of its own for it, and a shaft that is held does not jump
when it is let go: it is never more than the cap allows behind.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from hal.encoding import pack
from hal.maintenance.servo import Servo
from robotwalk.errors import BusError, ServoError
from robotwalk.ports import Clock

_NS = 1_000_000_000
_PERIOD = _NS // 50  # of the goals
_SPEED = math.radians(15.0)  # rad/s
_SETTLING = 2 * _NS // 5
_FAR = math.radians(10.0)  # between a shaft and its goal: it is not where it should be
_ATTEMPTS = 3  # at letting go
_TORQUE, _MODE = "torque_enable", "operating_mode"


def _no_signal() -> None:
    """Let everything go on."""


class Gentle:
    """A servo that is held. Positions are counts within one turn."""

    def __init__(self, servo: Servo, clock: Clock, check: Callable[[], None], at: int) -> None:
        self._servo, self._clock, self._check = servo, clock, check
        self._goal = at

    @property
    def position(self) -> int:
        """Where the shaft is."""
        return folded(self._servo, self._servo.read(self._servo.model.cyclic.position))

    def creep(self, goal: int) -> int:
        """Lead the shaft to a goal, and return where it has come to rest: elsewhere, if something holds it.

        Raises:
            BusError: the servo does not answer any more.
        """
        start, began = self._goal, self._clock.now()
        distance = (goal - start) * self._servo.model.encoder.radians_per_tick
        steps = max(1, math.ceil(abs(distance) / _SPEED * _NS / _PERIOD))
        for step in range(1, steps + 1):
            self._wait_until(began + step * _PERIOD)
            self._goal = start + round((goal - start) * step / steps)
            self._send(self._goal)
        self._wait_until(began + steps * _PERIOD + _SETTLING)
        return self.position

    def _wait_until(self, deadline: int) -> None:
        self._clock.wait((), deadline)
        self._check()

    def _send(self, goal: int) -> None:
        """Write the goal in a frame that nobody answers: some servos are set to answer no write."""
        servo, protocol = self._servo, self._servo.dialogue.protocol
        register = servo.model[servo.model.cyclic.goal]
        servo.dialogue.send(protocol.sync_write(register.address, register.size, [(servo.id, pack(register, goal))]))


@contextmanager
def gently(servo: Servo, clock: Clock, share: float, check: Callable[[], None] = _no_signal) -> Iterator[Gentle]:
    """Hold a servo where it is with a `share` of its torque. Torque, its bound and the goal are then as they were.

    Args:
        servo: which.
        clock: by which it moves.
        share: of the largest torque.
        check: called often; it raises what shall end the motion.

    Raises:
        BusError: the servo does not answer. If that happens in the end, its torque may still be on.
        ServoError: it is in no state to be moved, or does not hold.
    """
    cap, goal = servo.model.cyclic.torque_cap, servo.model.cyclic.goal
    _require_movable(servo)
    before = {name: servo.read(name) for name in (_TORQUE, cap, goal)}
    here = folded(servo, servo.read(servo.model.cyclic.position))
    if before[_TORQUE]:
        here = _held(servo, here, before[goal])
    largest = servo.model[cap].range
    assert largest is not None
    bound = min(before[cap], round(share * largest[1]))
    try:
        if servo.write(cap, bound).after != bound:
            raise ServoError(f"{servo} does not take a bound on its torque")
        servo.write(goal, here)
        if not servo.write(_TORQUE, 1).after:
            raise ServoError(f"the torque of {servo} does not come on")
        yield Gentle(servo, clock, check, here)
    finally:
        _restore(servo, before)


def folded(servo: Servo, counts: int) -> int:
    """Return a position within one turn: what a servo counts beyond it while it is limp, it forgets."""
    return counts % round(math.tau / servo.model.encoder.radians_per_tick)


def _require_movable(servo: Servo) -> None:
    faults = servo.faults()
    if faults:
        raise ServoError(
            f"{servo} reports a hardware error: {', '.join(faults)}; `robotwalk servo reboot {servo.id}` may clear it")
    wanted = servo.model.arming.require.get(_MODE)
    if wanted is not None and servo.read(_MODE) != wanted:
        raise ServoError(
            f"{servo} is not set to control its position: robotwalk servo write {servo.id} {_MODE}={wanted} --raw")


def _held(servo: Servo, here: int, goal: int) -> int:
    """Return the goal at which a servo is held by now; it must be near."""
    if abs(goal - here) * servo.model.encoder.radians_per_tick > _FAR:
        raise ServoError(f"{servo} has its torque on and is far from its goal: something holds it, or it is on its way")
    return goal


def _restore(servo: Servo, before: dict[str, int]) -> None:
    """Let go first, if the servo was limp; the bound comes back when nothing pulls any more."""
    names = sorted(before, key=lambda name: name != _TORQUE)
    if before[_TORQUE]:
        names = [servo.model.cyclic.goal, servo.model.cyclic.torque_cap]
    for name in names:
        for _ in range(_ATTEMPTS):
            try:
                servo.write(name, before[name])
                break
            except BusError:
                continue
        else:
            raise BusError(f"{servo} does not answer any more: its torque may still be on")
