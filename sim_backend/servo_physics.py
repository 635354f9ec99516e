"""The motors of a robot's servos and the control loops of their firmware, all servos at once.

Per servo, with e = goal - position in encoder ticks and f = `time_base_hz`:

    position loop   duty = (P e / 128 + I sum(e) / 65536 + D (v_goal - v) / 16 f + FF1 v_goal / 4 f
                            + FF2 a_goal / 4 f^2) / full-scale PWM
    velocity loop   the same with P / 128 and I / 65536 on the error of the velocity in register counts
    motor           torque = kt (V - kt w) / R with V = supply x duty; none with torque off (bridge open)

Divisors: e-Manual, X series, the gains' registers. Angles and speeds are the output shaft's, positive
counter-clockwise, 0 rad at the encoder's centre. Friction and armature act in MuJoCo. Not modelled: heat,
backlash, the firmware's own sampling period, which is the physics step.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hal.register_map import DynamixelFirmware, ServoModel
from sim_backend.control_table import ControlTable, OperatingMode
from sim_backend.motion_profile import Profile, Trajectories, profile_by_speed, profile_by_time

Floats = npt.NDArray[np.float64]
Supervisor = Callable[[int, float, float, float], None]  # now (ns), duty, supply (V), temperature (degC)

REVERSE = 0x01  # bits of drive_mode
TIME_BASED = 0x04
_INTEGRAL_DIVISOR = 65536
_DERIVATIVE_DIVISOR = 16
_FEED_FORWARD_DIVISOR = 4
_VELOCITY_DIVISOR = 128
_IN_POSITION_TICKS = 10  # unpublished
_IN_POSITION, _ONGOING, _KIND_SHIFT = 0x01, 0x02, 4  # moving_status; its bit for following errors stays 0
_SUPERVISION_NS = 5_000_000  # how often the firmware looks after its protections; assumed
_SECONDS = 1e-9  # per ns


def present_registers(model: ServoModel) -> tuple[str, ...]:
    """Return the names of the values of `ServoPhysics.present`, in their order."""
    return (
        "moving", "moving_status", "present_pwm", model.cyclic.effort, "present_velocity", "present_position",
        "velocity_trajectory", "position_trajectory", "present_input_voltage", "present_temperature")


class _Settings(NamedTuple):
    """What a new goal needs of a servo's registers. Position count = sign x ticks + zero."""

    mode: int
    sign: float
    zero: float
    time_based: bool
    profile_velocity: int
    profile_acceleration: int
    velocity_unit: float  # ticks/s per count
    acceleration_unit: float  # ticks/s^2 per count


def _sign(table: ControlTable) -> float:
    return -1.0 if table["drive_mode"] & REVERSE else 1.0


def _settings(model: ServoModel, table: ControlTable, turned: int) -> _Settings:
    mode, offset, turn = table["operating_mode"], table["homing_offset"], model.encoder.ticks_per_turn
    if mode == OperatingMode.POSITION and abs(offset) > turn // 4:
        offset = 0  # ignored there (e-Manual, Homing Offset)
    return _Settings(
        mode, _sign(table), model.encoder.centre + offset - turned, bool(table["drive_mode"] & TIME_BASED),
        table["profile_velocity"], table["profile_acceleration"],
        model["profile_velocity"].scale * turn / 60.0, model["profile_acceleration"].scale * turn / 3600.0)


def _gains(model: ServoModel, table: ControlTable, settings: _Settings) -> tuple[float, ...]:
    """Return P, I, D and both feed-forward gains in duty per tick and seconds."""
    loop, firmware = model.position_loop, model.firmware
    assert isinstance(firmware, DynamixelFirmware)
    rate = firmware.time_base_hz
    if settings.mode == OperatingMode.PWM:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    if settings.mode == OperatingMode.VELOCITY:
        duty = 1.0 / (loop.pwm_full_scale * settings.velocity_unit)  # of one PWM count per velocity count
        p, i = table["velocity_p_gain"] / _VELOCITY_DIVISOR, table["velocity_i_gain"] / _INTEGRAL_DIVISOR
        return p * duty, i * rate * duty, 0.0, 0.0, 0.0
    duty = 1.0 / loop.pwm_full_scale
    derivative = table["position_d_gain"] if firmware.derivative_gain else 0
    return (
        table[loop.proportional] / loop.divisor * duty,
        table["position_i_gain"] / _INTEGRAL_DIVISOR * rate * duty,
        derivative / _DERIVATIVE_DIVISOR / rate * duty,
        table["feedforward_1st_gain"] / _FEED_FORWARD_DIVISOR / rate * duty,
        table["feedforward_2nd_gain"] / _FEED_FORWARD_DIVISOR / rate**2 * duty)


class ServoPhysics:
    """The servos of one robot, in the order of `models`. Every public array is in that order."""

    def __init__(self, models: Sequence[ServoModel]) -> None:
        self.models = tuple(models)
        count = len(self.models)
        self.armature = self._of(lambda model: model.motor.armature_kgm2)  # for MuJoCo's joints
        self.coulomb = self._of(lambda model: model.motor.coulomb_nm)
        self.viscous = self._of(lambda model: model.motor.viscous_nms)
        self.supply_v = self._of(lambda model: model.specification.rated.voltage_v)  # may be set
        self.temperature_c = self._of(lambda model: model.firmware.temperature_c)  # may be set
        self.duty, self.current, self.torque, self.energy = np.zeros((4, count))  # 1, A, N m, J
        self._torque_constant = self._of(lambda model: model.motor.torque_constant_nm_per_a)
        self._ticks_per_radian = self._of(lambda model: 1.0 / model.encoder.radians_per_tick)
        self._ticks, self._velocity, self._voltage, self._power = np.zeros((4, count))
        self._conductance, self._limit, self._open_loop, self._sum = np.zeros((4, count))
        self._gains = np.zeros((5, count))  # P, I, D, FF1, FF2 in duty per tick, tick s, tick/s ...
        self._velocity_mode = np.zeros(count, bool)
        self._regulated: set[int] = set()  # servos that need more than P
        self._settings: dict[int, _Settings] = {}
        self._turned = [0] * count  # ticks, whole turns taken off the position
        self._goals = Trajectories(count)
        self._scale, self._offset = np.zeros((2, 8, count))  # of the present registers
        self._moving_threshold = np.zeros(count)
        self._present: list[list[int]] | None = None
        self._supervisors: dict[int, Supervisor] = {}
        self._now = 0
        self._supervise_at = 0

    def _of(self, value: Callable[[ServoModel], float]) -> Floats:
        return np.array([value(model) for model in self.models])

    def attach(self, index: int, supervisor: Supervisor) -> None:
        """Have a servo's `supervisor` called regularly, as long as the physics runs."""
        self._supervisors[index] = supervisor

    def step(self, position: Floats, velocity: Floats, now: int) -> Floats:
        """Return the motors' torques, N m, to hold until the next step. The array is reused.

        Args:
            position: the shafts' angles, rad, over many turns.
            velocity: rad/s.
            now: ns.
        """
        elapsed = (now - self._now) * _SECONDS
        self._now, self._present = now, None
        np.copyto(self._velocity, velocity)
        np.multiply(position, self._ticks_per_radian, out=self._ticks)
        np.rint(self._ticks, out=self._ticks)
        self._power *= elapsed
        self.energy += self._power
        if now >= self._supervise_at:
            self._supervise()
        duty = self.duty
        if self._goals.idle and not self._regulated:
            np.subtract(self._goals.position, self._ticks, out=duty)
            duty *= self._gains[0]
        else:
            self._run_loops(elapsed)
        np.minimum(duty, self._limit, out=duty)
        np.maximum(duty, -self._limit, out=duty)
        self._run_motors()
        return self.torque

    def _supervise(self) -> None:
        self._supervise_at = self._now + _SUPERVISION_NS
        duty, supply, temperature = self.duty.tolist(), self.supply_v.tolist(), self.temperature_c.tolist()
        for index, supervisor in self._supervisors.items():
            supervisor(self._now, duty[index], supply[index], temperature[index])

    def _run_loops(self, elapsed: float) -> None:
        """Set the duties by the full law; `step` has a short cut for proportional control alone."""
        goals, velocity_mode = self._goals, self._velocity_mode
        goals.advance(self._now)
        p, i, d, feed_speed, feed_acceleration = self._gains
        speed_error = goals.speed - self._velocity * self._ticks_per_radian
        error = np.where(velocity_mode, speed_error, goals.position - self._ticks)
        self._sum += i * error * elapsed
        np.clip(self._sum, -self._limit, self._limit, out=self._sum)  # against wind-up
        self.duty[:] = (
            p * error + self._sum + d * speed_error + feed_speed * goals.speed
            + feed_acceleration * goals.acceleration + self._open_loop)

    def _run_motors(self) -> None:
        np.multiply(self.supply_v, self.duty, out=self._voltage)
        np.multiply(self._torque_constant, self._velocity, out=self.current)
        np.subtract(self._voltage, self.current, out=self.current)
        self.current *= self._conductance
        np.multiply(self._torque_constant, self.current, out=self.torque)
        np.multiply(self._voltage, self.current, out=self._power)
        np.maximum(self._power, 0.0, out=self._power)

    def load(self, index: int, table: ControlTable) -> None:
        """Take a servo's settings from its registers. A profile applies from the next goal on."""
        model = self.models[index]
        on, mode = table["torque_enable"], table["operating_mode"]
        full = model.position_loop.pwm_full_scale
        self._settings[index] = settings = _settings(model, table, self._turned[index])
        pwm = mode == OperatingMode.PWM
        cap = table["pwm_limit"] if pwm else min(abs(table["goal_pwm"]), table["pwm_limit"])
        self._limit[index] = on * cap / full
        self._open_loop[index] = settings.sign * table["goal_pwm"] / full if pwm else 0.0
        self._gains[:, index] = gains = _gains(model, table, settings) if on else (0.0,) * 5
        if gains[1] == 0.0:
            self._sum[index] = 0.0
        if not on:
            self._goals.jump(index, float(self._ticks[index]))
        self._velocity_mode[index] = mode == OperatingMode.VELOCITY
        self._conductance[index] = on / model.motor.resistance_ohm
        if on and (pwm or mode == OperatingMode.VELOCITY or any(gains[1:])):
            self._regulated.add(index)
        else:
            self._regulated.discard(index)
        self._load_scales(index, model, settings)
        self._moving_threshold[index] = table["moving_threshold"]

    def _load_scales(self, index: int, model: ServoModel, settings: _Settings) -> None:
        sign, zero = settings.sign, settings.zero
        full = model.position_loop.pwm_full_scale
        speed = sign / settings.velocity_unit
        self._scale[:, index] = (
            sign * full, sign * model.cyclic.effort_full_scale, speed / model.encoder.radians_per_tick, sign,
            speed, sign, 1.0 / model["present_input_voltage"].scale, 1.0)
        self._offset[:, index] = 0.0, 0.0, 0.0, zero, 0.0, zero, 0.0, 0.0
        self._present = None

    def set_goal(self, index: int, table: ControlTable) -> None:
        """Head for the goal registers from where the trajectory is."""
        settings, goals = self._settings[index], self._goals
        self._present = None
        if settings.mode == OperatingMode.VELOCITY:
            speed = settings.sign * table["goal_velocity"] * settings.velocity_unit
            if settings.profile_acceleration:
                goals.follow(index, self._ramp(index, speed), self._now)
            else:
                goals.jump(index, float(goals.position[index]), speed)
            return
        position = settings.sign * (table["goal_position"] - settings.zero)
        if settings.profile_velocity:
            goals.follow(index, self._profile(index, position), self._now)
        else:
            goals.jump(index, position)

    def _ramp(self, index: int, goal_speed: float) -> Profile:
        settings, goals = self._settings[index], self._goals
        start, speed = float(goals.position[index]), float(goals.speed[index])
        acceleration = settings.profile_acceleration
        if settings.time_based:
            ramp_s = 1e-3 * acceleration
        else:
            ramp_s = abs(goal_speed - speed) / (acceleration * settings.acceleration_unit)
        return Profile(start, speed, ramp_s, goal_speed, math.inf, 0.0)

    def _profile(self, index: int, goal: float) -> Profile:
        settings, goals = self._settings[index], self._goals
        start, speed = float(goals.position[index]), float(goals.speed[index])
        velocity, acceleration = settings.profile_velocity, settings.profile_acceleration
        if settings.time_based:
            return profile_by_time(start, speed, goal, 1e-3 * velocity, 1e-3 * acceleration)
        return profile_by_speed(
            start, speed, goal, velocity * settings.velocity_unit, acceleration * settings.acceleration_unit)

    def restart(self, index: int, table: ControlTable) -> None:
        """Start from rest where the shaft is, as when torque comes on."""
        self._sum[index] = 0.0
        self._goals.jump(index, float(self._ticks[index]))
        self.load(index, table)
        self.set_goal(index, table)

    def fold(self, index: int, table: ControlTable) -> None:
        """Bring the position to within one turn, which is all that the encoder tells."""
        encoder = self.models[index].encoder
        count = encoder.centre + _sign(table) * float(self._ticks[index])
        self._turned[index] = math.floor(count / encoder.ticks_per_turn) * encoder.ticks_per_turn
        self.load(index, table)

    def present(self) -> list[list[int]]:
        """Return each servo's present values in counts, in the order of `present_registers`."""
        if self._present is None:
            self._present = self._read_sensors()
        return self._present

    def _read_sensors(self) -> list[list[int]]:
        goals = self._goals
        raw = np.array((
            self.duty, self.duty, self._velocity, self._ticks,
            goals.speed, goals.position, self.supply_v, self.temperature_c))
        counts = np.rint(raw * self._scale + self._offset)
        moving = goals.ongoing | (np.abs(counts[2]) > self._moving_threshold)
        arrived = ~goals.ongoing & (np.abs(goals.position - self._ticks) <= _IN_POSITION_TICKS)
        status = arrived * _IN_POSITION | goals.ongoing * _ONGOING | goals.kind << _KIND_SHIFT
        rows: list[list[int]] = np.vstack((moving, status, counts)).T.astype(np.int64).tolist()
        return rows
