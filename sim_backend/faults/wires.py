"""Faults of a whole bus."""

from collections.abc import Collection, Iterator, Mapping
from random import Random
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from sim_backend.faults.fault import End, Joint, LastingFault, all_ends

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot
    from sim_backend.wire import SimulatedPort

_NS_PER_MS = 1e6


class Noise(LastingFault):
    """Bytes on the wire that nobody sent, which servos and host hear.

    They come between frames; what spoils frames is corrupt_frame.
    """

    fault: Literal["noise"]
    bus: Annotated[str | None, Field(description="only this bus; imu, feet, stop: only that sensor's line")] = None
    largest: Annotated[int, Field(ge=1, le=1000, description="bytes of the longest burst")] = 8
    every_ms: Annotated[float, Field(ge=0.1, le=1e6, description="ms from one burst to the next")] = 10.0

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        ports = [port for bus, port in robot.ports.items() if self.bus in (None, bus)]
        return all_ends([self._disturb(robot, port, Random(chance.random())) for port in ports])

    def _disturb(self, robot: "SimulatedRobot", port: "SimulatedPort", chance: Random) -> End:
        period, over = round(self.every_ms * _NS_PER_MS), False

        def burst() -> None:
            if not over:
                port.disturb(chance.randbytes(chance.randint(1, self.largest)))
                robot.clock.schedule(robot.clock.now() + period, burst)

        def end() -> None:
            nonlocal over
            over = True

        burst()
        return end


class Unplug(LastingFault):
    """The data line of a bus, or of a sensor, is cut: the host and what is on it hear nothing of each other.

    What is on it keeps its power: servos go on towards their last goals. It is silence on a served port too: what was
    pulled is the cable behind the adapter.
    """

    fault: Literal["unplug"]
    bus: Annotated[str, Field(description="name of the bus; imu, feet, stop: that sensor's line")]

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        port = robot.ports[self.bus]
        port.cuts += 1

        def end() -> None:
            port.cuts -= 1
        return end


class DuplicateId(LastingFault):
    """A servo answers to another one's id on the same bus: both obey, both answer at once, and its own id is silent.

    What is heard of the two is garbage.
    """

    fault: Literal["duplicate_id"]
    joint: Joint
    id_of: Annotated[str, Field(description="name of the joint whose id it takes")]

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        servo = robot.servos[robot.joints.index(self.joint)]
        own = servo.id
        servo.answer_to(robot.servos[robot.joints.index(self.id_of)].id)
        return lambda: servo.answer_to(own)

    def complaints(
        self, wiring: Mapping[str, str], other_lines: Collection[str] = ()
    ) -> Iterator[tuple[str, str, Any]]:
        """Yield key, problem and value where it does not fit a robot."""
        yield from super().complaints(wiring)
        if self.joint == self.id_of:
            yield "id_of", "that is its own id", self.id_of
        elif wiring.get(self.joint) != wiring.get(self.id_of):
            yield "id_of", f"not on the same bus as {self.joint}", self.id_of
