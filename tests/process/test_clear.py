"""A robot that is held stays so while one of its servos has let go, whoever says `clear`."""

import os
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.errors import SafetyStop
from robotwalk.loop import Loop
from robotwalk.process.servant import Servant
from robotwalk.process.shared import Mailbox, Stop, create
from robotwalk.process.stop_input import StopWatch
from robotwalk.supervisor import State


def test_clear_is_refused_for_an_alert_and_sit_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    descriptor, _ = create("hexapod")
    mailbox = Mailbox(descriptor)
    overload = {"at": 1.0, "for": 4.0, "fault": "overload", "joint": "lm_femur"}
    simulation = assembly.simulate("hexapod", faults=[overload])
    loop = simulation.robot.loop
    assert isinstance(loop, Loop)
    servant = Servant(
        loop, simulation.bus, {}, simulation.clock, mailbox, -1, (), 10.0,  # type: ignore[arg-type]  # no pulse here
        StopWatch(mailbox.stop_input, None))

    def tell(stop: Stop) -> str:
        mailbox.post_stop(stop)
        servant._listen()
        message = mailbox.heed.read()
        assert message is not None
        return message.data.decode()

    states: list[State] = []
    refused = ""

    def held() -> None:
        nonlocal refused
        with simulation.robot as walker:
            walker.stand()
            assert tell(Stop.HOLD).startswith("holds where it is")
            assert tell(Stop.CLEAR) == "sits down"
            assert tell(Stop.HOLD).startswith("holds where it is")
            for _ in range(1000):
                if simulation.bus.alerts:
                    break
                loop.tick()
            refused = tell(Stop.CLEAR)
            for _ in range(100):
                states.append(loop.tick().state)
            assert tell(Stop.SIT) == "sits down"
            states.append(loop.tick().state)

    with pytest.raises(SafetyStop, match="lm_femur reports overload; torque is off"):
        held()
    assert refused.startswith("stays held, for the servo of lm_femur reports overload")
    assert refused.endswith("; `robotwalk stop --sit` lets it down all the same")
    assert set(states[:-1]) == {State.HELD}
    assert states[-1] is not State.HELD
    os.close(descriptor)
