"""The firmware of a Feetech servo, as far as both series agree: what its registers do, and its protections.

Assumed where manuals say nothing:

- Voltage and heat release the motor when they pass, over-current as overload does.
- A change of mode, offset or turns with torque on starts afresh from where the shaft is.

Stored without effect: LED alarm, minimum start force, dead zones, phase bits of directions and hardware.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping

from hal.register_map import FeetechFirmware
from sim_backend.control_table import Window
from sim_backend.fake_servo import FakeServo
from sim_backend.feetech_motion import PWM, FeetechMotion
from sim_backend.feetech_table import FeetechTable
from sim_backend.servo_physics import Drive, ServoPhysics

# Bits of the status.
VOLTAGE, SENSOR, OVERHEATING, OVER_CURRENT, TORQUE_IS_ON, OVERLOAD = 0x01, 0x02, 0x04, 0x08, 0x10, 0x20
ON = 1  # of torque_enable

_GOALS = {"acceleration", "goal_position", "goal_pwm", "goal_time", "goal_velocity"}
_PERCENT = 100.0
_LARGEST_MAGNITUDE = (1 << 15) - 1  # beside the sign
_LARGEST_BYTE = 255
_NS = 1_000_000_000


class FeetechServo(FakeServo):
    """A servo of either series.

    Attributes:
        answers_writes: whether it answers more than pings and reads.
        error: the error byte of its answers.
        knows_sync_read: whether it takes part in one.
        knows_broadcast_ping: whether it answers a ping to everybody.
        knows_reboot: whether its firmware has that instruction.
        knows_calibrate: whether its firmware has that one.
    """

    table: FeetechTable
    knows_calibrate = False
    _reports_sensor = False

    def __init__(
        self, physics: ServoPhysics, index: int, firmware: FeetechFirmware, motion: FeetechMotion,
        factory_settings: Mapping[str, int],
    ) -> None:
        super().__init__(physics, index, motion.table)
        self._firmware, self._motion = firmware, motion
        self.table["lock"] = 0  # the factory's hand is not locked out
        self._set_up(factory_settings)
        self.knows_sync_read, self.knows_broadcast_ping = self.model.sync_read, firmware.broadcast_ping
        self.knows_reboot = firmware.reboot
        self._window = Window(self.model, (
            "present_position", "present_velocity", "present_load", "present_input_voltage", "present_temperature"))
        self._registered: tuple[int, bytes] | None = None
        self._target = 0  # counts, of position and step mode
        self._started_in: tuple[int, ...] = ()
        self._run()

    def read(self, address: int, length: int) -> bytes:
        """Return bytes of the control table."""
        self._sense()
        return self.table.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write bytes to the control table, and act on the registers that took them."""
        table, torque = self.table, self.table["torque_enable"]
        taken = self._take(address, data)
        if table["torque_enable"] != torque or (self._latched and self._leads_away(taken)):
            self._clear_protection()
        elif not taken <= _GOALS or self._motion.mode == PWM:
            self._configure()
        if taken:
            self._move(steps="goal_position" in taken)

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`; it takes the place of an earlier one."""
        self._registered = address, data
        self.table["registered_instruction"] = 1

    def action(self) -> None:
        """Carry out the write that was kept, if there is one."""
        if self._registered is not None:
            address, data = self._registered
            self._registered = None
            self.table["registered_instruction"] = 0
            self.write(address, data)

    def eeprom_ns(self, stores_before: int) -> int:
        """Return how long the EEPROM has been busy, if its table's count of stores was that before."""
        return round((self.table.stores > stores_before) * self._firmware.eeprom_write_ms * 1e6)

    def recover(self, now: int) -> None:
        """Go back to the factory's settings, and start afresh."""
        self.table.recover(keeping_id=self._firmware.recovery_keeps_id)
        self.reboot(now)

    def clear_turns(self) -> None:
        """Forget whole turns: bring the position to within one."""
        self._fold()
        self._restart()

    def calibrate(self) -> None:
        """Make the present position the centre, where there is an offset to do it with."""

    def _take(self, address: int, data: bytes) -> set[str]:
        """Write bytes; return the names of the registers that took them."""
        return self.table.write(address, data)

    @abstractmethod
    def _fold(self) -> None:
        """Bring the position to within one turn, and hand it over."""

    @abstractmethod
    def _shown(self, position: int) -> int:
        """Return a position as it is reported."""

    def _reset(self) -> None:
        self.table.restore()
        self.table[self.model.cyclic.torque_cap] = self.table["max_torque_limit"]
        self._registered = None
        self._status = self._latched = 0  # protections: as reported, and those that stay
        self._strain = 0.0  # duty at which the motor was overloaded
        self._configure()

    def _start(self, now: int) -> None:
        self._relaxed_at = self._current_fine_at = now
        self._fold()
        if self._firmware.torque_at_power_up:
            self._sense()
            self._hold(self.table["present_position"])
            self.table["torque_enable"] = ON
        self._configure()
        self._move(steps=False)

    def _hold(self, position: int) -> None:
        """Make a position the goal."""
        self.table["goal_position"] = position

    def _show(self, present: list[int]) -> None:
        moving, _, _, _, _, load, speed, position, _, _, _, supply, temperature = present
        self._window.store(self.table, (
            self._shown(position), within(speed, _LARGEST_MAGNITUDE), load,
            max(0, within(supply, _LARGEST_BYTE)), max(0, within(temperature, _LARGEST_BYTE))))
        self.table["moving"] = moving

    def _configure(self) -> None:
        """Take over settings that are looked at often, and the motor's."""
        table = self.table
        self._configure_line()
        self.answers_writes = bool(table["status_return_level"])
        self._temperature_limit = table["max_temperature_limit"]
        unit = self.model["present_input_voltage"].scale  # V; a limit is passed by half a count
        self._lowest_v = unit * (table["min_voltage_limit"] - 0.5)
        self._highest_v = unit * (table["max_voltage_limit"] + 0.5)
        self._overload_duty = table["overload_torque"] / _PERCENT
        self._overload_ns = self._span_ns("protection_time")
        self._largest_current, self._over_current_ns = self._current_limit()
        self._load()

    def _current_limit(self) -> tuple[float, int]:
        """Return the current (A) that may flow for a time (ns)."""
        return math.inf, 0

    def _span_ns(self, name: str) -> int:
        return round(self.table[name] * self.model[name].si_scale * _NS)

    def _load(self) -> None:
        """Hand the motor's settings over."""
        table, cap = self.table, self.model.cyclic.torque_cap
        torque, unloading = table["torque_enable"], self._status & table["unloading_condition"]
        released = bool(unloading & ~OVERLOAD)
        self._on = torque == ON and not released
        largest = table[cap] * self.model[cap].si_scale
        if unloading & OVERLOAD:
            largest = min(largest, table["protective_torque"] / _PERCENT)
        self._motion.configure(self._turned)
        drive = self._motion.drive(self._on, min(largest, self._firmware.largest_duty))
        if not released and self._brakes(torque):
            drive = Drive(on=True)  # the bridge shorts the motor
        self._physics.load(self._index, drive, self._motion.scales())
        self.error = self._status
        if self._firmware.torque_flag_in_status and torque == ON:
            self.error |= TORQUE_IS_ON
        table["hardware_error_status"] = self.error

    def _brakes(self, torque: int) -> bool:
        """Whether a value of `torque_enable` brakes the motor."""
        return False

    def _move(self, *, steps: bool) -> None:
        """Head for the goal; `steps` tells whether it is new, which counts in step mode."""
        if self._started_in != self._circumstances():
            self._restart()
        if self._on and self._motion.mode != PWM:
            self._aim(steps)

    def _circumstances(self) -> tuple[int, ...]:
        return self._on, self._motion.mode, self._motion.offset, self._motion.many_turns

    def _restart(self) -> None:
        """Start from rest where the shaft is, as when torque comes on."""
        if not self._motion.many_turns:
            self._fold()
        self._physics.rest(self._index)
        self._configure()
        self._target = round(self._physics.ticks(self._index) + self._motion.zero)
        self._started_in = self._circumstances()

    def _aim(self, steps: bool) -> None:
        """Lead the motor to the goal position."""
        start, speed = self._physics.trajectory(self._index)
        self._target = self._motion.bounded(self._next_target(steps))
        profile = self._motion.profile(start, speed, self._target)
        if profile is None:
            self._physics.jump(self._index, start)
        else:
            self._physics.follow(self._index, profile)

    def _next_target(self, steps: bool) -> int:
        return self.table["goal_position"]

    def _leads_away(self, taken: set[str]) -> bool:
        """Whether a goal leads away from what overloaded the motor."""
        if not self._firmware.overload_clears_on_new_goal or not taken & _GOALS:
            return False
        return self._motion.direction(self._physics.ticks(self._index)) * self._strain < 0.0

    def _clear_protection(self) -> None:
        self._status &= ~self._latched
        self._latched = 0
        self._configure()

    def _supervise(self, now: int, duty: float, current: float, supply_v: float, temperature_c: float) -> None:
        if not self._is_awake(now):
            return
        strained = abs(duty) > self._overload_duty
        if not strained:
            self._relaxed_at = now
        flooded = abs(current) > self._largest_current
        if not flooded:
            self._current_fine_at = now
        overloaded = strained and now - self._relaxed_at >= self._overload_ns
        over_current = flooded and now - self._current_fine_at >= self._over_current_ns
        lasting = overloaded * OVERLOAD | over_current * OVER_CURRENT
        if lasting:
            self._strain = duty
            self._latched |= lasting & self.table["unloading_condition"]
        hot = temperature_c > self._temperature_limit
        starved = not self._lowest_v <= supply_v <= self._highest_v
        blind = self.encoder_fails and self._reports_sensor
        status = lasting | self._latched | hot * OVERHEATING | starved * VOLTAGE | blind * SENSOR
        if status != self._status:
            self._status = status
            self._configure()
            self._move(steps=False)


def within(value: int, largest: int) -> int:
    """Return a value held between two ends of equal size."""
    return min(max(value, -largest), largest)
