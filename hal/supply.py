"""What servos' efforts come to at the voltage that they get.

A duty cycle of the supply drives the motor, so the same effort is less torque at an empty battery. Each servo tells its
voltage when it is its turn (`hal.condition`); by it efforts are told as they would be at the rated voltage.
"""

from hal.wired import Wired

_LEAST, _MOST = 0.5, 1.5  # of the rated voltage; a servo that says to work beyond has told something else


class SupplyShares:
    """Of one wire's servos.

    Attributes:
        by_slot: measured over rated voltage, of servos whose effort is a duty cycle and that have told their voltage.
    """

    def __init__(self) -> None:
        self.by_slot: dict[int, float] = {}

    def note(self, servo: Wired, volts: float) -> None:
        """Take what a servo measured, V."""
        if servo.model.effort_is_current:
            return
        share = volts / servo.model.specification.rated.voltage_v
        self.by_slot[servo.slot] = min(max(share, _LEAST), _MOST)

    def forget(self, slot: int) -> None:
        """Take a servo's voltage for the rated one until it tells anew."""
        self.by_slot.pop(slot, None)
