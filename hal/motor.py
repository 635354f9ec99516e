"""A servo's motor and gears as data: the schema of the `motor` section of `configs/servos/*.yaml`.

Source of the models: Duclusaud et al., "Extended Friction Models for the Physics Simulation of Servo Actuators",
ICRA 2025 (BAM). All figures are seen at the output shaft.
"""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from hal.schema import Row


class CoulombFriction(Row):
    """BAM's M1: a torque of at most viscous |w| + coulomb."""

    load: ClassVar[float] = 0.0
    stribeck_nm: ClassVar[float] = 0.0
    stribeck_load: ClassVar[float] = 0.0
    stribeck_rad_s: ClassVar[float] = 1.0
    stribeck_exponent: ClassVar[float] = 1.0

    model: Literal["M1"]
    coulomb_nm: Annotated[float, Field(ge=0)]
    viscous_nms: Annotated[float, Field(ge=0)]


class StribeckFriction(Row):
    """BAM's M4: friction that grows with the torque on the gears, and falls as they begin to move.

    A torque of at most
    viscous |w| + coulomb + load L + exp(-|w / stribeck_rad_s|^stribeck_exponent) (stribeck + stribeck_load L)
    with L = |motor's torque - external torque|, both counted the same way round: twice the load that is held.
    """

    model: Literal["M4"]
    coulomb_nm: Annotated[float, Field(ge=0)]
    viscous_nms: Annotated[float, Field(ge=0)]
    load: Annotated[float, Field(ge=0, lt=1)]
    stribeck_nm: Annotated[float, Field(ge=0)]
    stribeck_load: Annotated[float, Field(ge=0, lt=1)]
    stribeck_rad_s: Annotated[float, Field(gt=0)]
    stribeck_exponent: Annotated[float, Field(gt=0)]


class Motor(Row):
    """A direct-current motor behind gears, seen at the output shaft.

    torque = kt V / R - kt^2 w / R, V = supply x duty; less friction.
    """

    source: str
    torque_constant_nm_per_a: Annotated[float, Field(gt=0)]
    resistance_ohm: Annotated[float, Field(gt=0)]
    armature_kgm2: Annotated[float, Field(gt=0)]  # the rotor's inertia times the gear ratio squared
    friction: Annotated[CoulombFriction | StribeckFriction, Field(discriminator="model")]
    backlash_deg: Annotated[float, Field(ge=0, lt=5)]  # the shaft's whole free play while the rotor stands still
    # Published for no servo: assumed for a motor in a plastic case of half a hectogram.
    thermal_resistance_k_per_w: Annotated[float, Field(gt=0)] = 10.0  # from the winding to the air
    thermal_time_constant_s: Annotated[float, Field(gt=0)] = 300.0

    @property
    def back_emf_damping(self) -> float:
        """Torque per speed of a driven motor, kt^2 / R, N m s."""
        return self.torque_constant_nm_per_a**2 / self.resistance_ohm
