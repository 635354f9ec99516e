"""The firmware of a Feetech STS servo: its modes, its offset, its over-current protection.

Assumed where manuals say nothing:

- Step mode (3) counts from the goal before, and keeps to the position limits unless both are 0. Goal time does nothing
  in position mode. A goal velocity of 0 stops the motor in velocity mode, whatever the phase says. Acceleration 0 is
  no limit at all; `max_acceleration` bounds the others.
- Torque enable 128 leaves torque as it was.

Stored without effect: angular resolution, acceleration multiplier, velocity unit, DTs, Hts.
"""

from hal.register_map import StsFirmware
from sim_backend.feetech_firmware import FeetechServo, within
from sim_backend.feetech_motion import STEP, VELOCITY
from sim_backend.feetech_table import FeetechTable
from sim_backend.servo_physics import ServoPhysics
from sim_backend.sts_motion import MULTI_TURN_FEEDBACK, StsMotion

_DAMPING, _CENTRE_HERE = 2, 128  # of torque_enable
_LARGEST_OFFSET = 2047
_LARGEST_MAGNITUDE = (1 << 15) - 1  # beside the sign


class StsServo(FeetechServo):
    """A servo of the STS series."""

    _firmware: StsFirmware
    _motion: StsMotion
    _reports_sensor = True

    def __init__(self, physics: ServoPhysics, index: int, **factory_settings: int) -> None:
        """Make the servo of one entry of `physics`, new but for some registers of the EEPROM."""
        model = physics.models[index]
        if not isinstance(model.firmware, StsFirmware):
            raise ValueError(f"{model.name} is no STS servo")  # noqa: TRY004 (a wrong model, not a wrong type)
        motion = StsMotion(model, model.firmware, FeetechTable(model))
        super().__init__(physics, index, model.firmware, motion, factory_settings)
        self.knows_calibrate = model.firmware.calibrate

    def calibrate(self) -> None:
        """Choose the offset that makes the present position the centre."""
        self._centre_here()
        self._configure()
        self._move(steps=False)

    def _take(self, address: int, data: bytes) -> set[str]:
        table, torque = self.table, self.table["torque_enable"]
        taken = super()._take(address, data)
        if table["torque_enable"] == _CENTRE_HERE:
            table["torque_enable"] = torque
            self._centre_here()
        if "goal_position" in taken:
            self._hold(table["goal_position"])
        return taken

    def _centre_here(self) -> None:
        encoder = self.model.encoder
        actual = round(encoder.centre + self._physics.ticks(self._index)) % encoder.ticks
        register = self.model["position_offset"]
        self.table.assign(register, within(actual - encoder.centre, _LARGEST_OFFSET))
        if self._firmware.centre_outlives_lock:
            self.table.keep(register)

    def _hold(self, position: int) -> None:
        super()._hold(position)
        self.table["goal_position_echo"] = position

    def _shown(self, position: int) -> int:
        if not self.table["phase"] & MULTI_TURN_FEEDBACK:
            position %= self.model.encoder.ticks
        return within(position, _LARGEST_MAGNITUDE)

    def _show(self, present: list[int]) -> None:
        super()._show(present)
        self.table["present_current"] = within(present[-3], _LARGEST_MAGNITUDE)

    def _current_limit(self) -> tuple[float, int]:
        limit = self.table["protection_current"] * self.model["protection_current"].si_scale
        return limit, self._span_ns("over_current_time")

    def _brakes(self, torque: int) -> bool:
        return torque == _DAMPING and self._firmware.damping

    def _aim(self, steps: bool) -> None:
        if self._motion.mode != VELOCITY:
            super()._aim(steps)
            return
        start, speed = self._physics.trajectory(self._index)
        ramp = self._motion.ramp(start, speed)
        if ramp is None:
            self._physics.jump(self._index, start, self._motion.goal_speed())
        else:
            self._physics.follow(self._index, ramp)

    def _next_target(self, steps: bool) -> int:
        goal = super()._next_target(steps)
        if self._motion.mode != STEP:
            return goal
        return self._target + goal if steps else self._target

    def _fold(self) -> None:
        self._take_off_turns(1, self._motion.zero + self._turned)
        self._load()
