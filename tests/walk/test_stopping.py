"""Whatever fails while a robot is stopped: torque goes off, or is said to be on; ports are given back; it is told."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.cli.ending import run_to_end
from robotwalk.errors import SafetyStop
from robotwalk.loop import Loop, Tick
from robotwalk.supervisor import State

from .test_imu import KINDS, with_imu

CASES = [
    *[(point, 1) for point in ("loop.tick", "loop.disarm", "_bus.exchange", "observer")],
    *[(point, 1_000_000) for point in ("loop.tick", "loop.disarm", "_bus.exchange", "observer")],
    *[(point, 1_000_000) for point in (
        "_bus.disarm", "_bus.close", "port.write", "_chronicle._recorder.event",
        "_chronicle._recorder.close", "black_box.add", "black_box.save", "_imu.read", "_imu.close")]]


class Enough(Exception):
    """The program that drives the robot fails."""


def fail(owner: Any, name: str, times: int) -> Callable[..., Any]:
    """Return a method that raises a few times, and then does what it did."""
    works, left = getattr(owner, name), [times]

    def broken(*arguments: Any, **named: Any) -> Any:
        if left[0] > 0:
            left[0] -= 1
            raise RuntimeError("injected")
        return works(*arguments, **named)

    return broken


@pytest.mark.parametrize(("point", "times"), CASES)
def test_an_error_at_any_point_of_stopping_is_told_and_stops_nothing_else(
    point: str, times: int, tmp_path: Path,
) -> None:
    robot_file = str(with_imu(tmp_path, KINDS["wt901"])) if "imu" in point else "quadruped"
    simulation = assembly.simulate(robot_file, log=tmp_path / "log.mcap")
    assembly.add_black_box(simulation, tmp_path)
    robot, ports = simulation.robot, simulation.world.ports
    closed: list[str] = []

    def listen(owner: Any, name: str) -> None:
        close = owner.close

        def told() -> None:
            closed.append(name)
            close()

        owner.close = told

    for line, port in ports.items():
        listen(port, line)
    owner: Any = robot
    *path, name = point.split(".")
    for part in path:
        owner = ports["legs"] if part == "port" else getattr(owner, part)
    ticks: list[Tick] = []

    def drive(tick: Tick) -> None:
        ticks.append(tick)
        if len(ticks) == 20:
            raise Enough

    raised: BaseException | None = None
    try:
        with robot:
            robot.observers.append(drive)
            try:
                robot.stand()
            finally:
                if point == "observer":
                    robot.observers.append(fail(ticks, "append", times))
                else:
                    setattr(owner, name, fail(owner, name, times))
                if point == "black_box.save":
                    robot.note("stop", "as a test")
    except (Enough, SafetyStop) as error:
        raised = error
    assert raised is not None
    on = {joint for joint, servo in zip(robot.model.joint_names, simulation.world.servos, strict=True)
          if servo.table["torque_enable"]}
    assert on <= set(robot.doubtful)
    assert bool(robot.doubtful) == (robot.torque_doubt is not None)
    if times == 1:
        assert on == set()
    if point != "_bus.close":
        assert set(closed) >= {"legs"}
    told = [event.text for event in robot.events if event.kind in ("error", "torque", "log", "safety_stop")]
    assert any("injected" in text for text in told) or (point == "port.write" and told), robot.events


def test_a_walk_asked_for_in_the_tick_of_a_stop_is_a_safety_stop_and_no_wrong_usage() -> None:
    simulation = assembly.simulate("quadruped")
    loop, robot = simulation.robot.loop, simulation.robot
    assert isinstance(loop, Loop)

    def clear(tick: Tick) -> None:
        if tick.state is State.HELD:
            loop.clear()

    def run() -> None:
        with robot:
            robot.stand()
            robot.observers.append(clear)
            loop.hold()
            robot.walk(vx=0.05, seconds=1.0)

    code, sentence = run_to_end(robot, run)
    assert code == 5
    assert sentence is not None
    assert "was held in place" in sentence
    assert loop.state is State.STOP
