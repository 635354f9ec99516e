"""Nobody talks to the servos for a while: between two calls, or since the wire is broken. They hold, and go on."""

from pathlib import Path

from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.loop import Tick
from robotwalk.supervisor import State

from .rig import walk


def test_a_pause_between_calls_trips_no_watchdog_and_misses_no_deadline() -> None:
    simulation = assembly.simulate("hexapod")
    bus, clock = simulation.bus.lines[0], simulation.clock
    servos = bus.servos
    with simulation.robot as robot:
        robot.stand()
        standing = simulation.world.truth().base.z
        clock.wait((), clock.now() + 3_000_000_000)
        assert simulation.world.truth().base.z > standing - 0.002
        assert bus.read_register(clock, servos[0], "bus_watchdog") == 0
        robot.walk(vx=0.05, seconds=0.5)
        assert bus.read_register(clock, servos[0], "bus_watchdog") == 0
        clock.wait((), clock.now() + 3_000_000_000)
    statistics = robot.bus_statistics()["legs"]
    assert statistics.watchdog_trips == 0
    assert statistics.lost_replies == 0
    assert robot.loop.missed == 0
    assert [event.kind for event in robot.events] == ["state"] * len(robot.events)
    assert simulation.world.truth().base.z < 0.05, "it sat down at the end"


def test_a_run_with_pauses_replays(tmp_path: Path) -> None:
    log = tmp_path / "log.mcap"
    simulation = assembly.simulate("hexapod", log=log)
    with simulation.robot as robot:
        robot.stand()
        simulation.world.clock.wait((), simulation.world.clock.now() + 1_000_000_000)
        robot.walk(vx=0.05, seconds=0.3)
    found = replay(log)
    assert found.difference is None
    assert found.damage is None
    assert found.ticks > 200


def test_a_wire_broken_for_a_moment_trips_the_watchdogs_and_the_walk_goes_on() -> None:
    """Nobody is asked whether it tripped: a sync write has no answer. It shows as their conditions are read in turn."""
    broken = {"at": 5.0, "fault": "unplug", "bus": "legs", "for": 0.3}
    report = walk("hexapod", speed=0.08, duration=5.0, faults=[broken])
    assert report["bus"]["legs"]["watchdog_trips"] == 18
    assert 0.25 < report["distance_m"] < 0.42, "it stood for half a second or less"
    assert not report["fell"]
    assert [event["kind"] for event in report["events"] if event["kind"] not in ("state", "audit", "limits")] == []


def test_a_stop_while_it_sits_down_at_the_end_holds_it_until_it_is_cleared() -> None:
    simulation = assembly.simulate("hexapod")
    robot = simulation.robot
    heights: list[float] = []

    def stop_halfway(tick: Tick) -> None:
        height = simulation.world.truth().base.z
        if tick.state is State.SIT and height < 0.07 and not heights:
            robot.loop.hold()
        if tick.state is State.HELD:
            heights.append(height)
            if len(heights) == 100:
                robot.loop.clear()

    robot.observers.append(stop_halfway)
    with robot:
        robot.stand()
    assert len(heights) == 100
    assert max(heights[10:]) - min(heights[10:]) < 0.002, "it is held in place, a second long"
    assert simulation.world.truth().base.z < 0.04
    assert robot.torque_doubt is None
