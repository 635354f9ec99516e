"""A simulated robot in one process and in lock-step: its world, its servos, its wires, one clock."""

from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import NamedTuple

from hal.register_map import ServoModel
from robotwalk.model import RobotModel
from sim_backend.adapter import ADAPTERS, AdapterName
from sim_backend.brands import make_device, make_servo
from sim_backend.fake_foot_switches import FakeFootSwitches, SimulatedFootSwitches
from sim_backend.fake_imu import FakeImu, SimulatedImu
from sim_backend.fake_servo import FakeServo
from sim_backend.fake_stop_board import FakeStopBoard, SimulatedStopBoard
from sim_backend.servo_physics import ServoPhysics
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.talker import Talker
from sim_backend.terrain.course import FLAT, Ground
from sim_backend.wire import SimulatedPort
from sim_backend.world import Mounting, Truth, World

_NS = 1_000_000_000


class SimulatedServo(NamedTuple):
    """One servo to be made."""

    bus: str
    id: int
    model: ServoModel
    mounting: Mounting


class SimulatedRobot:
    """A seated robot, torque off, whose servos have return delay 0.

    Time passes only in `clock.wait`. Each of `ports` is the host's end of a bus or of a sensor's line; `observers` are
    called after every physics step. `joints` and `buses` tell what each of `servos` moves and which bus it is on.
    """

    def __init__(
        self, model: RobotModel, servos: Sequence[SimulatedServo], bauds: Mapping[str, int], seated: Sequence[float],
        *, rate_hz: int, seed: int = 0, adapter: AdapterName = "none", supply_v: float | None = None,
        internal_resistance: float = 0.0, ground: Ground = FLAT, imu: tuple[str, SimulatedImu] | None = None,
        foot_switches: tuple[str, SimulatedFootSwitches] | None = None,
        stop_board: tuple[str, SimulatedStopBoard] | None = None, hung: bool = False,
    ) -> None:
        """Build the robot; `servos` and `seated` (rad) are in joint order; one supply (V, ohm) feeds them all.

        `imu`, `foot_switches` and `stop_board` are the name of a port and what talks there; `hung`: it is on a stand.

        Raises:
            ValueError: a bus has a baud that its servos do not have, or servos of two protocols.
        """
        self.clock = SimulatedClock()
        self.joints = model.joint_names
        self.buses = tuple(servo.bus for servo in servos)
        self.physics = ServoPhysics(
            [servo.model for servo in servos], supply_v=supply_v, internal_resistance=internal_resistance)
        self.world = World(
            model, self.physics, [servo.mounting for servo in servos], seated, rate_hz=rate_hz, seed=seed,
            ground=ground, imu=imu[1].mounting if imu is not None else None, hung=hung)
        # Servos find their shafts where the world has put them.
        self.servos = [
            make_servo(
                self.physics, index, id=servo.id, baud_rate=servo.model.baud_value(bauds[servo.bus]),
                return_delay_time=0)
            for index, servo in enumerate(servos)
        ]
        self.ports = {
            bus: SimulatedPort(self.clock, make_device(bus, self._on(bus, servos)), baud, ADAPTERS[adapter]())
            for bus, baud in bauds.items()
        }
        if imu is not None:
            name, sensor = imu
            self._add_talker(name, FakeImu(sensor, self.world.felt, seed), sensor.baud, adapter, seed)
        if foot_switches is not None:
            name, board = foot_switches
            self._add_talker(name, FakeFootSwitches(board, self.world.pressed), board.baud, adapter, seed)
        self.stop_board: FakeStopBoard | None = None
        if stop_board is not None:
            name, button = stop_board
            self.stop_board = FakeStopBoard(button)
            self._add_talker(name, self.stop_board, button.baud, adapter, seed)
        self.observers: list[Callable[[], None]] = []
        self._steps = 0
        self._schedule_step()

    def truth(self) -> Truth:
        """Return what is the case now."""
        return self.world.truth()

    def _add_talker(self, name: str, device: Talker, baud: int, adapter: AdapterName, seed: int) -> None:
        self.ports[name] = SimulatedPort(self.clock, device, baud, ADAPTERS[adapter]())
        device.begin(self.clock, self.ports[name], Random(f"{name} {seed}").random())

    def _on(self, bus: str, servos: Sequence[SimulatedServo]) -> list[FakeServo]:
        return [fake for fake, servo in zip(self.servos, servos, strict=True) if servo.bus == bus]

    def _schedule_step(self) -> None:
        """Steps end on an exact grid, so that ticks and steps never drift apart."""
        self._steps += 1
        self.clock.schedule(self._steps * _NS // self.world.steps_per_second, self._step)

    def _step(self) -> None:
        self.world.step(self.clock.now())
        self._schedule_step()
        for observer in self.observers:
            observer()
