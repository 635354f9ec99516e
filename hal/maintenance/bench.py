"""The bench: one serial line, and what is done with single servos on it. Any brand."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from hal.encoding import pack
from hal.maintenance import factory_reset, scan
from hal.maintenance.backup import Backup, Restored, restore, take
from hal.maintenance.dialects import group
from hal.maintenance.dialogue import Heard
from hal.maintenance.identity import Identity, identify
from hal.maintenance.sdk_port import SdkPort
from hal.maintenance.servo import Servo, found
from hal.maintenance.vendor_sdk import Keep, VendorSdk
from hal.register_map import ServoModel
from hal.tunable_port import TunablePort
from robotwalk.errors import BusError, ServoError
from robotwalk.ports import Clock

_NS = 1_000_000_000
_FACTORY_BAUDS = (1_000_000, 57_600)  # of most servos that one meets, or of most robots: looked at first
_STARTING = 3 * _NS  # for a servo to come back from a reboot
_SHORT = 20_000_000  # ns of patience with a servo that may be starting
_RESTARTED_BY = _NS // 2  # a servo that was never silent until then has not restarted
_ATTEMPTS = 3  # at finding an id
_LATE = 50_000_000  # ns after which no answer to an earlier ping is to be expected
_GAP = 2_000_000  # ns behind a broadcast
_TORQUE = "torque_enable"


class Found(NamedTuple):
    """A servo that answered a ping."""

    identity: Identity
    round_trip: float  # s


class Bench:
    """A line that nobody else uses, with servos of one protocol or another.

    Attributes:
        clock: by which it waits.
    """

    def __init__(self, port: TunablePort, clock: Clock, models: Iterable[ServoModel]) -> None:
        """Take the models that may be there; their protocols are those that are tried."""
        self.clock = clock
        self._port = port
        self._models = tuple(models)
        self._dialects = group(port, clock, self._models)

    def bauds(self) -> list[int]:
        """Return every baud rate that a model has, the common ones first."""
        known = {baud for model in self._models for baud in model.baud_rates}
        return sorted(known, key=lambda baud: (baud not in _FACTORY_BAUDS, -baud))

    def tune(self, baud: int) -> None:
        """Set the baud rate. Raises BusError if the adapter does not have it."""
        self._port.baud = baud

    def scan(self) -> Iterator[scan.Finding]:
        """Look for servos at the baud rate of now, in each protocol that has it."""
        baud = self._port.baud
        for dialects in self._dialects:
            if any(baud in model.baud_rates for model in dialects.models):
                yield from scan.scan(dialects)

    def ping(self, servo_id: int) -> Found:
        """Find out who has an id.

        Raises:
            BusError: nobody, or more than one.
        """
        doubtful = Heard()
        for _ in range(_ATTEMPTS):  # a servo may lose the frame behind one of another brand
            for dialects in self._dialects:
                if not doubtful.silent:
                    dialects.any.listen(_LATE)  # it may have been the answer to another ping, late
                heard = dialects.any.ping(servo_id)
                if heard.alone(servo_id):
                    identity = identify(dialects, heard.statuses[0])
                    return Found(identity, heard.took / _NS)
                doubtful = doubtful if heard.silent else heard
        raise self._dialects[0].any.nobody(servo_id, doubtful)

    def servo(self, servo_id: int) -> Servo:
        """Return the servo that has an id.

        Raises:
            BusError: nobody has, more than one, or one of a model that is not known.
        """
        return self._servo(self.ping(servo_id).identity)

    def servos(self, ids: Sequence[int] = ()) -> list[Servo]:
        """Return the servos that have these ids, by default all on the line. Raises BusError as `servo` does."""
        if ids:
            return [self.servo(servo_id) for servo_id in dict.fromkeys(ids)]
        findings = list(self.scan())
        for finding in findings:
            if isinstance(finding, scan.Clash | scan.Noise):
                raise BusError(str(finding))
        everybody = [self._servo(finding) for finding in findings if isinstance(finding, Identity)]
        if not everybody:
            raise BusError(f"no servo answers at {self._port.baud} baud")
        return everybody

    def torque_off(self, ids: Sequence[int] = ()) -> list[Servo]:
        """Switch torque off, by default of all on the line, and check it; return the servos.

        Raises:
            BusError: a servo does not answer, or nobody does.
            ServoError: torque is still on.
        """
        if not ids:
            self._broadcast_torque_off()
        servos = self.servos(ids)
        for servo in servos:
            if servo.read(_TORQUE):
                servo.write(_TORQUE, 0)
        on = [str(servo) for servo in servos if servo.read(_TORQUE)]
        if on:
            raise ServoError(f"torque is still on: {', '.join(on)}")
        return servos

    def reboot(self, servo: Servo) -> float:
        """Restart a servo and wait until it answers again; return after how many seconds.

        Raises:
            BusError: it does not come back.
            ServoError: it refuses, or shows no sign of having restarted.
        """
        dialogue, protocol = servo.dialogue, servo.dialogue.protocol
        began = self.clock.now()
        status = dialogue.exchange(protocol.reboot(servo.id), _SHORT, until=(servo.id,)).of(servo.id)
        if status and status.error:
            raise ServoError(f"{servo} refuses to reboot: {protocol.describe_error(status.error)}")
        silent = False
        while self.clock.now() < began + _STARTING:
            if not dialogue.ping(servo.id, _SHORT).of(servo.id):
                silent = True
            elif silent:
                return (self.clock.now() - began) / _NS
            elif self.clock.now() > began + _RESTARTED_BY:
                raise ServoError(
                    f"{servo} answers as if nothing had been said: its firmware seems not to know the instruction. "
                    "Switch its power off and on")
        raise BusError(f"{servo} was told to reboot and does not answer again")

    def backup(self, servo: Servo, time: str) -> Backup:
        """Read a servo's EEPROM through its vendor's SDK. Raises as `hal.maintenance.backup.take` does."""
        return take(self._through_sdk(servo), time)

    def restore(self, servo: Servo, backup: Backup, *, with_id: bool) -> Restored:
        """Bring an EEPROM back through the vendor's SDK. Raises as `hal.maintenance.backup.restore` does."""
        return restore(self._through_sdk(servo), backup, with_id=with_id)

    def factory_reset(self, servo: Servo, keep: Keep) -> factory_reset.Reset:
        """Reset a servo through its vendor's SDK. Raises as `factory_reset.factory_reset` does."""
        return factory_reset.factory_reset(servo, self._sdk(servo), keep)

    def _through_sdk(self, servo: Servo) -> Servo:
        return servo.over(self._sdk(servo))

    def _sdk(self, servo: Servo) -> VendorSdk:
        from hal.maintenance.vendors import vendor_sdk

        return vendor_sdk(servo.model, SdkPort(self._port, self.clock))

    def _servo(self, identity: Identity) -> Servo:
        return found(identity, self._dialects)

    def _broadcast_torque_off(self) -> None:
        """Let everybody go at once. Twice: nobody acknowledges a broadcast."""
        for dialects in self._dialects * 2:
            for dialogue, row in dialects.torque_switches():
                protocol = dialogue.protocol
                dialogue.exchange(protocol.write(protocol.BROADCAST_ID, row.address, pack(row, 0)), _GAP)
