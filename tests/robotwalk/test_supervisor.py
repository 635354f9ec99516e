"""What may be asked for in which state."""

import pytest

from robotwalk.errors import UsageError
from robotwalk.supervisor import Request, State, Supervisor

ALLOWED = {
    ("stop", "arm"): "ready",
    ("ready", "stand"): "stand",
    ("ready", "disarm"): "stop",
    ("stand", "walk"): "walk",
    ("stand", "sit"): "sit",
    ("walk", "halt"): "stand",
    ("walk", "sit"): "sit",
    ("sit", "stand"): "stand",
    ("mend", "walk"): "mend",
    ("mend", "halt"): "mend",
    ("mend", "stand"): "mend",
    ("mend", "sit"): "sit",
}
WITH_TORQUE = [State.READY, State.STAND, State.WALK, State.SIT, State.MEND]


def supervisor(state: State) -> Supervisor:
    made = Supervisor()
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
    assert Supervisor().state is State.STOP


@pytest.mark.parametrize("state", State)
def test_being_seated_ends_sitting_down(state: State) -> None:
    ends = {State.SIT: State.READY, State.FAULT: State.STOP}
    helping = "a servo let go" if state is State.MEND else None
    assert supervisor(state).step(None, seated=False, helping=helping) is state
    assert supervisor(state).step(None, seated=True, helping=helping) is ends.get(state, state)


@pytest.mark.parametrize(("state", "asked", "after"), [
    (State.WALK, None, State.WALK), (State.STAND, None, State.STAND),
    (State.WALK, Request.HALT, State.STAND), (State.STAND, Request.WALK, State.WALK),
])
def test_a_robot_that_lay_down_for_a_servo_gets_up_and_goes_on(
    state: State, asked: Request | None, after: State
) -> None:
    watched = supervisor(state)
    assert watched.step(None, seated=False, helping="a servo let go") is State.MEND
    assert watched.step(None, seated=True, helping="a servo let go") is State.MEND
    if asked is not None:
        watched.request(asked)
    assert watched.step(None, seated=True) is State.STAND
    # Another one lets go as it rises.
    assert watched.step(None, seated=False, helping="a servo let go") is State.MEND
    assert watched.step(None, seated=False) is State.STAND
    assert watched.step(None, seated=False) is State.STAND
    assert watched.step(None, seated=False, standing=True) is after


def test_nobody_is_helped_while_the_robot_sits_down() -> None:
    watched = supervisor(State.WALK)
    watched.step(None, seated=False, helping="a servo let go")
    watched.request(Request.SIT)
    assert watched.step(None, seated=False, helping="a servo let go") is State.FAULT


@pytest.mark.parametrize("state", WITH_TORQUE)
def test_trouble_brings_the_robot_down_and_keeps_it_there(state: State) -> None:
    watched = supervisor(state)
    assert watched.step("a leg is off", seated=False) is State.FAULT
    assert watched.step("another one is", seated=False) is State.FAULT
    # It may pass: the robot sits down all the same, and stays there.
    assert watched.step(None, seated=False) is State.FAULT
    assert watched.step(None, seated=True) is State.STOP
    assert watched.step("a leg is off", seated=True) is State.STOP
    for request in Request:
        with pytest.raises(UsageError, match=f"cannot {request.value}: the robot stopped because a leg is off"):
            watched.request(request)
        assert watched.state is State.STOP


def test_without_torque_nothing_faults() -> None:
    idle = supervisor(State.STOP)
    assert idle.step("a leg is off", seated=False) is State.STOP
    assert idle.fault is None
    idle.request(Request.ARM)
    assert idle.state is State.READY
