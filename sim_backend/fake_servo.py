"""What the firmware of every brand of servo does: it listens, moves its motor, starts again."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping

from hal.register_map import Memory
from sim_backend.control_table import ControlTable
from sim_backend.reply import Reply, misheard
from sim_backend.servo_physics import ServoPhysics

_NS = 1_000_000_000
_BITS_PER_BYTE = 10  # 8N1

Interference = Callable[[Reply], Reply | None]


class FakeServo(ABC):
    """One servo of `physics`. It runs from the moment it is made.

    Attributes:
        table: its registers.
        id: what it answers to.
        return_delay_ns: from the end of an instruction to the answer.
        later_ids_answer: whether it answers a sync read behind a silent servo.
        encoder_fails: whether its position sensor does; may be set. What it measures stays right here.
        interferences: what happens to its answers on their way to the wire, one after the other; None drops one.
    """

    def __init__(self, physics: ServoPhysics, index: int, table: ControlTable) -> None:
        self.model = physics.models[index]
        self.later_ids_answer = self.model.firmware.later_ids_answer
        self.encoder_fails = False
        self.interferences: list[Interference] = []
        self.table = table
        self._physics, self._index = physics, index
        self._delay_unit_ns = round(self.model["return_delay_time"].scale * 1e3)  # from us
        self._turnaround_ns = round(self.model.firmware.turnaround_us * 1e3)
        self._turned = 0  # ticks, whole turns taken off the position
        self._sensed: list[int] | None = None
        self._wakes_at: float = 0  # ns
        self._awake = False

    def _set_up(self, settings: Mapping[str, int]) -> None:
        """Give some registers of the EEPROM other values than the factory's."""
        for name, value in settings.items():
            if self.model[name].memory is not Memory.EEPROM:
                raise ValueError(f"{name} is not kept without power")
            self.table.assign(self.model[name], value)

    def _run(self) -> None:
        """Come to power for the first time."""
        self._reset()
        self._physics.attach(self._index, self._supervise)
        self._awake = True
        self._start(0)

    @abstractmethod
    def _reset(self) -> None:
        """Bring the registers to what they are at power-up, and let go of the shaft."""

    @abstractmethod
    def _configure(self) -> None:
        """Take over settings that are looked at often."""

    @abstractmethod
    def _start(self, now: int) -> None:
        """Begin to work."""

    @abstractmethod
    def _supervise(self, now: int, duty: float, current: float, supply_v: float, temperature_c: float) -> None:
        """Look after the protections."""

    @abstractmethod
    def _show(self, present: list[int]) -> None:
        """Bring the fields of `servo_physics.Present` into the table."""

    def hear(self, now: int) -> None:  # noqa: B027 (of use to those with a watchdog alone)
        """Note that an instruction, to whomever, came over the bus."""

    def listens(self, now: int, baud: int) -> bool:
        """Whether bytes at `baud` reach the firmware at `now` ns."""
        return baud == self._baud and self._is_awake(now)

    def answer(self, delay_ns: int, frame: Callable[[int], bytes], servo_id: int, byte_ns: int) -> Reply | None:
        """Return what goes onto the wire after an instruction to `servo_id` at a baud rate; `frame` is told the id.

        If the instruction has changed the id or the baud rate, it is the model's `answers_at_new_setting` that counts.
        """
        if not self.model.firmware.answers_at_new_setting:
            return self.utter(Reply(delay_ns, frame(servo_id)))
        reply = self.utter(Reply(delay_ns, frame(self.id)))
        return reply and misheard(reply, _BITS_PER_BYTE * _NS // self._baud, byte_ns)

    def utter(self, reply: Reply) -> Reply | None:
        """Return what of an answer goes onto the wire."""
        said: Reply | None = reply
        for interfere in self.interferences:
            if said is not None:
                said = interfere(said)
        return said

    def reboot(self, now: int) -> None:
        """Start afresh, as at power-up: limp and deaf at once, back after a while."""
        self.lose_power(now, 0.0)

    def lose_power(self, now: int, seconds: float) -> None:
        """Be without power for so long, then start: limp and deaf at once, back after both."""
        self._reset()
        self._awake = False
        self._wakes_at = now + (seconds + self.model.firmware.reboot_s) * _NS

    def answer_to(self, servo_id: int) -> None:
        """Have another id from now on."""
        self.table.assign(self.model["id"], servo_id)
        self._configure()

    def run_firmware(self, version: int) -> None:
        """Have another version of the firmware; of a version in two parts, another first part."""
        name = next(register.name for register in self.model.registers if register.name.startswith("firmware_"))
        self.table.assign(self.model[name], version)
        self._configure()

    def _is_awake(self, now: int) -> bool:
        if not self._awake and now >= self._wakes_at:
            self._awake = True
            self._start(now)
        return self._awake

    def _configure_line(self) -> None:
        """Take over the settings of the bus."""
        self.id = self.table["id"]
        self.return_delay_ns = self._turnaround_ns + self.table["return_delay_time"] * self._delay_unit_ns
        self._baud = self.model.baud_by_value[self.table["baud_rate"]]

    def _sense(self) -> None:
        """Bring the present values into the table, if there are newer ones."""
        sensed = self._physics.present()[self._index]
        if sensed is not self._sensed:
            self._sensed = sensed
            self._show(sensed)

    def _take_off_turns(self, sign: int, zero: int) -> None:
        """Bring the count `sign x ticks + zero` to within one turn, which is all that the encoder tells."""
        turn = self.model.encoder.ticks
        self._turned = math.floor((zero + sign * self._physics.ticks(self._index)) / turn) * turn
