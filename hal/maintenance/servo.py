"""One servo on the bench: its registers by name, read, written and checked."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, Protocol

from hal.encoding import pack, unpack
from hal.maintenance import quantity
from hal.maintenance.dialects import Dialects
from hal.maintenance.dialogue import Dialogue, NoAnswerError
from hal.maintenance.identity import Identity
from hal.maintenance.place import Place, is_vacant, settle_at
from hal.register_map import Block, Memory, Register, ServoModel
from robotwalk.errors import BusError, ServoError

_LARGEST_READ = 64  # bytes; well within what any servo sends at once
_ADDRESS = ("id", "baud_rate")  # where the servo is to be found from then on
_LISTENINGS = 6  # for another servo with the same id


class Change(NamedTuple):
    """What a write did."""

    register: Register
    before: int | None  # counts; None: not looked at
    after: int  # as read back

    @property
    def changed(self) -> bool:
        """Whether anything was written."""
        return self.before != self.after


class Transport(Protocol):
    """What carries reads and writes: our own frames, or a vendor's SDK."""

    def read(self, servo_id: int, address: int, size: int) -> bytes:
        """Return bytes of a servo's table. Raises BusError if it is silent, ServoError if it refuses."""
        ...

    def write(self, servo_id: int, address: int, data: bytes) -> None:
        """Write bytes to a servo's table. Raises ServoError if it refuses; its silence is no error."""
        ...


class Servo:
    """A servo of a known model.

    Attributes:
        identity: what it said of itself when it was found.
        id: what it answers to now.
    """

    def __init__(
        self, dialogue: Dialogue, identity: Identity, model: ServoModel, transport: Transport | None = None
    ) -> None:
        """Reach it by our own frames, or by another transport."""
        self.dialogue = dialogue
        self.identity = identity
        self.model = model
        self.id = identity.id
        self._transport = transport or dialogue

    def over(self, transport: Transport) -> "Servo":
        """Return the same servo, reached by another transport."""
        return Servo(self.dialogue, self.identity, self.model, transport)

    def __str__(self) -> str:
        return f"id {self.id} ({self.identity.name})"

    @property
    def place(self) -> Place:
        """Where it is to be found now."""
        return Place(self.dialogue.port.baud, self.id)

    def require_limp(self) -> None:
        """Check that torque is off. Raises ServoError if it is on, BusError if nobody answers."""
        if self.read("torque_enable"):
            raise ServoError(
                f"{self} has its torque on: switch it off first, with `robotwalk servo torque-off {self.id}`; "
                "the joint goes limp")

    def require_alone(self) -> None:
        """Check that no other servo has this id, as far as that can be heard.

        Two of a kind that say the same at the same instant sound like one; so it is asked what it measures, again
        and again. Raises BusError if anything but one good answer comes.
        """
        block = self.model.feedback
        question = self.dialogue.protocol.read(self.id, block.address, block.size)
        for _ in range(_LISTENINGS):
            heard = self.dialogue.ask(question, self.id, block.size)
            if not heard.alone(self.id) and not heard.silent:
                raise self.dialogue.nobody(self.id, heard)

    def read(self, name: str) -> int:
        """Return a register's counts.

        Raises:
            BusError: the servo does not answer.
            ServoError: it refuses.
        """
        register = self.model[name]
        return unpack(register, self._transport.read(self.id, register.address, register.size))

    def read_all(self, registers: Sequence[Register]) -> dict[str, int | None]:
        """Return the counts of many registers, in as few reads as it takes; None where the servo has none.

        Raises:
            BusError: the servo does not answer.
        """
        values: dict[str, int | None] = {}
        for block in _blocks(registers):
            try:
                data = self._transport.read(self.id, block.address, block.size)
            except ServoError:
                # One of them is absent from this firmware: find out which.
                values |= {register.name: self._read_if_there(register) for register in block.registers}
                continue
            for register in block.registers:
                at = register.address - block.address
                values[register.name] = unpack(register, data[at : at + register.size])
        return {register.name: values[register.name] for register in registers}

    def write(self, name: str, value: int) -> Change:
        """Write a register, in counts, and read it back. What the EEPROM already holds is not written again.

        Raises:
            UsageError: the register does not take it.
            BusError: the servo does not answer.
            ServoError: it refuses, does not keep the value, or another servo is where it would go.
        """
        register = self.model[name]
        quantity.check(register, value)
        if register.memory is Memory.RAM:
            self._put(register, value)
            return Change(register, None, self.read(name))
        before = self.read(name)
        if before == value:
            return Change(register, before, before)
        if name in _ADDRESS:
            return Change(register, before, self._move(register, value))
        with self._unlocked():
            self._put(register, value)
            after = self._read_back(name, value)
        return Change(register, before, after)

    def faults(self) -> list[str]:
        """Return the hardware errors that it reports, in words."""
        name = self.model.cyclic.telemetry.error
        return quantity.flags(self.model[name], self.read(name)) if name is not None else []

    @contextmanager
    def _unlocked(self) -> Iterator[None]:
        """Let the EEPROM keep what is written, and then no more."""
        lock = self.model.lock
        if lock is None:
            yield
            return
        self._put(lock, 0)
        try:
            yield
        finally:
            self._put(lock, 1)

    def _put(self, register: Register, value: int) -> None:
        """Write a register, and follow the servo to its new id or baud rate."""
        try:
            self._transport.write(self.id, register.address, pack(register, value))
        except ServoError as error:
            raise self._explained(error, register) from None
        if register.name == "id":
            self.id = value
        if register.name == "baud_rate":
            self.dialogue.port.baud = self.model.baud_by_value[value]

    def _move(self, register: Register, value: int) -> int:
        """Change the id or the baud rate; return what is read back there. Whatever goes wrong, find the servo again."""
        old = self.place
        new = old._replace(id=value) if register.name == "id" else old._replace(baud=self.model.baud_by_value[value])
        if not is_vacant(self.dialogue, new):
            where = f"id {new.id}" if new.baud == old.baud else str(new)
            raise ServoError(f"{where} is taken: another servo on this line answers to it")
        try:
            with self._unlocked():
                self._put(register, value)
                return self._read_back(register.name, value)
        except NoAnswerError:
            return self._find_again(register, value, old, new)

    def _find_again(self, register: Register, value: int, old: Place, new: Place) -> int:
        """Look where the servo may be after a change that it did not confirm."""
        found = settle_at(self.dialogue, new, old)
        if found is None:
            self.dialogue.port.baud, self.id = old
            raise BusError(
                f"{self} answers neither as {new} nor as {old} any more; `robotwalk servo scan` looks everywhere")
        self.id = found.id
        if self.model.lock is not None:
            self._put(self.model.lock, 1)
        return self._read_back(register.name, value)

    def _read_back(self, name: str, value: int) -> int:
        after = self.read(name)
        if after != value:
            register = self.model[name]
            raise ServoError(
                f"{self} did not take {name} = {quantity.text(register, value)}: it reads back as "
                f"{quantity.text(register, after)}")
        return after

    def _explained(self, error: ServoError, register: Register) -> ServoError:
        """Add the likeliest reason for a refusal."""
        if register.memory is Memory.EEPROM and self.read("torque_enable"):
            return ServoError(
                f"{error}. {register.name} is in the EEPROM and torque is on: switch it off first, with "
                f"`robotwalk servo torque-off {self.id}`; the joint goes limp")
        return ServoError(f"{error} ({register.name})")

    def _read_if_there(self, register: Register) -> int | None:
        try:
            return self.read(register.name)
        except ServoError:
            return None


def found(identity: Identity, known: Sequence[Dialects]) -> Servo:
    """Return a servo whose model is known. Raises BusError if it is not."""
    [dialects] = [one for one in known if identity.protocol in (one.name, *one.dialogues)]
    models = dialects.models
    if identity.model is None:
        names = ", ".join(f"{model.name} ({model.model_number})" for model in models)
        what = "does not answer reads" if identity.model_number is None else f"is of model {identity.model_number}"
        raise BusError(f"id {identity.id} {what}, which no servo file describes; there are {names}")
    return Servo(dialects.of(identity.model), identity, identity.model)


def _blocks(registers: Sequence[Register]) -> Iterator[Block]:
    """Group registers that lie side by side."""
    run: list[Register] = []
    for register in sorted(registers, key=lambda row: row.address):
        if run and (run[-1].end != register.address or register.end - run[0].address > _LARGEST_READ):
            yield Block(tuple(run))
            run = []
        run.append(register)
    if run:
        yield Block(tuple(run))
