"""The firmware of a Feetech SCS servo: a potentiometer's position, no offset, no modes but by the limits.

Assumed where manuals say nothing: outside of its range the position stays at the range's end.
"""

from hal.register_map import ScsFirmware
from sim_backend.feetech_firmware import FeetechServo
from sim_backend.feetech_table import FeetechTable
from sim_backend.scs_motion import ScsMotion
from sim_backend.servo_physics import ServoPhysics


class ScsServo(FeetechServo):
    """A servo of the SCS series."""

    def __init__(self, physics: ServoPhysics, index: int, **factory_settings: int) -> None:
        """Make the servo of one entry of `physics`, new but for some registers of the EEPROM."""
        model = physics.models[index]
        if not isinstance(model.firmware, ScsFirmware):
            raise ValueError(f"{model.name} is no SCS servo")  # noqa: TRY004 (a wrong model, not a wrong type)
        motion = ScsMotion(model, model.firmware, FeetechTable(model))
        self._last = model.encoder.ticks - 1
        super().__init__(physics, index, model.firmware, motion, factory_settings)

    def _shown(self, position: int) -> int:
        return min(max(position, 0), self._last)

    def _fold(self) -> None:
        self._load()
