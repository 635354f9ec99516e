"""Another id or baud rate for a servo, and no two servos in one place."""

from hal.maintenance import quantity
from hal.maintenance.servo import Change, Servo
from robotwalk.errors import UsageError


def set_id(servo: Servo, new: int) -> Change:
    """Give a servo another id and read it back there.

    Raises:
        UsageError: its model has no such id.
        BusError: it does not answer, or another servo answers with it.
        ServoError: its torque is on, the new id is taken, or the servo does not take it.
    """
    quantity.check(servo.model["id"], new)
    return _move(servo, "id", new)


def set_baud(servo: Servo, baud: int) -> Change:
    """Give a servo another baud rate, follow it there and read it back. The line stays at the new rate.

    Raises:
        UsageError: its model has no such baud rate.
        BusError: it does not answer, another servo answers with it, or the adapter does not have the rate.
        ServoError: its torque is on, its id is taken at the new rate, or the servo does not take it.
    """
    return _move(servo, "baud_rate", baud_value(servo, baud))


def baud_value(servo: Servo, baud: int) -> int:
    """Return what the register holds for a baud rate. Raises UsageError if the model does not have it."""
    try:
        return servo.model.baud_value(baud)
    except ValueError as error:
        raise UsageError(str(error)) from error


def _move(servo: Servo, name: str, value: int) -> Change:
    servo.require_limp()
    servo.require_alone()
    return servo.write(name, value)
