"""A robot that is offered after a boot: torque off until somebody says stand."""

from collections.abc import Iterable

from robotwalk import assembly
from robotwalk.supervisor import State
from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.bridge import Bridge
from robotwalk.teleop.drive import Drive
from robotwalk.teleop.told import Told

PATIENCE = 5  # looks at the device


class Latecomer:
    """A driver that watches for a while, says stand, and leaves once it stands."""

    status, help = "late", ()

    def __init__(self) -> None:
        self.seen: list[Told] = []

    def poll(self, now: float, told: Told) -> Iterable[Ask]:
        self.seen.append(told)
        if len(self.seen) == PATIENCE:
            return [Ask("late", wish=Wish.STAND)]
        return [Ask("late", wish=Wish.QUIT)] if told.state == "stand" else []

    def answer(self, ask: Ask, refusal: str) -> None:
        raise AssertionError(refusal)

    def close(self) -> None:
        pass


def test_torque_is_off_until_a_driver_says_stand() -> None:
    robot, driver = assembly.simulate("hexapod").robot, Latecomer()
    states: list[tuple[int, State]] = []
    drive = Drive(
        robot, Bridge([driver], lambda command: None),
        lambda now, told, refusal: states.append((len(driver.seen), robot.loop.state)), seated=True)
    drive.run()
    waiting = [state for looks, state in states if looks < PATIENCE]
    assert waiting == [State.STOP] * (PATIENCE - 1)
    assert "torque is off" in driver.seen[1].note
    assert State.STAND in {state for _, state in states}
    assert "stand" in {told.state for told in driver.seen}
    assert robot.loop.state is State.STOP
