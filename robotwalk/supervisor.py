"""What the robot is allowed to do now.

    STOP   torque off                      --arm-->   READY
    READY  torque on, holding its place    --stand--> STAND,  --disarm--> STOP
    STAND  rising to its feet, or standing --walk-->  WALK,   --sit-->    SIT
    WALK   stepping                        --halt-->  STAND,  --sit-->    SIT
    SIT    stepping to rest, lowering      --seated-> READY,  --stand--> STAND
    FAULT  as SIT, for a reason            --seated-> STOP, and stays there

A fault takes every state with torque on to FAULT; from STOP nothing can fault.
"""

from enum import Enum

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


class Supervisor:
    """Keeps the state; refuses what does not fit it."""

    def __init__(self) -> None:
        """Start in STOP."""
        self.state = State.STOP
        self.fault: str | None = None

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

    def step(self, trouble: str | None, *, seated: bool) -> State:
        """Take note of why the robot should come down, if it should, and of whether it is; return the state."""
        if trouble is not None and self.state is not State.STOP and self.fault is None:
            self.fault = trouble
            self.state = State.FAULT
        if seated:
            if self.state is State.SIT:
                self.state = State.READY
            elif self.state is State.FAULT:
                self.state = State.STOP
        return self.state
