"""What a robot asks of its wires and of its supply, without a motion."""

from typing import NamedTuple

from hal import bus_plan
from hal.protocols import protocol_of
from robotwalk.assembly.blueprint import Blueprint

_SHARE_OF_TICK = 0.8  # that a bus may take, with a fifth of the wire free


class BusLoad(NamedTuple):
    """What a tick costs on one bus."""

    name: str
    baud: int
    servos: int
    wire_s: float  # that its exchange takes
    least_s: float  # that it must have: servos that are read one by one may wait for a later tick
    share: float  # of the tick, of what it must have
    largest_rate_hz: int  # that leaves a fifth of the wire free
    raised_by: tuple[bus_plan.Remedy, ...]
    lowered_by: tuple[bus_plan.Remedy, ...]


def bus_loads(blueprint: Blueprint, rate_hz: int) -> list[BusLoad]:
    """Plan each bus's exchange with return delay 0 and, where every servo may have it, fast sync read."""
    loads = []
    for name, wired in blueprint.wiring.items():
        baud = blueprint.hardware.buses[name].baud
        protocol = protocol_of(wired[0].model)
        plan = bus_plan.cycle(protocol, wired, fast=True)
        least = plan.seconds(baud, rate_hz)
        loads.append(BusLoad(
            name, baud, len(wired), plan.taken(baud, rate_hz), least, least * rate_hz,
            plan.largest_rate(baud, _SHARE_OF_TICK),
            tuple(bus_plan.remedies(protocol, wired, baud, _SHARE_OF_TICK)),
            tuple(bus_plan.costs(protocol, wired, baud, _SHARE_OF_TICK))))
    return loads


class SupplyLoad(NamedTuple):
    """What the servos may draw, against what the supply gives."""

    stall_a: float  # all of them stalled at once, by their data sheets
    unknown: int  # servos whose data sheet has no stall current: by torque constant and resistance
    stated_a: float | None
    supply_v: float  # without load
    sag_v: float  # that the stall current would take from it


def supply_load(blueprint: Blueprint) -> SupplyLoad:
    """Add up what all servos draw when they are stalled at once."""
    models = [blueprint.servos[row.servo] for row in blueprint.hardware.joints.values()]
    power = blueprint.hardware.power
    stall = [
        model.specification.rated.stall_current_a
        or model.specification.rated.voltage_v / model.motor.resistance_ohm for model in models]
    unknown = sum(model.specification.rated.stall_current_a is None for model in models)
    supply = power.supply_v or max(model.specification.rated.voltage_v for model in models)
    return SupplyLoad(sum(stall), unknown, power.max_current_a, supply, sum(stall) * power.internal_resistance_ohm)
