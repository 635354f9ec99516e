"""How a servo follows its goals, from its data."""

from hal.register_map import ServoModel
from robotwalk.types import DriveResponse


def response(model: ServoModel) -> DriveResponse:
    """Return the small-signal response of a servo's position loop at its rated voltage and default gain.

    The loop makes a spring of stiffness k = kt V / R x (duty per rad) against the armature; back-EMF and
    viscous friction damp it, Coulomb friction holds it back. Its effort is a current, or else the duty cycle, at its
    rated voltage (`hal.supply`), in which back-EMF has a share.
    """
    loop, motor = model.position_loop, model.motor
    gain = model[loop.proportional].default or 0
    duty_per_rad = loop.duty_per_tick(gain) / model.encoder.radians_per_tick
    rated = model.specification.rated
    stiffness = motor.torque_constant_nm_per_a / motor.resistance_ohm * rated.voltage_v * duty_per_rad
    effort = model[model.cyclic.effort]
    if model.effort_is_current:
        amperes = model.cyclic.effort_full_scale * effort.si_scale
        effort_torque, effort_damping = motor.torque_constant_nm_per_a * amperes, motor.friction.viscous_nms
    else:
        effort_torque = motor.torque_constant_nm_per_a / motor.resistance_ohm * rated.voltage_v
        effort_damping = motor.back_emf_damping + motor.friction.viscous_nms
    return DriveResponse(
        damping=(motor.back_emf_damping + motor.friction.viscous_nms) / stiffness,
        inertia=motor.armature_kgm2 / stiffness,
        friction=motor.friction.coulomb_nm / stiffness,
        max_speed=rated.no_load_speed,
        stiffness=stiffness,
        effort_torque=effort_torque,
        effort_damping=effort_damping,
    )
