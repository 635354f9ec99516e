"""A robot's `hardware` section: which servo moves which joint, on which bus; its IMU, its foot switches.

It is kept apart from the skeleton, so that one skeleton can take other servos.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from hal.foot_switches.frame import FRAMING
from hal.foot_switches.model import FootSwitchConfig
from hal.imu.model import ImuConfig, ImuModel
from hal.register_map import ServoModel
from hal.schema import Row
from hal.stop_input.model import StopInputConfig

IMU_PORT = "imu"  # what the line of the IMU is called beside the buses
FEET_PORT = "feet"  # that of the foot switches
STOP_PORT = "stop"  # and that of the stop input, where it has a port of its own
_BITS_PER_BYTE = 10  # 8N1


class BusConfig(Row):
    """One serial line."""

    port: str
    baud: Annotated[int, Field(gt=0)]


class Power(Row):
    """What feeds all servos."""

    supply_v: Annotated[float, Field(gt=0, le=60)] | None = None  # without load; None: each servo's rated voltage
    internal_resistance_ohm: Annotated[float, Field(ge=0, le=10)] = 0.05  # of battery, leads and plugs; assumed
    max_current_a: Annotated[float, Field(gt=0)] | None = None  # None: not stated


class JointWiring(Row):
    """The servo of one joint."""

    bus: str
    id: Annotated[int, Field(ge=0, le=252)]
    servo: str
    direction: Literal[1, -1]  # -1: the servo's counts fall as the joint's angle grows
    zero_deg: float  # the joint's angle where the servo reads its centre


class HardwareConfig(Row):
    """All of it."""

    buses: Annotated[dict[str, BusConfig], Field(min_length=1)]
    joints: dict[str, JointWiring]
    power: Power = Power()
    imu: ImuConfig | None = None
    foot_switches: FootSwitchConfig | None = None
    stop_input: StopInputConfig | None = None

    @property
    def sensors(self) -> dict[str, ImuConfig | FootSwitchConfig | BusConfig]:
        """What talks unasked, by the names of its lines."""
        stop = self.stop_input
        own = BusConfig(port=stop.port, baud=stop.baud) if stop is not None and stop.port is not None else None
        fitted = {IMU_PORT: self.imu, FEET_PORT: self.foot_switches, STOP_PORT: own}
        return {name: sensor for name, sensor in fitted.items() if sensor is not None}


class Problem(NamedTuple):
    """Something wrong that the schema alone cannot see."""

    path: tuple[str, ...]  # within the section
    what: str
    got: Any


def problems(
    config: HardwareConfig, joints: Mapping[str, tuple[float, float]], servos: Mapping[str, ServoModel]
) -> Iterator[Problem]:
    """Find joints and servos that do not fit together.

    Args:
        config: the section.
        joints: the skeleton's joints, each with its limits in degrees.
        servos: the known servo models.
    """
    for missing in [name for name in joints if name not in config.joints]:
        yield Problem(("joints",), f"joint {missing!r} has no servo", None)
    taken: dict[tuple[str, int], str] = {}
    first: dict[str, tuple[str, ServoModel]] = {}  # of each bus: joint and servo
    for name, wiring in config.joints.items():
        path = ("joints", name)
        if name not in joints:
            yield Problem(path, f"the skeleton has no such joint; it has {', '.join(joints)}", None)
        if wiring.bus not in config.buses:
            yield Problem((*path, "bus"), f"no such bus; there are {', '.join(config.buses)}", wiring.bus)
        other = taken.setdefault((wiring.bus, wiring.id), name)
        if other != name:
            yield Problem((*path, "id"), f"already the id of {other} on bus {wiring.bus!r}", wiring.id)
        if wiring.servo not in servos:
            yield Problem((*path, "servo"), f"no such servo; there are {', '.join(servos)}", wiring.servo)
            continue
        servo, bus = servos[wiring.servo], config.buses.get(wiring.bus)
        if bus is not None and bus.baud not in servo.baud_rates:
            rates = ", ".join(map(str, servo.baud_rates))
            yield Problem(("buses", wiring.bus, "baud"), f"servo {servo.name} of {name} has only {rates}", bus.baud)
        other, model = first.setdefault(wiring.bus, (name, servo))
        if servo.frames != model.frames:
            yield Problem(
                (*path, "servo"), f"on bus {wiring.bus!r} with the {model.name} of {other}, whose frames differ",
                servo.name)
        if name in joints:
            low, high = (wiring.direction * (limit - wiring.zero_deg) for limit in joints[name])
            reach = servo.encoder.range_deg
            if min(low, high) < reach[0] or max(low, high) > reach[1]:
                yield Problem(
                    (*path, "zero_deg"),
                    f"the joint's limits {joints[name][0]:.1f} to {joints[name][1]:.1f} deg leave the servo's range "
                    f"of {reach[0]:.0f} to {reach[1]:.0f} deg about its centre", wiring.zero_deg)


def imu_problems(config: HardwareConfig, imus: Mapping[str, ImuModel]) -> Iterator[Problem]:
    """Find what is wrong with the IMU, if there is one, of the known kinds of it."""
    imu = config.imu
    if imu is None:
        return
    if IMU_PORT in config.buses:
        yield Problem(("buses", IMU_PORT), "that is what the line of the IMU is called", None)
    model = imus.get(imu.kind)
    if model is None:
        yield Problem(("imu", "kind"), f"no such IMU; there are {', '.join(imus)}", imu.kind)
        return
    if imu.baud not in model.baud_rates:
        rates = ", ".join(map(str, model.baud_rates))
        yield Problem(("imu", "baud"), f"{model.name} has only {rates}", imu.baud)
    rate = imu.rate_hz or model.rate_hz
    if rate > model.max_rate_hz:
        yield Problem(("imu", "rate_hz"), f"{model.name} has at most {model.max_rate_hz:g} Hz", rate)
    if imu.stale_after_s * rate < 1.5:
        told = f"is hardly longer than from one measurement to the next, at {rate:g} Hz"
        yield Problem(("imu", "stale_after_s"), told, imu.stale_after_s)
    fits = imu.baud / _BITS_PER_BYTE / model.report_bytes
    if rate > fits:
        told = f"carries {fits:.1f} measurements of {model.name} a second, which sends {rate:g}"
        yield Problem(("imu", "baud"), told, imu.baud)


def foot_switch_problems(config: HardwareConfig, legs: Sequence[str]) -> Iterator[Problem]:
    """Find what is wrong with the foot switches, if there are any, of a robot of these legs."""
    switches, section = config.foot_switches, "foot_switches"
    if switches is None:
        return
    if FEET_PORT in config.buses:
        yield Problem(("buses", FEET_PORT), "that is what the line of the foot switches is called", None)
    taken: dict[int, str] = {}
    for leg, bit in switches.inputs.items():
        if leg not in legs:
            yield Problem((section, "inputs", leg), f"the robot has no such leg; it has {', '.join(legs)}", None)
        other = taken.setdefault(bit, leg)
        if other != leg:
            yield Problem((section, "inputs", leg), f"already the input of {other}", bit)
    if switches.stale_after_s * switches.rate_hz < 1.5:
        told = f"is hardly longer than from one report to the next, at {switches.rate_hz:g} Hz"
        yield Problem((section, "stale_after_s"), told, switches.stale_after_s)
    fits = switches.baud / _BITS_PER_BYTE / FRAMING.size
    if switches.rate_hz > fits:
        told = f"carries {fits:.0f} reports a second, and the board sends {switches.rate_hz:g}"
        yield Problem((section, "baud"), told, switches.baud)


def stop_input_problems(config: HardwareConfig) -> Iterator[Problem]:
    """Find what is wrong with the stop input, if there is one."""
    stop, section = config.stop_input, "stop_input"
    if stop is None:
        return
    if STOP_PORT in config.buses:
        yield Problem(("buses", STOP_PORT), "that is what the line of the stop input is called", None)
    if (stop.bus is None) is (stop.port is None):
        yield Problem((section,), "needs either `bus`, whose adapter has the line, or a `port` of its own", None)
    if (stop.line is None) is (stop.input is None):
        yield Problem((section,), "needs either a `line` of the port, or an `input` of a board that talks there", None)
    if stop.bus is not None and stop.bus not in config.buses:
        yield Problem((section, "bus"), f"no such bus; there are {', '.join(config.buses)}", stop.bus)
    if stop.bus is not None and stop.input is not None:
        yield Problem((section, "input"), "a board needs a `port` of its own, servos talk on a bus", stop.input)
