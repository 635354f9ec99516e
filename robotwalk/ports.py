"""What the loop needs from outside itself. `hal` and `sim_backend` implement these.

Time is an integer count of nanoseconds on a clock that never goes back. Whatever blocks, blocks in
`Clock.wait`, so that simulated time can pass there.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from robotwalk.types import BusStatistics, FootSwitch, ImuState, JointState, SensorStatistics, ServoCondition


class BytePort(Protocol):
    """One end of a serial line. No call blocks."""

    def fileno(self) -> int:
        """Return the descriptor that `WallClock` polls, or -1 where there is none (simulated)."""
        ...

    def write(self, data: bytes) -> None:
        """Queue `data` for sending."""
        ...

    def waiting(self) -> int:
        """Return how many bytes have arrived and were not read yet."""
        ...

    def read(self) -> bytes:
        """Return every byte that has arrived and was not read yet; b"" if there is none."""
        ...

    def close(self) -> None:
        """Give the line back. May be called twice."""
        ...


class Clock(Protocol):
    """Wall time, or simulated time that passes only while somebody waits."""

    def now(self) -> int:
        """Return the time in ns."""
        ...

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Return once a port has bytes to read or the clock has reached `deadline` (ns), if not already."""
        ...


class Revival(Protocol):
    """A servo that is being brought back."""

    @property
    def over(self) -> bool:
        """Whether it is back, or cannot be brought back."""
        ...

    @property
    def failure(self) -> str | None:
        """Why it could not be brought back, in words that follow "the servo of lf_coxa: "."""
        ...


class ServoBus(Protocol):
    """All the robot's joints, over however many wires."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints' names; every sequence below is in this order."""
        ...

    @property
    def alerts(self) -> Mapping[str, str]:
        """What is wrong with servos, by their joints, in words that follow "the servo of lf_coxa"."""
        ...

    @property
    def reseeded(self) -> Collection[int]:
        """Joints that the last exchange has sent to where they are, and not to their goals: they had stopped there."""
        ...

    @property
    def notes(self) -> Sequence[str]:
        """What the last arming mended or found worth telling, in words."""
        ...

    def conditions(self) -> Mapping[str, ServoCondition]:
        """Return what each servo last told of itself, by its joint."""
        ...

    def condition(self, slot: int) -> ServoCondition:
        """Return what the servo of one joint last told of itself: the same objects, until it tells anew."""
        ...

    def curable(self, slot: int) -> bool | None:
        """Tell whether what is wrong with a joint's servo may be mended by `revive`; None: that is not known yet."""
        ...

    def revive(self, slot: int) -> Revival:
        """Begin to bring a joint's servo back that has let go, over the next exchanges; it holds then where it is."""
        ...

    def soften(self, share: float) -> None:
        """Bound the output of all servos to a share of the largest, with the next exchange, until armed anew."""
        ...

    def arm(self, period: int, torque: float = 1.0) -> JointState:
        """Find every servo, let it hold where it is, switch torque on.

        Args:
            period: of the cycle that shall follow, ns.
            torque: share of the largest output that the servos may use.

        Raises:
            BusError: a servo is missing, is another model or not fit to walk, or the bus is too slow. Torque is then
                off, unless the robot was found standing on it.
        """
        ...

    def exchange(self, goals: Sequence[float], period: int) -> JointState:
        """Write the goals (rad) to all joints and read all of them back, within `period` ns."""
        ...

    def pause(self) -> None:
        """Let every servo hold as it does, with nobody talking to it, until the next `exchange`. Never raises."""
        ...

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        ...

    def close(self) -> None:
        """Give the ports back. Never raises."""
        ...

    def statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        ...


class Imu(Protocol):
    """A sensor that tells how the base lies, of its own accord."""

    def read(self) -> ImuState | None:
        """Take what has come, without waiting; return what is known now. None: nothing has been heard yet."""
        ...

    def statistics(self) -> SensorStatistics:
        """Return what it said since its port was opened."""
        ...

    def close(self) -> None:
        """Give the port back. Never raises."""
        ...


class StopInput(Protocol):
    """A button, a key or a pull cord that stops the robot."""

    def read(self) -> str | None:
        """Take a reading; return why the robot is to stop, in words, or None if it may move. Never raises.

        It may wait for seconds.
        """
        ...

    def close(self) -> None:
        """Give the port back. Never raises."""
        ...


class FootSwitches(Protocol):
    """Switches under the feet, of a board that tells of its own accord which are closed."""

    def read(self) -> tuple[FootSwitch, ...]:
        """Take what has come, without waiting; return what is known of each foot now, in the order of the legs."""
        ...

    def statistics(self) -> SensorStatistics:
        """Return what the board said since its port was opened."""
        ...

    def close(self) -> None:
        """Give the port back. Never raises."""
        ...
