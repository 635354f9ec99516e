"""The firmware of a Dynamixel AX: what its registers do when they are written, and its protections.

Assumed where the e-Manual says nothing:

- Overload stays until the torque limit is written again; voltage and heat pass by themselves, but leave the torque
  limit at 0 if they are in the shutdown mask.
- A factory reset restarts the servo.
- Present speed is in 0.111 rpm in wheel mode too: the 0.1 % that the e-Manual names there is a share of something else.

Not modelled: the LED's blinking.
"""

from hal.register_map import AxFirmware, Memory
from sim_backend.ax_motion import AxMotion
from sim_backend.ax_table import AxTable, Refusal, RefusedError
from sim_backend.control_table import Window
from sim_backend.fake_servo import FakeServo
from sim_backend.servo_physics import ServoPhysics

VOLTAGE, OVERHEATING, OVERLOAD = 0x01, 0x04, 0x20  # bits of the error byte, of alarm_led and of shutdown

_GOALS = {"goal_position", "moving_speed"}
_LARGEST_MAGNITUDE = 1023  # beside the sign
_LARGEST_BYTE = 255
_NS = 1_000_000_000


class AxServo(FakeServo):
    """A Dynamixel of the AX series.

    Attributes:
        status_return_level: what it answers at all.
        conditions: the bits that are in the error byte of every answer.
        knows_reboot: whether its firmware has that instruction.
    """

    table: AxTable
    knows_bulk_read = False

    def __init__(self, physics: ServoPhysics, index: int, **factory_settings: int) -> None:
        """Make the servo of one entry of `physics`, new but for some registers of the EEPROM."""
        model = physics.models[index]
        if not isinstance(model.firmware, AxFirmware):
            raise ValueError(f"{model.name} is no AX servo")  # noqa: TRY004 (a wrong model, not a wrong type)
        super().__init__(physics, index, AxTable(model))
        self._firmware = model.firmware
        self._set_up({"firmware_version": self._firmware.version, **factory_settings})
        self.knows_reboot = self._firmware.reboot
        self._full = model.position_loop.pwm_full_scale  # counts of the torque limit
        self._motion = AxMotion(model, self._firmware, self.table)
        self._registered: tuple[int, bytes] | None = None
        self._window = Window(model, (
            "present_position", "present_speed", "present_load", "present_voltage", "present_temperature"))
        self._run()

    def read(self, address: int, length: int) -> bytes:
        """Return bytes of the control table.

        Raises:
            RefusedError: they are not there.
        """
        self._sense()
        return self.table.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write bytes to the control table, and act on them.

        Raises:
            RefusedError: nothing is written.
        """
        limp = not self._on
        if limp and self._firmware.goal_follows_present:
            self._sense()
        assignments = self.table.check(address, data)
        self.table.store(assignments)
        written = {register.name for register, _ in assignments}
        if "torque_limit" in written and self.table["torque_limit"]:
            self._recover()
        if not written <= _GOALS or self.table.wheel_mode:
            self._configure()
        if limp and self._on:
            self._physics.rest(self._index)
        if self._on and not self.table.wheel_mode:
            self._aim()

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`; it takes the place of an earlier one.

        Raises:
            RefusedError: the earlier one stays.
        """
        self.table.check(address, data)
        self._registered = address, data
        self.table["registered"] = 1

    def action(self) -> None:
        """Carry out the write that was kept.

        Raises:
            RefusedError: there is none, or it is refused by now.
        """
        if self._registered is None:
            raise RefusedError(Refusal.INSTRUCTION)
        address, data = self._registered
        self._registered = None
        self.table["registered"] = 0
        self.write(address, data)

    def factory_reset(self, now: int) -> None:
        """Go back to the factory's settings, id and baud rate among them, and start afresh."""
        self.table.restore_defaults(Memory.EEPROM)
        self.table["firmware_version"] = self._firmware.version
        self.reboot(now)

    def _reset(self) -> None:
        self.table.restore_defaults(Memory.RAM)
        self.table["torque_limit"] = self.table["max_torque"]
        self._registered = None
        self._sensed = None
        self.conditions = self._latched = 0
        self._configure()

    def _start(self, now: int) -> None:
        self._now = self._relaxed_at = now
        self._hold_here()

    def _show(self, present: list[int]) -> None:
        moving, _, _, _, _, load, speed, position, _, _, _, supply, temperature = present
        self._window.store(self.table, (
            self._motion.shown(position), _within(speed), _within(load),
            min(max(supply, 0), _LARGEST_BYTE), min(max(temperature, 0), _LARGEST_BYTE)))
        self.table["moving"] = moving
        if self._firmware.goal_follows_present and not self._on:
            self.table["goal_position"] = self.table["present_position"]

    def _configure(self) -> None:
        """Take over settings that are looked at often, and the motor's."""
        table = self.table
        self._configure_line()
        self.status_return_level = table["status_return_level"]
        self._on = bool(table["torque_enable"])
        self._temperature_limit = table["temperature_limit"]
        unit = self.model["present_voltage"].scale  # V; a limit is passed by half a count
        self._lowest_v = unit * (table["min_voltage_limit"] - 0.5)
        self._highest_v = unit * (table["max_voltage_limit"] + 0.5)
        self._overload_duty = self._firmware.overload_duty * table["torque_limit"] / self._full
        self._physics.load(self._index, self._motion.drive(self._on), self._motion.scales())

    def _aim(self) -> None:
        """Head for the goal position from where the last profile has got to."""
        physics, index = self._physics, self._index
        goal = self._motion.goal(physics.ticks(index))
        profile = self._motion.profile(physics.trajectory(index)[0], goal)
        if profile is None:
            physics.jump(index, goal)
        else:
            physics.follow(index, profile)

    def _hold_here(self) -> None:
        self._sense()
        self.table["goal_position"] = self.table["present_position"]

    def _recover(self) -> None:
        """Forget the overload that has taken the torque away."""
        self._latched = 0
        self._relaxed_at = self._now
        self.conditions &= ~OVERLOAD

    def _supervise(self, now: int, duty: float, current: float, supply_v: float, temperature_c: float) -> None:
        if not self._is_awake(now):
            return
        self._now = now
        table = self.table
        if not self._overload_duty or abs(duty) < self._overload_duty:
            self._relaxed_at = now
        overloaded = now - self._relaxed_at >= self._firmware.overload_s * _NS
        hot = temperature_c > self._temperature_limit
        starved = not self._lowest_v <= supply_v <= self._highest_v
        self._latched |= overloaded * OVERLOAD & table["shutdown"]
        self.conditions = self._latched | overloaded * OVERLOAD | hot * OVERHEATING | starved * VOLTAGE
        if self.conditions & table["shutdown"] and table["torque_limit"]:
            table["torque_limit"] = 0
            self._configure()


def _within(value: int) -> int:
    return min(max(value, -_LARGEST_MAGNITUDE), _LARGEST_MAGNITUDE)
