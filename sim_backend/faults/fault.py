"""What faults have in common: when they begin and end, and whom they befall."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping
from random import Random
from typing import TYPE_CHECKING, Annotated, Any, get_args

from pydantic import Field

from robotwalk.config.schema import Section

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot

End = Callable[[], None]

Joint = Annotated[str, Field(description="name of the joint")]
Seconds = Annotated[float, Field(gt=0, le=1e6)]


class Fault(Section, ABC):
    """Something that goes wrong at a time. Its first key, `fault`, is its name."""

    at: Annotated[float, Field(ge=0, le=1e6, description="s of simulated time since the simulation began")]

    @classmethod
    def kind(cls) -> str:
        """Return the fault's name."""
        name: str = get_args(cls.model_fields["fault"].annotation)[0]
        return name

    @property
    def lasts(self) -> float | None:
        """How long it lasts, s; None is until the simulation ends, or all that it does is done at once."""
        return None

    @abstractmethod
    def begin(self, robot: "SimulatedRobot", chance: Random) -> End | None:
        """Let it happen to a robot now; return what ends it, if anything does."""

    def complaints(
        self, wiring: Mapping[str, str], other_lines: Collection[str] = ()
    ) -> Iterator[tuple[str, str, Any]]:
        """Yield key, problem and value where it does not fit a robot, of which `wiring` tells each joint's bus."""
        for key in self.model_fields_set & {"joint", "id_of"}:
            yield from _unless_known(key, getattr(self, key), "joint", wiring)
        for key in self.model_fields_set & {"bus"}:
            lines = dict.fromkeys([*wiring.values(), *other_lines], "")
            yield from _unless_known(key, getattr(self, key), "bus", lines)


class LastingFault(Fault):
    """A fault that may pass."""

    duration: Annotated[Seconds | None, Field(alias="for", description="s that it lasts; left out, to the end")] = None

    @property
    def lasts(self) -> float | None:
        """How long it lasts, s; None is until the simulation ends."""
        return self.duration


class ServoFault(LastingFault):
    """A fault of one servo, of those of a bus, or of all."""

    joint: Annotated[str | None, Field(description="only the servo of this joint")] = None
    bus: Annotated[str | None, Field(description="only the servos of this bus")] = None

    def indices(self, robot: "SimulatedRobot") -> list[int]:
        """Return the servos that it befalls."""
        return [
            index for index, (joint, bus) in enumerate(zip(robot.joints, robot.buses, strict=True))
            if self.joint in (None, joint) and self.bus in (None, bus)]

    def complaints(
        self, wiring: Mapping[str, str], other_lines: Collection[str] = ()
    ) -> Iterator[tuple[str, str, Any]]:
        """Yield key, problem and value where it does not fit a robot. Its servos are on none of `other_lines`."""
        yield from super().complaints(wiring)
        if self.joint is not None and self.bus not in (None, wiring.get(self.joint)):
            yield "bus", f"joint {self.joint} is not on it", self.bus


def _unless_known(key: str, name: str | None, what: str, known: Mapping[str, str]) -> Iterator[tuple[str, str, Any]]:
    if name is not None and name not in known:
        yield key, f"this robot has no such {what}; it has {', '.join(known)}", name


def all_ends(ends: list[End]) -> End:
    """Return what calls each of them."""
    def end() -> None:
        for each in ends:
            each()
    return end
