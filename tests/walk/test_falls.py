"""A robot that is pushed over lets its legs be soft, draws them in, goes limp; set upright again, it stands."""

from pathlib import Path

import numpy as np
import pytest

from robotwalk import assembly
from robotwalk.errors import SafetyStop
from robotwalk.loop import Tick
from robotwalk.supervisor import State

from .bystander import Bystander

AT = 5.0  # s
NS = 1_000_000_000


def with_imu(robot: str, folder: Path) -> str:
    """Write a robot's file, an IMU fitted, and return its path."""
    path = folder / f"{robot}_imu.yaml"
    path.write_text(assembly.load(robot).document.text.replace(
        "hardware:\n", "hardware:\n  imu: {kind: bno085-rvc, port: /dev/ttyAMA0, baud: 115200}\n"))
    return str(path)


class Hand:
    """Holds the robot level in the air."""

    def __init__(self, simulation: assembly.Simulation) -> None:
        self._data, self._clock = simulation.world.world.data, simulation.clock
        self._observers = simulation.world.observers
        self._seat = simulation.robot.model.heights.sit + 0.01
        self._height, self._step = 0.25, 0.0  # m, and by how much it goes down in a step of the physics
        self.since = self._clock.now() * 1e-9  # s
        self._observers.append(self._hold)

    def _hold(self) -> None:
        self._height = max(self._height - self._step, self._seat)
        self._data.qpos[2:7] = [self._height, 1.0, 0.0, 0.0, 0.0]
        self._data.qvel[:6] = np.zeros(6)

    def set_down(self) -> None:
        """Lower it onto its belly, and let it go."""
        self._step = 3e-4
        self._clock.wait((), self._clock.now() + 2 * NS)
        assert self._height == self._seat
        self._observers.remove(self._hold)


@pytest.mark.parametrize(("robot", "imu", "force", "way", "told", "within"), [
    ("quadruped", True, 60.0, 90.0, r"it fell: it lies (4[5-9]|[5-9]\d|1\d\d) deg off level", 1.0),
    ("hexapod", False, 90.0, 0.0, r"it fell, or was lifted: its legs push it up with \d+ % of its weight", 4.0),
])
def test_a_robot_that_is_pushed_over_goes_soft_and_limp_and_stands_again_once_it_is_set_upright(
    robot: str, imu: bool, force: float, way: float, told: str, within: float, tmp_path: Path
) -> None:
    push = {"at": AT, "for": 0.3, "fault": "push", "force_n": force, "direction_deg": way}
    simulation = assembly.simulate(with_imu(robot, tmp_path) if imu else robot, faults=[push])
    bystander = Bystander(simulation)
    ticks: list[Tick] = []
    soft: list[int] = []

    def look(tick: Tick) -> None:
        ticks.append(tick)
        if tick.state is State.FAULT:
            soft.append(max(servo.table[servo.model.cyclic.torque_cap] for servo in simulation.world.servos))

    with simulation.robot as walker:
        walker.stand()
        walker.observers.append(look)
        with pytest.raises(SafetyStop, match=told):
            walker.walk(vx=0.10, seconds=20.0)
        fell = next(tick.time * 1e-9 for tick in ticks if tick.state is State.FAULT)
        assert fell - AT < within
        assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)
        full = simulation.world.servos[0].model
        register = full[full.cyclic.torque_cap]
        assert register.range is not None
        assert max(soft[2:]) <= 0.41 * register.range[1], "with two fifths of the torque it draws its legs in"
        simulation.clock.wait((), simulation.clock.now() + NS)
        assert max(look.speed for look in bystander.after(bystander.seen[-1].t - 0.2)) < 0.8, "limp legs sink"
        assert bystander.largest_tilt() > 45.0
        assert bystander.joints.past_stops == {}, "its own weight turns joints, to their stops and no farther"
        Hand(simulation).set_down()
        walker.stand()
        assert simulation.world.truth().base.z > 0.8 * walker.model.heights.stand
    assert bystander.sees_it_down()


def test_a_robot_that_is_lifted_in_its_walk_stops_kicking_and_stands_again_once_it_is_set_down() -> None:
    simulation = assembly.simulate("pentapod")
    bystander = Bystander(simulation)
    with simulation.robot as walker:
        walker.stand()
        walker.walk(vx=0.1, seconds=1.0)
        hand = Hand(simulation)
        with pytest.raises(SafetyStop, match=r"was lifted: its legs push it up with [0-2]?\d % of its weight"):
            walker.walk(vx=0.1, seconds=4.0)
        simulation.clock.wait((), simulation.clock.now() + NS // 2)
        assert max(look.speed for look in bystander.after(bystander.seen[-1].t - 0.1)) < 1.0, "limp legs hang"
        assert bystander.seen[-1].t - hand.since < 4.5
        hand.set_down()
        walker.stand()
        assert simulation.world.truth().base.z > 0.8 * walker.model.heights.stand
