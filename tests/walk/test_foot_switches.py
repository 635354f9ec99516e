"""A hexapod with foot switches: from MuJoCo's contacts through the bytes of their board to what its feet do."""

from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.config import library
from robotwalk.errors import ConfigError
from robotwalk.loop import Tick
from robotwalk.testing import FakeRobot

# The left middle foot has none.
SWITCHES = "port: /dev/ttyUSB1, inputs: {lf: 3, lr: 2, rf: 8, rm: 15, rr: 0}"


def with_switches(folder: Path, section: str = SWITCHES) -> Path:
    """Write the hexapod's file, foot switches fitted, and return its path."""
    text = library.open_document("robots", "hexapod").text
    path = folder / "hexapod_switches.yaml"
    path.write_text(text.replace("hardware:\n", f"hardware:\n  foot_switches: {{{section}}}\n"))
    return path


def test_feet_go_by_their_switches_and_by_their_loads_while_the_board_is_silent(tmp_path: Path) -> None:
    with FakeRobot(with_switches(tmp_path), terrain="rough_15") as fake:
        ticks: list[Tick] = []
        right = wrong = 0

        def watch(tick: Tick) -> None:
            nonlocal right, wrong
            ticks.append(tick)
            for switch, touches in zip(tick.estimate.switches, fake.contacts.values(), strict=True):
                right += switch.closed is touches
                wrong += switch.closed is not None and switch.closed is not touches

        fake.robot.stand()
        fake.robot.observers.append(watch)
        fake.robot.walk(vx=0.06, seconds=3.0)
        heard = len(ticks)
        assert right > 5 * 0.95 * heard  # a report is 5 ms old, and feet may touch without the switch's force
        assert wrong < 5 * 0.05 * heard
        for tick in ticks:
            for name, switch, felt in zip(fake.contacts, tick.estimate.switches, tick.estimate.felt, strict=False):
                if name == "lm":
                    assert switch.closed is None
                elif felt is not None and switch.closed is not None:
                    assert felt.touching is felt.sure is switch.closed
        fake.befall("unplug", bus="feet", for_=2.0)
        fake.robot.walk(vx=0.06, seconds=2.0)
        silent = ticks[heard + 12:heard + 190]
        assert not any(switch.closed is not None for tick in silent for switch in tick.estimate.switches)
        by_load = [felt.touching for tick in silent for felt in tick.estimate.felt if felt is not None]
        assert 0.4 < sum(by_load) / len(by_load) < 0.9
        fake.robot.walk(vx=0.06, seconds=3.0)
        assert not fake.fell
        statistics = fake.robot.foot_switch_statistics()
    told = [event.text for event in fake.robot.events if event.kind == "feet"]
    assert told == ["the foot-switch board is silent", "the foot-switch board is heard again"]
    assert statistics is not None
    assert statistics.max_age == pytest.approx(2.0, abs=0.1)
    assert fake.displacement.x == pytest.approx(8.0 * 0.06, rel=0.15)


def test_a_switch_that_is_stuck_wins_over_the_load(tmp_path: Path) -> None:
    """No foot presses hard enough to close one; the left middle foot has none, and goes by its load."""
    section = SWITCHES + ", closes_at_n: 100"
    log = tmp_path / "walk.mcap"
    simulation = assembly.simulate(str(with_switches(tmp_path, section)), log=log)
    felt = []
    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(lambda tick: felt.append(tick.estimate.felt))
        robot.walk(vx=0.0, seconds=0.3)
        assert [foot.touching for foot in felt[-1]] == [False, True, False, False, False, False]
        assert all(foot.load > 1.0 for foot in felt[-1])
    assert replay(log).difference is None


@pytest.mark.parametrize(("section", "complaint"), [
    ("port: x, inputs: {lf: 0, xx: 1}", "inputs.xx: the robot has no such leg; it has lf, lm, lr, rf, rm, rr"),
    ("port: x, inputs: {lf: 0, lm: 0}", "inputs.lm: already the input of lf"),
    ("port: x, inputs: {lf: 16}", "less than 16"),
    ("port: x, inputs: {lf: 0}, baud: 9600", "carries 192 reports a second, and the board sends 200"),
    ("port: x, inputs: {lf: 0}, rate_hz: 10", "hardly longer than from one report to the next, at 10 Hz"),
    ("port: x, inputs: {}", "expected 1 or more items"),
])
def test_switches_that_cannot_be_are_refused_with_their_line(section: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        assembly.load(str(with_switches(tmp_path, section)))
    assert "hexapod_switches.yaml:4" in str(caught.value)
    assert complaint in str(caught.value)
