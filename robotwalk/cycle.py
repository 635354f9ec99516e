"""What a driver has of the loop, be it in the same process or in one of its own."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Protocol

from robotwalk.loop import Tick
from robotwalk.supervisor import Request, State
from robotwalk.timing import Histogram
from robotwalk.types import BusStatistics, Command, JointState, SensorStatistics, ServoCondition


class BusReports(Protocol):
    """A servo bus for who does not talk on it; see `robotwalk.ports.ServoBus`."""

    @property
    def notes(self) -> Sequence[str]:
        """What the last arming mended or found worth telling, in words."""
        ...

    def conditions(self) -> Mapping[str, ServoCondition]:
        """Return what each servo last told of itself, by its joint."""
        ...

    def statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        ...

    def close(self) -> None:
        """Give the ports back. Never raises."""
        ...


class SensorReports(Protocol):
    """An IMU, or a board of foot switches, for who does not read it."""

    def statistics(self) -> SensorStatistics:
        """Return what it said since its port was opened."""
        ...

    def close(self) -> None:
        """Give the port back. Never raises."""
        ...


class Cycle(Protocol):
    """A loop to be driven; see `robotwalk.loop.Loop`."""

    command: Command

    @property
    def rate_hz(self) -> int:
        """Ticks per second."""
        ...

    @property
    def state(self) -> State:
        """What the robot is allowed to do now."""
        ...

    @property
    def fault(self) -> str | None:
        """Why the robot was brought down, if it was."""
        ...

    @property
    def low(self) -> bool:
        """Whether the robot is on its way down for a reason, or on its way up from there."""
        ...

    @property
    def armed(self) -> bool:
        """Whether torque was switched on, or partly, and not off since."""
        ...

    @property
    def wake(self) -> Histogram:
        """How late the ticks began."""
        ...

    @property
    def exchange(self) -> Histogram:
        """How long the bus and the IMU took."""
        ...

    @property
    def compute(self) -> Histogram:
        """How long all else took."""
        ...

    @property
    def missed(self) -> int:
        """How many grid points were skipped."""
        ...

    @property
    def cuts(self) -> Counter[tuple[str, str]]:
        """How many goals the gate has cut, by joint and by what."""
        ...

    def digest(self) -> str:
        """Return a hash of every joint position read and every goal sent so far."""
        ...

    def beat(self) -> None:
        """Show that whoever drives the robot is still there."""
        ...

    def request(self, request: Request) -> None:
        """Have the supervisor change the state. Raises UsageError if it may not."""
        ...

    def arm(self, torque: float = 1.0) -> JointState:
        """Have the bus switch torque on, every joint where it is. Raises BusError."""
        ...

    def begin(self, state: JointState) -> None:
        """Take over joints that hold their places, as `arm` returned them."""
        ...

    def tick(self) -> Tick:
        """Wait for the next tick and return it. Raises SafetyStop if there will be none any more."""
        ...

    def pause(self) -> None:
        """Let the robot stand as it does: the driver has nothing to say for a while."""
        ...

    def hold(self) -> None:
        """Have every joint stay where it is, whatever the driver wants, until `clear`."""
        ...

    def clear(self) -> None:
        """Let a held robot go: it sits down, and may then stand up."""
        ...

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        ...

    def freeze(self) -> None:
        """Hold every joint where it is, for good: there will be no loop any more."""
        ...
