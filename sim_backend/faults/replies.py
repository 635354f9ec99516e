"""Faults of single replies: of each servo's own, be it a status of its own or its block of a fast sync read."""

from abc import abstractmethod
from random import Random
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from sim_backend.fake_servo import Interference
from sim_backend.faults.fault import End, ServoFault, all_ends
from sim_backend.reply import Reply

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot

_NS_PER_MS = 1e6


class ReplyFault(ServoFault):
    """A fault that befalls a share of a servo's replies."""

    rate: Annotated[float, Field(gt=0, le=1, description="share of each servo's replies")] = 1.0

    @abstractmethod
    def _spoil(self, reply: Reply, chance: Random) -> Reply | None:
        """Return what becomes of a reply that it befalls."""

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        return all_ends([self._befall(robot, index, Random(chance.random())) for index in self.indices(robot)])

    def _befall(self, robot: "SimulatedRobot", index: int, chance: Random) -> End:
        """Stand in the way of one servo's replies, with chances of its own."""
        def interfere(reply: Reply) -> Reply | None:
            return self._spoil(reply, chance) if chance.random() < self.rate else reply

        interferences: list[Interference] = robot.servos[index].interferences
        interferences.append(interfere)
        return lambda: interferences.remove(interfere)


class DropReply(ReplyFault):
    """A reply never comes.

    Those listed behind it in a sync read stay silent too, unless their firmware has `later_ids_answer`; a fast
    sync read ends there.
    """

    fault: Literal["drop_reply"]

    def _spoil(self, reply: Reply, chance: Random) -> None:
        return None


class CorruptFrame(ReplyFault):
    """One byte of a reply, anyone, arrives as another. Its checksum is that of what was sent."""

    fault: Literal["corrupt_frame"]

    def _spoil(self, reply: Reply, chance: Random) -> Reply:
        data = bytearray(reply.data)
        data[chance.randrange(len(data))] ^= chance.randrange(1, 256)
        return Reply(reply.delay_ns, bytes(data))


class DelayReply(ReplyFault):
    """A reply comes later than it should. Those whose turn is behind it wait for it."""

    fault: Literal["delay_reply"]
    delay_ms: Annotated[float, Field(gt=0, le=1e6, description="ms on top of the servo's return delay")]

    def _spoil(self, reply: Reply, chance: Random) -> Reply:
        return Reply(reply.delay_ns + round(self.delay_ms * _NS_PER_MS), reply.data)
