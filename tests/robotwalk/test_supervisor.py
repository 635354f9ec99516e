"""What may be asked for in which state."""

import pytest

from robotwalk.errors import UsageError
from robotwalk.supervisor import Request, State, Supervisor

FRESH = ("lf_coxa", 0.0)
ALLOWED = {
    ("stop", "arm"): "ready",
    ("ready", "stand"): "stand",
    ("ready", "disarm"): "stop",
    ("stand", "walk"): "walk",
    ("stand", "sit"): "sit",
    ("walk", "halt"): "stand",
    ("walk", "sit"): "sit",
    ("sit", "stand"): "stand",
}
WITH_TORQUE = [State.READY, State.STAND, State.WALK, State.SIT]


def supervisor(state: State) -> Supervisor:
    made = Supervisor(0.5)
    made.state = state
    return made


@pytest.mark.parametrize("request_", Request)
@pytest.mark.parametrize("state", State)
def test_every_request_in_every_state(state: State, request_: Request) -> None:
    asked = supervisor(state)
    after = ALLOWED.get((state.value, request_.value))
    if after is None:
        with pytest.raises(UsageError, match=f"cannot {request_.value} in state {state.name}"):
            asked.request(request_)
        assert asked.state is state
    else:
        asked.request(request_)
        assert asked.state is State(after)


def test_a_robot_begins_without_torque() -> None:
    assert Supervisor(0.5).state is State.STOP


@pytest.mark.parametrize("state", State)
def test_being_seated_ends_sitting_down(state: State) -> None:
    ends = {State.SIT: State.READY, State.FAULT: State.STOP}
    assert supervisor(state).step(FRESH, seated=False) is state
    assert supervisor(state).step(FRESH, seated=True) is ends.get(state, state)


@pytest.mark.parametrize("state", WITH_TORQUE)
def test_a_joint_unheard_of_is_a_fault(state: State) -> None:
    watched = supervisor(state)
    assert watched.step(("rm_tibia", 0.5), seated=False) is state
    # Once may be the computer's own stall; five ticks in a row are the joint's silence.
    for age in (0.51, 0.52, 0.53, 0.54):
        assert watched.step(("rm_tibia", age), seated=False) is state
    assert watched.step(FRESH, seated=False) is state
    for age in (0.51, 0.52, 0.53, 0.54):
        assert watched.step(("rm_tibia", age), seated=False) is state
    assert watched.step(("rm_tibia", 0.55), seated=False) is State.FAULT
    assert watched.fault == "joint rm_tibia has not answered for 0.55 s"
    assert watched.step(("rf_coxa", 3.0), seated=False) is State.FAULT
    assert watched.fault == "joint rm_tibia has not answered for 0.55 s"
    # The joint may come back: the robot sits down all the same, and stays there.
    assert watched.step(FRESH, seated=False) is State.FAULT
    assert watched.step(FRESH, seated=True) is State.STOP
    assert watched.step(("rm_tibia", 9.0), seated=True) is State.STOP
    for request in Request:
        with pytest.raises(UsageError, match=f"cannot {request.value}: the robot stopped because joint rm_tibia"):
            watched.request(request)
        assert watched.state is State.STOP


def test_without_torque_nothing_faults() -> None:
    idle = supervisor(State.STOP)
    assert idle.step(("rm_tibia", 100.0), seated=False) is State.STOP
    assert idle.fault is None
    idle.request(Request.ARM)
    assert idle.state is State.READY
