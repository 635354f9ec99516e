"""What the robot is allowed to do now.

    STOP   torque off                      --arm-->   READY
    READY  torque on, holding its place    --stand--> STAND,  --disarm--> STOP
    STAND  rising to its feet, or standing --walk-->  WALK,   --sit-->    SIT
    WALK   stepping                        --halt-->  STAND,  --sit-->    SIT
    SIT    stepping to rest, lowering      --seated-> READY,  --stand--> STAND
    MEND   as SIT, to help a servo         --mended-> STAND, and on with what it was at
    FAULT  as SIT, for a reason            --seated-> STOP, and stays there, unless it fell
    HELD   frozen in place                 --clear--> SIT or FAULT

A fault takes every state with torque on to FAULT; from STOP nothing can fault. A servo that can be helped takes
STAND and WALK to MEND. Somebody who says `stop` takes every state with torque on to HELD, where nothing moves, not even
for a fault.
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
    MEND = "mend"
    FAULT = "fault"
    HELD = "held"


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
    (State.MEND, Request.WALK): State.MEND,  # and then go on with that
    (State.MEND, Request.HALT): State.MEND,
    (State.MEND, Request.STAND): State.MEND,
    (State.MEND, Request.SIT): State.SIT,
}
_WITH_TORQUE = (State.READY, State.STAND, State.WALK, State.SIT, State.MEND)
# What comes about without a request; `Supervisor` does it, and tests see to it that this is what it does.
BY_ITSELF: tuple[tuple[State, State, str], ...] = (
    (State.SIT, State.READY, "seated"),
    (State.STAND, State.MEND, "a servo needs help"),
    (State.WALK, State.MEND, "a servo needs help"),
    (State.MEND, State.STAND, "mended"),
    (State.STAND, State.WALK, "standing again after that"),
    *((state, State.FAULT, "a fault") for state in _WITH_TORQUE),
    (State.FAULT, State.STOP, "seated"),
    *((state, State.HELD, "stop") for state in (*_WITH_TORQUE, State.FAULT)),
    (State.HELD, State.SIT, "clear"),
    (State.HELD, State.FAULT, "clear, after a fault"),
)
_UP = {Request.WALK: State.WALK, Request.HALT: State.STAND, Request.STAND: State.STAND}


class Supervisor:
    """Keeps the state; refuses what does not fit it."""

    def __init__(self) -> None:
        """Start in STOP."""
        self.state = State.STOP
        self.fault: str | None = None
        self._passes = False  # the fault, once the robot is down
        self._resumes: State | None = None  # what it goes on with, once a servo is helped and the robot stands

    @property
    def low(self) -> bool:
        """Whether the body is down, or on its way there or back, for something that was found."""
        return self.state is State.MEND or self.fault is not None or self._resumes is not None

    def request(self, request: Request) -> None:
        """Change the state as asked.

        Raises:
            UsageError: the robot cannot do that from its present state.
        """
        if self.fault is not None:
            raise UsageError(f"cannot {request.value}: the robot stopped because {self.fault}")
        if self._resumes is not None and request in _UP:
            self._resumes = _UP[request]
            return
        after = TRANSITIONS.get((self.state, request))
        if after is None:
            raise UsageError(f"cannot {request.value} in state {self.state.name}")
        self.state, self._resumes = after, None

    def hold(self) -> None:
        """Let the robot hold where it is, until `clear`."""
        if self.state is not State.STOP:
            self.state, self._resumes = State.HELD, None

    def clear(self) -> None:
        """Let a held robot go: it sits down."""
        if self.state is State.HELD:
            self.state = State.SIT if self.fault is None else State.FAULT

    def step(
        self, trouble: str | None, *, seated: bool, standing: bool = False, helping: str | None = None,
        passes: bool = False,
    ) -> State:
        """Take note of what was found in a tick; return the state.

        Args:
            trouble: why the robot should come down, in words; None: nothing.
            seated: whether the body is down.
            standing: whether it is up, all feet at rest.
            helping: why it should come down for a while, in words; None: no servo needs help.
            passes: whether the trouble is over once the robot is down: it may be asked to stand up again.
        """
        state = self.state
        if helping is not None and state in (State.STAND, State.WALK):
            self._resumes = self._resumes or state
            self.state = State.MEND
        elif helping is not None and state is not State.MEND:
            trouble = trouble or helping  # nobody is helped on the way down
        elif state is State.MEND and helping is None:
            self.state = State.STAND
        elif state is State.STAND and standing and self._resumes is not None:
            self.state, self._resumes = self._resumes, None
        if trouble is not None and state is not State.STOP and self.fault is None:
            self.fault, self._resumes, self._passes = trouble, None, passes
            self.state = State.FAULT if state is not State.HELD else state
        elif seated:
            if self.state is State.SIT:
                self.state = State.READY
            elif self.state is State.FAULT:
                self.state = State.STOP
                self.fault = None if self._passes else self.fault
        return self.state
