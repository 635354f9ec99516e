"""What the robot is allowed to do now.

    STOP   torque off                      --arm-->   READY
    READY  torque on, holding its place    --stand--> STAND,  --disarm--> STOP
    STAND  rising to its feet, or standing --walk-->  WALK,   --sit-->    SIT
    WALK   stepping                        --halt-->  STAND,  --sit-->    SIT
    SIT    stepping to rest, lowering      --seated-> READY,  --stand--> STAND
    FAULT  as SIT, for a reason            --seated-> STOP, and stays there

A fault takes every state with torque on to FAULT; from STOP nothing can fault.
"""

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType

from robotwalk.errors import UsageError


class State(Enum):
    """The states, in the order of a session."""

    STOP = "stop"
    READY = "ready"
    STAND = "stand"
    WALK = "walk"
    SIT = "sit"
    FAULT = "fault"


class Request(Enum):
    """What may be asked of the supervisor."""

    ARM = "arm"
    STAND = "stand"
    WALK = "walk"
    HALT = "halt"
    SIT = "sit"
    DISARM = "disarm"


TRANSITIONS: dict[tuple[State, Request], State] = {
    (State.STOP, Request.ARM): State.READY,
    (State.READY, Request.STAND): State.STAND,
    (State.READY, Request.DISARM): State.STOP,
    (State.STAND, Request.WALK): State.WALK,
    (State.STAND, Request.SIT): State.SIT,
    (State.WALK, Request.HALT): State.STAND,
    (State.WALK, Request.SIT): State.SIT,
    (State.SIT, Request.STAND): State.STAND,
}


# Ticks in a row that must find a joint stale: a computer that stalled for a second finds all of them so, once.
_AGREEING = 5


class Supervisor:
    """Keeps the state; refuses what does not fit it."""

    def __init__(self, stale_after: float) -> None:
        """Start in STOP. A joint unheard of for longer than `stale_after` s is a fault."""
        self.state = State.STOP
        self.fault: str | None = None
        self._stale_after = stale_after
        self._stale_ticks = self._alert_ticks = 0

    def request(self, request: Request) -> None:
        """Change the state as asked.

        Raises:
            UsageError: the robot cannot do that from its present state.
        """
        if self.fault is not None:
            raise UsageError(f"cannot {request.value}: the robot stopped because {self.fault}")
        after = TRANSITIONS.get((self.state, request))
        if after is None:
            raise UsageError(f"cannot {request.value} in state {self.state.name}")
        self.state = after

    def step(
        self, oldest_joint: tuple[str, float], seated: bool, alerts: Mapping[str, str] = MappingProxyType({})
    ) -> State:
        """Take note of the oldest joint sample (name, s), of alerts and of the body's height; return the state."""
        joint, age = oldest_joint
        self._stale_ticks = self._stale_ticks + 1 if age > self._stale_after else 0
        self._alert_ticks = self._alert_ticks + 1 if alerts else 0
        if self.state is not State.STOP and self.fault is None:
            if self._stale_ticks >= _AGREEING:
                self._fail(f"joint {joint} has not answered for {age:.2f} s")
            elif self._alert_ticks >= _AGREEING:
                self._fail("; ".join(f"the servo of {joint} {words}" for joint, words in alerts.items()))
        if seated:
            if self.state is State.SIT:
                self.state = State.READY
            elif self.state is State.FAULT:
                self.state = State.STOP
        return self.state

    def _fail(self, reason: str) -> None:
        self.fault = reason
        self.state = State.FAULT
