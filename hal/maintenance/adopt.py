"""A new servo put into the place of one that is gone."""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from hal.maintenance.address import baud_value
from hal.maintenance.backup import Backup
from hal.maintenance.identity import Identity
from hal.maintenance.place import Place, is_vacant
from hal.maintenance.servo import Change, Servo
from hal.register_map import Access, ServoModel
from robotwalk.errors import BusError, ServoError, UsageError

_OFFSETS = ("homing_offset", "position_offset")  # of the old servo's horn, which the new one's is not
_ADDRESS = ("id", "baud_rate")


class Vacancy(NamedTuple):
    """A joint's place, and what a servo there must be."""

    joint: str
    place: Place
    model: ServoModel
    others: Collection[Place]  # of the robot's servos on the same line

    def newcomer(self, found: Sequence[Identity], servo_id: int | None) -> Identity:
        """Return the one servo that is none of the robot's; or the one that has an id, if that is known.

        Raises:
            BusError: there is none.
            ServoError: there are several, or it is of another model.
        """
        known = {self.place, *self.others}
        new = [one for one in found if one.id == servo_id or (servo_id is None and _place(one) not in known)]
        if not new and servo_id is not None:
            raise BusError(f"no servo answers as id {servo_id}")
        if not new:
            raise BusError(
                "no servo answers but the robot's, by id and baud rate. If the new one has the id of a joint, "
                "connect it alone and say --id")
        if len(new) > 1:
            those = ", ".join(f"{_place(one)} ({one.name})" for one in new)
            raise ServoError(f"which is the new one? {those}: connect one of them, or say --id and --baud")
        if not new[0].may_be(self.model):
            raise ServoError(f"{_place(new[0])} is a servo of another model, {new[0].name}; {self.joint} needs an "
                             f"{self.model.name}")
        return new[0]

    def settings(self, old: Backup | None) -> Mapping[str, int]:
        """Return what the EEPROM must hold: what the old servo's did, no return delay, and what walking needs.

        Raises:
            UsageError: the backup is of another model.
        """
        wanted: dict[str, int] = {}
        if old is not None:
            if old.model_number != self.model.model_number:
                raise UsageError(f"the backup is of an {old.model}; {self.joint} needs an {self.model.name}")
            rows = (self.model[name] for name in old.registers if name not in (*_ADDRESS, *_OFFSETS))
            wanted = {row.name: old.registers[row.name] for row in rows if row.access is Access.READ_WRITE}
        return {**wanted, "return_delay_time": 0, **self.model.arming.require}

    def fill(self, servo: Servo, settings: Mapping[str, int]) -> list[Change]:
        """Set a servo up and bring it to the place; return what was changed. Everything is read back.

        Raises:
            BusError: it does not answer.
            ServoError: its torque is on, its place or the way there is taken, or it does not take a value.
        """
        servo.require_limp()
        servo.require_alone()
        if servo.place != self.place and not is_vacant(servo.dialogue, self.place):
            raise ServoError(f"{self.place} is taken: the servo that {self.joint} has, or another, still answers")
        wanted = {**settings, "id": self.place.id, "baud_rate": baud_value(servo, self.place.baud)}
        changes: list[Change] = []
        for name, value in wanted.items():
            try:
                changes.append(servo.write(name, value))
            except (BusError, ServoError) as error:
                done = ", ".join(change.register.name for change in changes if change.changed) or "nothing"
                raise type(error)(f"{error}. Changed before that: {done}") from error
        return [change for change in changes if change.changed]


def _place(identity: Identity) -> Place:
    return Place(identity.baud, identity.id)
