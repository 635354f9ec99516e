"""The motors of a robot's servos and the control loops of their firmware: all servos at once, of any brand.

In encoder ticks and seconds, duty as a share of the supply voltage, with the `Gains` of each servo:

    position loop   duty = P (goal - position) + sum of I (goal - position) dt + D (v_goal - v)
                           + FF1 v_goal + FF2 a_goal + punch, towards the goal; none within the margin
    velocity loop   the same, where the velocity's error takes the place of the position's
    current limit   duty between (kt w + R I) / supply for the lowest and the highest current I allowed
    motor           torque = kt (V - kt w) / R with V = supply x duty; none with the bridge open (torque off)

Ticks, angles and speeds are the output shaft's, positive counter-clockwise, 0 at the encoder's centre. What
registers make of them is the firmware's. Friction, armature and backlash lie behind the motor: `gear_train`.

    supply          V = V0 - Ri x sum of duty x current over all servos, as of the step before: a battery sags
    winding         dT/dt = (T_air + Rth R I^2 - T) / tau

Not modelled: the firmware's own sampling period, which is the physics step; inductance, commutation, what heat does to
resistance and magnets, what the electronics draw themselves, noise of the encoders.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hal.register_map import ServoModel
from sim_backend.motion_profile import Profile, Trajectories

Floats = npt.NDArray[np.float64]

_IN_POSITION_TICKS = 10  # unpublished
_SUPERVISION_NS = 5_000_000  # how often the firmware looks after its protections; assumed
_SECONDS = 1e-9  # per ns
_UNLOADED = 0.2  # of the stall current, below which no load strains the motor, however much duty it has; assumed
_LEAST_SUPPLY = 0.3  # of its voltage, below which the supply does not sag
_DEAD_SUPPLY = 1e-3  # V, below which there is no current to be limited


class Gains(NamedTuple):
    """Of a control loop: duty per tick of error, or per tick/s in a velocity loop."""

    proportional: float = 0.0
    integral: float = 0.0  # per s
    derivative: float = 0.0  # s
    feed_speed: float = 0.0  # duty per tick/s of the goal's speed
    feed_acceleration: float = 0.0  # duty per tick/s^2
    margin: float = 0.0  # an error up to this counts as none
    punch: float = 0.0  # duty towards the goal, added to the loop's as soon as there is an error


class Drive(NamedTuple):
    """How a servo's firmware drives its motor."""

    on: bool  # whether the bridge is closed; open, the shaft turns freely
    largest_duty: float = 0.0
    gains: Gains = Gains()
    velocity_loop: bool = False  # else a position loop
    duty: float = 0.0  # added to the loop's
    currents: tuple[float, float] = (-math.inf, math.inf)  # A, between which the firmware keeps the motor's


class Scales(NamedTuple):
    """What a servo reports: counts = sign x scale x value, but position = sign x ticks + zero."""

    sign: int  # -1 where counts grow clockwise
    zero: float  # counts
    duty: float  # counts at 1
    load: float  # counts at duty 1
    speed: float  # counts per tick/s
    current: float  # counts per A
    supply: float  # counts per V
    moving_above: float  # counts of speed


class Present(NamedTuple):
    """What a servo reports, in counts, or 0 and 1."""

    moving: int
    arrived: int  # whether the shaft is where a profile has ended
    in_profile: int
    profile_shape: int  # 0 step, 1 rectangle, 2 triangle, 3 trapezoid
    duty: int
    load: int
    speed: int
    position: int
    goal_speed: int  # of the profile
    goal_position: int
    current: int
    supply: int
    temperature: int


Supervisor = Callable[[int, float, float, float, float], None]  # now (ns), duty under load, A, V at it, degC
_SCALED = 9  # the last fields of Present are scaled values


class ServoPhysics:
    """The servos of one robot, in the order of `models`. Every public array is in that order."""

    def __init__(
        self, models: Sequence[ServoModel], *, supply_v: float | None = None, internal_resistance: float = 0.0
    ) -> None:
        """Feed all from one supply, of their rated voltages if it has none of its own (V, ohm)."""
        self.models = tuple(models)
        count = len(self.models)
        self.supply_v = self._of(  # without load; may be set
            lambda model: model.specification.rated.voltage_v if supply_v is None else supply_v)
        self.terminal_v = self.supply_v.copy()  # with it
        self._internal_resistance = internal_resistance
        self.temperature_c = self._of(lambda model: model.firmware.temperature_c)  # may be set
        self.duty, self.current, self.torque, self.energy = np.zeros((4, count))  # 1, A, N m, J
        self._torque_constant = self._of(lambda model: model.motor.torque_constant_nm_per_a)
        self._resistance = self._of(lambda model: model.motor.resistance_ohm)
        self._air_c = self.temperature_c.copy()
        self._thermal_resistance = self._of(lambda model: model.motor.thermal_resistance_k_per_w)
        self._thermal_rate = self._of(lambda model: 1.0 / model.motor.thermal_time_constant_s)
        self._heated_at = 0
        self._ticks_per_radian = self._of(lambda model: 1.0 / model.encoder.radians_per_tick)
        self._ticks, self._velocity, self._rotor_speed, self._voltage, self._power = np.zeros((5, count))
        self._conductance, self._limit, self._open_loop, self._sum = np.zeros((4, count))
        self._gains = np.zeros((len(Gains._fields), count))
        self._velocity_loop = np.zeros(count, bool)
        self._regulated: set[int] = set()  # servos that need more than P
        self._drops = np.zeros((2, count))  # V across the windings at the lowest and the highest current
        self._current_limited: set[int] = set()
        self._goals = Trajectories(count)
        self._scale, self._offset = np.zeros((2, _SCALED, count))
        self._moving_above = np.zeros(count)
        self._rows = np.zeros((len(Present._fields), count))
        self._present: list[list[int]] | None = None
        self._supervisors: dict[int, Supervisor] = {}
        self.strained: set[int] = set()  # servos whose firmware takes the motor for fully driven
        self._now = 0
        self._supervise_at = 0

    def _of(self, value: Callable[[ServoModel], float]) -> Floats:
        return np.array([float(value(model)) for model in self.models])

    def attach(self, index: int, supervisor: Supervisor) -> None:
        """Have a servo's `supervisor` called regularly, as long as the physics runs."""
        self._supervisors[index] = supervisor

    def step(self, position: Floats, velocity: Floats, now: int, rotor_speed: Floats | None = None) -> Floats:
        """Return the motors' torques, N m, to hold until the next step. The array is reused.

        Args:
            position: the shafts' angles, rad, over many turns.
            velocity: rad/s.
            now: ns.
            rotor_speed: rad/s at the shaft, where it is not the shaft's.
        """
        elapsed = (now - self._now) * _SECONDS
        self._now, self._present = now, None
        np.copyto(self._velocity, velocity)
        np.copyto(self._rotor_speed, velocity if rotor_speed is None else rotor_speed)
        np.multiply(position, self._ticks_per_radian, out=self._ticks)
        np.rint(self._ticks, out=self._ticks)
        self._power *= elapsed
        self.energy += self._power
        self._sag()
        if now >= self._supervise_at:
            self._supervise()
        duty = self.duty
        if self._goals.idle and not self._regulated:
            np.subtract(self._goals.position, self._ticks, out=duty)
            duty *= self._gains[0]
        else:
            self._run_loops(elapsed)
        if self._current_limited:
            self._limit_currents()
        np.minimum(duty, self._limit, out=duty)
        np.maximum(duty, -self._limit, out=duty)
        self._run_motors()
        return self.torque

    def _sag(self) -> None:
        """Take from the supply what its internal resistance takes."""
        if self._internal_resistance:
            sag = self._internal_resistance * max(float(np.dot(self.duty, self.current)), 0.0)
            np.subtract(self.supply_v, sag, out=self.terminal_v)
            np.maximum(self.terminal_v, _LEAST_SUPPLY * self.supply_v, out=self.terminal_v)
        else:
            np.copyto(self.terminal_v, self.supply_v)

    def _supervise(self) -> None:
        self._supervise_at = self._now + _SUPERVISION_NS
        self._heat()
        loaded = np.abs(self.current) * self._resistance > _UNLOADED * self.terminal_v
        duty, current = np.where(loaded, self.duty, 0.0).tolist(), self.current.tolist()
        for index in self.strained:
            duty[index] = math.copysign(1.0, self.duty[index])
        supply, temperature = self.terminal_v.tolist(), self.temperature_c.tolist()
        for index, supervisor in self._supervisors.items():
            supervisor(self._now, duty[index], current[index], supply[index], temperature[index])

    def _heat(self) -> None:
        """Warm the windings by what their resistance has taken since the last time."""
        elapsed, self._heated_at = (self._now - self._heated_at) * _SECONDS, self._now
        warmer = self._thermal_resistance * self._resistance * self.current**2
        self.temperature_c += (self._air_c + warmer - self.temperature_c) * np.minimum(
            self._thermal_rate * elapsed, 1.0)

    def _run_loops(self, elapsed: float) -> None:
        """Set the duties by the full law; `step` has a short cut for proportional control alone."""
        goals = self._goals
        goals.advance(self._now)
        p, i, d, feed_speed, feed_acceleration, margin, punch = self._gains
        speed_error = goals.speed - self._velocity * self._ticks_per_radian
        error = np.where(self._velocity_loop, speed_error, goals.position - self._ticks)
        error = np.copysign(np.maximum(np.abs(error) - margin, 0.0), error)
        self._sum += i * error * elapsed
        np.clip(self._sum, -self._limit, self._limit, out=self._sum)  # against wind-up
        self.duty[:] = (
            p * error + self._sum + d * speed_error + feed_speed * goals.speed
            + feed_acceleration * goals.acceleration + punch * np.sign(error) + self._open_loop)

    def _limit_currents(self) -> None:
        back_emf, supply = self._torque_constant * self._rotor_speed, np.maximum(self.terminal_v, _DEAD_SUPPLY)
        lowest, highest = (back_emf + self._drops) / supply
        np.clip(self.duty, lowest, highest, out=self.duty)

    def _run_motors(self) -> None:
        np.multiply(self.terminal_v, self.duty, out=self._voltage)
        np.multiply(self._torque_constant, self._rotor_speed, out=self.current)
        np.subtract(self._voltage, self.current, out=self.current)
        self.current *= self._conductance
        np.multiply(self._torque_constant, self.current, out=self.torque)
        np.multiply(self._voltage, self.current, out=self._power)
        np.maximum(self._power, 0.0, out=self._power)

    def load(self, index: int, drive: Drive, scales: Scales) -> None:
        """Take a servo's settings. With torque off, its goal is where the shaft is."""
        gains = drive.gains if drive.on else Gains()
        self._limit[index] = drive.largest_duty if drive.on else 0.0
        self._open_loop[index] = drive.duty
        self._gains[:, index] = gains
        self._velocity_loop[index] = drive.velocity_loop
        self._conductance[index] = drive.on / self._resistance[index]
        self._drops[:, index] = drive.currents
        self._drops[:, index] *= self._resistance[index]
        if drive.on and math.isfinite(drive.currents[1]):
            self._current_limited.add(index)
        else:
            self._current_limited.discard(index)
        if gains.integral == 0.0:
            self._sum[index] = 0.0
        if not drive.on:
            self._goals.jump(index, self.ticks(index))
        if drive.on and (drive.duty != 0.0 or drive.velocity_loop or any(gains[1:])):
            self._regulated.add(index)
        else:
            self._regulated.discard(index)
        self._load_scales(index, scales)

    def _load_scales(self, index: int, scales: Scales) -> None:
        sign, speed = scales.sign, scales.sign * scales.speed
        self._scale[:, index] = (
            sign * scales.duty, sign * scales.load, speed * self._ticks_per_radian[index], sign, speed, sign,
            sign * scales.current, scales.supply, 1.0)
        self._offset[(3, 5), index] = scales.zero
        self._moving_above[index] = scales.moving_above
        self._present = None

    def ticks(self, index: int) -> float:
        """Return where a shaft is."""
        return float(self._ticks[index])

    def trajectory(self, index: int) -> tuple[float, float]:
        """Return where a servo's profile is by now, or its goal, and how fast it moves, ticks/s."""
        return float(self._goals.position[index]), float(self._goals.speed[index])

    def jump(self, index: int, position: float, speed: float = 0.0) -> None:
        """Give a servo a goal at once, in ticks (and ticks/s for a velocity loop)."""
        self._present = None
        self._goals.jump(index, position, speed)

    def follow(self, index: int, profile: Profile) -> None:
        """Lead a servo along a profile, from now on."""
        self._present = None
        self._goals.follow(index, profile, self._now)

    def rest(self, index: int) -> None:
        """Make a servo's goal the place where its shaft is, and forget past errors."""
        self._sum[index] = 0.0
        self.jump(index, self.ticks(index))

    def present(self) -> list[list[int]]:
        """Return what each servo reports: the fields of `Present`."""
        if self._present is None:
            self._present = self._read_sensors()
        return self._present

    def _read_sensors(self) -> list[list[int]]:
        goals, rows = self._goals, self._rows
        counts = rows[-_SCALED:]
        for row, value in zip(counts, (
            self.duty, self.duty, self._velocity, self._ticks, goals.speed, goals.position, self.current,
            self.terminal_v, self.temperature_c), strict=True,
        ):
            row[:] = value
        counts *= self._scale
        counts += self._offset
        np.rint(counts, out=counts)
        rows[0] = goals.ongoing | (np.abs(counts[2]) > self._moving_above)
        rows[1] = ~goals.ongoing & (np.abs(goals.position - self._ticks) <= _IN_POSITION_TICKS)
        rows[2] = goals.ongoing
        rows[3] = goals.kind
        present: list[list[int]] = rows.T.astype(np.int64).tolist()
        return present
