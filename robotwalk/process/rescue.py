"""A robot without a loop is brought down: held where it is, moved joint by joint to its seat, torque off.

Nothing of the loop that failed has a part in it but the gate: no gait, no feet, no estimate.
"""

from collections.abc import Sequence
from typing import Protocol

from robotwalk.clock import Grid
from robotwalk.limits import Gate
from robotwalk.ports import Clock
from robotwalk.process.shared import Stop
from robotwalk.process.stop_input import StopWatch
from robotwalk.types import JointState
from robotwalk.unfold import Unfold

_RATE_HZ = 50
_PERIOD = 1_000_000_000 // _RATE_HZ
_HOLD = 1.0  # s, while the body comes to rest and people see that something is wrong
_SETTLE = 0.3  # s, seated, before torque goes


class OrphanBus(Protocol):
    """What a servo bus offers who takes it over from somebody who died."""

    def adopt(self, believed: Sequence[float]) -> JointState:
        """Have every servo hold where it is; `believed` (rad) is where those are that do not answer."""
        ...

    def exchange(self, goals: Sequence[float], period: int) -> JointState:
        """Write the goals (rad) to all joints and read all of them back, within `period` ns."""
        ...

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        ...


def bring_down(
    bus: OrphanBus, clock: Clock, gate: Gate, believed: Sequence[float], seat: Sequence[float], watch: StopWatch,
) -> list[str]:
    """Hold the robot, lower it, switch its torque off.

    Args:
        bus: nobody else talks on it any more.
        clock: the wall's.
        gate: of the goals; none has passed it yet.
        believed: where the joints should be by what was heard last, rad.
        seat: where they are when it sits, rad.
        watch: of the stop input, which keeps the robot where it is, or has it let go.

    Returns:
        The joints at which torque may still be on.
    """
    goals: Sequence[float] = bus.adopt(believed).position
    gate.reset(goals)
    lowering = Unfold(goals, seat)
    grid = Grid(_RATE_HZ, after=clock.now())
    left = {"hold": round(_HOLD * _RATE_HZ), "settle": round(_SETTLE * _RATE_HZ)}
    while left["settle"]:
        clock.wait((), grid.deadline)
        heeded = watch.look()
        if heeded is not None and heeded.stop is Stop.LIMP:
            break
        if left["hold"]:
            left["hold"] -= 1
        elif heeded is None or heeded.stop is not Stop.HOLD:
            goals = lowering.step(1.0 / _RATE_HZ)
            left["settle"] -= lowering.done
        bus.exchange(gate.step(goals, 1.0 / _RATE_HZ), _PERIOD)
        grid.advance(clock.now())
    return bus.disarm()
