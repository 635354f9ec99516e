"""Protocols that sound alike: whoever answers a ping may speak any of them, until a read tells."""

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from hal.maintenance.dialogue import Dialogue
from hal.protocols import protocol_of
from hal.register_map import Access, Register, ServoModel
from hal.tunable_port import TunablePort
from robotwalk.ports import Clock

_TORQUE = "torque_enable"
_ANY_ID = 0


class Dialects(NamedTuple):
    """Protocols with the same frames, as Dynamixel's 1.0 and Feetech's, and the models that speak them."""

    dialogues: Mapping[str, Dialogue]  # by protocol
    models: tuple[ServoModel, ...]

    @property
    def name(self) -> str:
        """All the protocols' names."""
        return "/".join(self.dialogues)

    @property
    def any(self) -> Dialogue:
        """A dialogue for pings, which are the same in all."""
        return next(iter(self.dialogues.values()))

    def of(self, model: ServoModel) -> Dialogue:
        """Return the dialogue in a model's protocol."""
        return self.dialogues[model.protocol]

    def torque_switches(self) -> Iterator[tuple[Dialogue, Register]]:
        """Yield the registers that switch torque, but for those where another of the models has something else.

        An AX has its switch where an STS has a setting of its EEPROM: everybody must not be told to write there.
        """
        for dialogue, row in dict.fromkeys((self.of(model), model[_TORQUE]) for model in self.models):
            if not any(_differs(row, other) for model in self.models for other in model.registers):
                yield dialogue, row


def group(port: TunablePort, clock: Clock, models: Iterable[ServoModel]) -> list[Dialects]:
    """Return the models by how they sound on the wire; those first that one ping finds all at once."""
    alike: dict[bytes, list[ServoModel]] = {}
    for model in models:
        alike.setdefault(protocol_of(model).ping(_ANY_ID), []).append(model)
    groups = sorted(alike.values(), key=lambda some: protocol_of(some[0]).PING_SLOT_NS is None)
    return [
        Dialects({model.protocol: Dialogue(port, clock, protocol_of(model)) for model in some}, tuple(some))
        for some in groups]


def _differs(row: Register, other: Register) -> bool:
    """Tell whether a write to `row` would change `other`, and that is no such switch."""
    overlaps = row.address < other.end and other.address < row.end
    return overlaps and other.access is Access.READ_WRITE and other.name != _TORQUE
