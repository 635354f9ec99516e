"""Heat, current and voltage: the robot eases its walk before servos let go, and sits while it can."""

import re

import pytest

from robotwalk import assembly
from robotwalk.config.safety import GovernorConfig
from robotwalk.errors import SafetyStop
from robotwalk.governor import Governed, Governor
from robotwalk.loop import Tick
from robotwalk.supervisor import State
from robotwalk.types import Measured, ServoCondition, ServoLimits, Vec3

from .bystander import Bystander

LIMITS = ServoLimits(hottest=70.0, lowest_voltage=6.0, highest_voltage=14.0, largest_current=2.0)


@pytest.mark.parametrize(("robot", "fault", "near", "nearer", "told"), [
    ("hexapod", "voltage_drop", {"supply_v": 6.5}, {"supply_v": 6.2},
     r"the battery is nearly empty: the servo of \w+ gets 6\.2 V, and lets go below 6\.0"),
    ("quadruped", "overheat", {"joint": "lf_calf", "temperature_c": 61}, {"joint": "lf_calf", "temperature_c": 68},
     r"a servo is too hot: the servo of lf_calf is at 68 degC, and lets go at 70"),
])
def test_it_walks_slower_and_lower_then_sits_before_any_servo_lets_go(
    robot: str, fault: str, near: dict[str, float], nearer: dict[str, float], told: str
) -> None:
    simulation = assembly.simulate(
        robot, faults=[{"at": 5.0, "fault": fault, **near}, {"at": 8.0, "fault": fault, **nearer}])
    bystander = Bystander(simulation)
    ticks: list[Tick] = []
    with simulation.robot as walker:
        walker.stand()
        walker.observers.append(ticks.append)
        with pytest.raises(SafetyStop, match=told):
            walker.walk(vx=0.10, seconds=9.0)
        assert simulation.bus.alerts == {}
    eased = next(tick for tick in ticks if tick.time * 1e-9 > 7.9)
    assert eased.state is State.WALK
    assert eased.wanted.twist.vx == pytest.approx(0.05)
    assert max(seen.height for seen in bystander.seen if 7.0 < seen.t < 7.9) < (
        simulation.robot.model.heights.stand - 0.005)
    assert next(tick.time * 1e-9 for tick in ticks if tick.state is State.FAULT) < 9.0
    assert [event.kind for event in simulation.robot.events].count("governor") == 1
    assert bystander.largest_tilt() < 6.0
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert bystander.fastest_drop() < 0.12
    assert bystander.sees_it_down()
    assert bystander.safe_after(8.0) < 5.0


def speeds(ticks: list[Tick], since: float, until: float) -> list[float]:
    """Return how fast ahead the robot was to be in that time, s, m/s."""
    return [tick.wanted.twist.vx for tick in ticks if since < tick.time * 1e-9 < until]


def test_a_walk_under_a_load_is_eased_for_the_current_that_takes_and_is_well_again_after() -> None:
    simulation = assembly.simulate("quadruped")
    bystander = Bystander(simulation)
    ticks: list[Tick] = []
    burden = Burden(simulation, newtons=62.0, since=5.0, until=10.0)
    with simulation.robot as walker:
        walker.stand()
        walker.observers.extend([ticks.append, burden])
        walker.walk(vx=0.05, gait="crawl", seconds=11.5)
        told = [event for event in walker.events if event.kind == "governor"]
    assert [event.text.partition(" for ")[0] for event in told] == [
        "slower and lower,", "well again: at the usual speed and height"]
    assert re.search(r"the servo of .._calf draws 1\.[34] A rms, of 3\.3 at most$", told[0].text)
    # In a crawl without a burden the same servos draw as much, but for moments of each step.
    eased, well = (event.t for event in told)
    assert 5.5 < eased < 9.0
    assert 10.0 < well < 13.5
    assert max(speeds(ticks, 4.0, 5.5)) > 0.045
    assert max(speeds(ticks, eased + 1.0, well)) < 0.026
    assert max(speeds(ticks, well, 14.0)) > 0.027
    low, again = (max(look.height for look in bystander.seen if since < look.t < until)
                  for since, until in ((eased + 1.0, 10.0), (14.5, 15.5)))
    assert low < simulation.robot.model.heights.stand - 0.02
    assert again == pytest.approx(simulation.robot.model.heights.stand, abs=4e-3)
    assert bystander.largest_tilt() < 15.0
    assert bystander.joints.beyond == bystander.joints.past_stops == {}


class Burden:
    """Somebody who leans on a walking robot, with so many newtons, for some time; s."""

    def __init__(self, simulation: assembly.Simulation, *, newtons: float, since: float, until: float) -> None:
        self._push = simulation.world.world.push
        self._turns = [(since, -newtons), (until, newtons)]

    def __call__(self, tick: Tick) -> None:
        """Look at the clock."""
        if self._turns and tick.time * 1e-9 >= self._turns[0][0]:
            self._push(Vec3(0.0, 0.0, self._turns.pop(0)[1]))


class Bench:
    """A governor of two servos, whose conditions are set by hand."""

    def __init__(self) -> None:
        self.told = {"temperature": 30.0, "voltage": 12.0, "current": 0.5}
        self.silent: set[str] = set()  # quantities that are not read anew
        self.governor = Governor(("lf_coxa", "rf_coxa"), GovernorConfig(), self.condition)
        self._last: dict[str, Measured] = {}
        self._now = 0  # ns

    def condition(self, slot: int) -> ServoCondition:
        if slot == 0:
            usual = {"temperature": Measured(30.0, 0), "voltage": Measured(12.0, 0), "current": Measured(0.1, 0)}
            return ServoCondition(**usual, holds=True, faults=(), limits=LIMITS)
        self._now += 100_000_000
        self._last |= {name: Measured(value, self._now) for name, value in self.told.items() if name not in self.silent}
        return ServoCondition(**self._last, holds=True, faults=(), limits=LIMITS)

    def looks(self, count: int) -> Governed:
        """Look so many times at each servo."""
        for _ in range(2 * count):
            governed = self.governor.step()
        return governed


@pytest.mark.parametrize(("quantity", "just_well", "near", "not_well_yet", "well"), [
    ("temperature", 59.4, 59.6, 57.0, 56.6),  # 0.85 of 70; back at 0.81
    ("voltage", 6.61, 6.59, 6.83, 6.85),  # 1.10 of 6; back at 1.14
])
def test_easing_begins_and_ends_once_three_readings_agree_and_not_at_the_same_value(
    quantity: str, just_well: float, near: float, not_well_yet: float, well: float
) -> None:
    bench = Bench()
    bench.told[quantity] = just_well
    assert not bench.looks(9).eased
    bench.told[quantity] = near
    assert not bench.looks(2).eased
    bench.told[quantity] = just_well
    assert not bench.looks(1).eased
    bench.told[quantity] = near
    assert not bench.looks(2).eased
    assert bench.looks(1).eased
    bench.told[quantity] = not_well_yet
    assert bench.looks(9).eased
    bench.told[quantity] = well
    assert bench.looks(2).eased
    assert not bench.looks(1).eased
    assert bench.governor.step().trouble is None


def test_a_reading_that_is_no_new_one_counts_no_more() -> None:
    bench = Bench()
    bench.told["temperature"] = 90.0
    assert not bench.looks(1).eased
    bench.silent.add("temperature")
    assert not bench.looks(9).eased
    bench.silent.clear()
    assert bench.looks(2).trouble == "a servo is too hot: the servo of rf_coxa is at 90 degC, and lets go at 70"


def test_currents_are_judged_by_the_root_of_their_mean_square_over_seconds() -> None:
    bench = Bench()

    def swing(peak: float, count: int) -> Governed:
        """Draw as a leg does that steps: nothing, and a peak to and fro."""
        for turn in range(count):
            bench.told["current"] = (0.0, peak, 0.0, -peak)[turn % 4]
            governed = bench.looks(1)
        return governed

    assert not swing(0.6, 200).eased  # 0.42 A rms
    bench.told["current"] = 2.0  # all of the limit, for 0.4 s
    assert not bench.looks(4).eased
    assert not swing(1.0, 200).eased  # 0.71 A
    assert swing(1.25, 200).eased  # 0.88 A, of 0.4 times 2
    assert swing(1.06, 200).eased  # 0.75 A; back at 0.72
    assert not swing(0.95, 200).eased
    bench.told["current"] = -2.0
    assert bench.looks(15).eased  # held fast: within 1.5 s


def test_currents_alone_make_no_robot_sit() -> None:
    bench = Bench()
    bench.told["current"] = 1000.0
    governed = bench.looks(9)
    assert governed.eased
    assert governed.trouble is None
