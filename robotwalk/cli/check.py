"""`robotwalk check`: everything about a robot that can be judged without moving it."""

import math
from typing import Any, NamedTuple

from robotwalk import assembly, checks
from robotwalk.cli.options import Json, RobotName
from robotwalk.cli.output import say, write_json, write_table
from robotwalk.plausibility import Plausibility

_TIGHT = math.radians(2.0)  # a joint this near its limit is worth a warning
_BUSY = 0.8  # of a tick that the bus may take


def check(robot: RobotName, /, *, rate: int = assembly.RATE_HZ, json: Json = False) -> int:
    """Check a robot's files: schema, reach, joint margin, balance, and the bus's time at the rate.

    Parameters
    ----------
    rate
        Ticks per second that the bus shall carry.
    """
    assembly.check_rate(rate)
    blueprint = assembly.load(robot, calibrated=True)
    gaits = [
        _Judged(checks.gait_reach(blueprint.model, gait), checks.balance(blueprint.model, gait),
                blueprint.plausibilities[name])
        for name, gait in blueprint.gaits.items()]
    buses = assembly.bus_loads(blueprint, rate)
    supply = assembly.supply_load(blueprint)
    problems = _problems(gaits, buses, supply)
    if json:
        write_json({
            "robot": blueprint.model.name,
            "ok": not problems,
            "problems": problems,
            "mass_kg": round(blueprint.model.mass, 4),
            "calibration": _calibration_fields(blueprint),
            "gaits": [_gait_fields(gait) for gait in gaits],
            "rate_hz": rate,
            "buses": {
                bus.name: {"baud": bus.baud, "servos": bus.servos, "wire_ms": round(1e3 * bus.wire_s, 3),
                           "least_ms": round(1e3 * bus.least_s, 3),
                           "share_of_tick": round(bus.share, 3), "largest_rate_hz": bus.largest_rate_hz,
                           "raised_by": [remedy._asdict() for remedy in bus.raised_by],
                           "lowered_by": [remedy._asdict() for remedy in bus.lowered_by]}
                for bus in buses
            },
            **_imu_fields(blueprint),
            **_foot_switch_fields(blueprint),
            **_stop_input_fields(blueprint),
            "supply": {
                "stall_a": round(supply.stall_a, 2), "stated_a": supply.stated_a, "supply_v": supply.supply_v,
                "sag_at_stall_v": round(supply.sag_v, 2), "servos_without_sheet": supply.unknown},
        })
    else:
        _show(blueprint, gaits, buses, rate)
        _show_imu(blueprint)
        _show_foot_switches(blueprint)
        _show_stop_input(blueprint)
        _show_supply(supply)
        for problem in problems:
            say(f"problem: {problem}")
        say("all checks passed" if not problems else f"{len(problems)} problem(s)")
    return 1 if problems else 0


class _Judged(NamedTuple):
    """All that is known of a gait without moving."""

    reach: checks.GaitReach
    balance: checks.Balance
    plausibility: Plausibility


def _problems(gaits: list[_Judged], buses: list[assembly.BusLoad], supply: assembly.SupplyLoad) -> list[str]:
    problems = []
    able = [gait for gait in gaits if gait.plausibility.plausible]  # walk refuses the others
    if not able:
        problems.append("the servos can give none of its gaits what it asks for")
    for reach in (gait.reach for gait in able):
        joint = reach.tightest
        if reach.miss > checks.REACHED:
            problems.append(f"gait {reach.gait}: the longest stride is {1e3 * reach.miss:.0f} mm out of reach")
        if joint.margin < 0.0:
            problems.append(
                f"gait {reach.gait}: at the longest stride {joint.joint} would leave its limits by "
                f"{-math.degrees(joint.margin):.1f} deg")
        elif joint.margin < _TIGHT:
            problems.append(
                f"gait {reach.gait}: at the longest stride {joint.joint} comes within "
                f"{math.degrees(joint.margin):.1f} deg of its limit")
    for bus in buses:
        if bus.share > _BUSY:
            problems.append(
                f"bus {bus.name} needs {1e3 * bus.least_s:.2f} ms a tick, {100 * bus.share:.0f} % of it; "
                f"the largest rate is {bus.largest_rate_hz} Hz")
    if supply.stated_a is not None and supply.stall_a > supply.stated_a:
        problems.append(
            f"all servos stalled would draw {supply.stall_a:.1f} A; the supply is stated to give {supply.stated_a:g} A")
    problems.extend(
        f"gait {balance.gait}: the centre of mass is outside the support polygon by {-1e3 * balance.margin:.0f} mm"
        for balance in (gait.balance for gait in able) if balance.margin is not None and balance.margin < 0.0)
    return problems


def _calibration_fields(blueprint: assembly.Blueprint) -> dict[str, Any] | None:
    file, config = blueprint.files.calibration, blueprint.calibration
    if file is None or config is None:
        return None
    return {"file": file.name, "joints": {name: row.model_dump() for name, row in config.joints.items()}}


def _show_calibration(blueprint: assembly.Blueprint) -> None:
    """Say which joints are calibrated, and how that differs from the robot's file."""
    file, config = blueprint.files.calibration, blueprint.calibration
    if file is None or config is None:
        say("calibration: none; zeros and directions are those of the robot's file")
        return
    write_table(
        f"calibration of {len(config.joints)} of {len(blueprint.model.joints)} joints: {file.name}",
        ["joint", "direction", "zero", "range", "moved back to zero"],
        [
            [name, f"{row.direction:+d}", f"{row.zero_deg:.2f} deg",
             "" if row.range_deg is None else f"{row.range_deg[0]:.1f} to {row.range_deg[1]:.1f} deg",
             "yes" if row.verified else "no"]
            for name, row in config.joints.items()
        ])


def _imu_fields(blueprint: assembly.Blueprint) -> dict[str, Any]:
    """Return what is to be said of the IMU; nothing without one."""
    imu, model = blueprint.hardware.imu, blueprint.imu
    if imu is None or model is None:
        return {}
    return {"imu": {
        "kind": imu.kind, "rate_hz": imu.rate_hz or model.rate_hz, "baud": imu.baud,
        "mounting_deg": list(imu.mounting_deg), "levels": blueprint.model.levelling is not None}}


def _show_imu(blueprint: assembly.Blueprint) -> None:
    for imu in _imu_fields(blueprint).values():
        roll, pitch, yaw = imu["mounting_deg"]
        say(f"IMU: {imu['kind']}, {imu['rate_hz']:g} Hz at {imu['baud']} baud, "
            f"mounted at roll {roll:g}, pitch {pitch:g}, yaw {yaw:g} deg; "
            f"the body is {'' if imu['levels'] else 'not '}kept level by it")


def _foot_switch_fields(blueprint: assembly.Blueprint) -> dict[str, Any]:
    """Return what is to be said of the foot switches; nothing without any."""
    switches = blueprint.hardware.foot_switches
    if switches is None:
        return {}
    return {"foot_switches": {
        "inputs": switches.inputs, "rate_hz": switches.rate_hz, "baud": switches.baud,
        "stale_after_s": switches.stale_after_s, "used": blueprint.model.contact is not None}}


def _show_foot_switches(blueprint: assembly.Blueprint) -> None:
    for switches in _foot_switch_fields(blueprint).values():
        say(f"foot switches: {', '.join(switches['inputs'])}, {switches['rate_hz']:g} Hz at {switches['baud']} baud; "
            + (f"silent for {switches['stale_after_s']:g} s, feet go by their loads" if switches["used"]
               else "nothing goes by them without locomotion: contact"))


def _stop_input_fields(blueprint: assembly.Blueprint) -> dict[str, Any]:
    """Return what is to be said of the stop input; nothing without one."""
    config = blueprint.hardware.stop_input
    if config is None:
        return {}
    place = f"line {config.line.upper()}" if config.line is not None else f"input {config.input} of the board"
    where = f"of bus {config.bus}" if config.bus is not None else f"at {config.port}"
    return {"stop_input": {"at": f"{place} {where}", "contact": config.contact, "stop": config.stop}}


def _show_stop_input(blueprint: assembly.Blueprint) -> None:
    for button in _stop_input_fields(blueprint).values():
        warning = "" if button["contact"] == "normally_closed" else "; a cut wire is not noticed"
        say(f"stop input: {button['at']}, {button['contact'].replace('_', ' ')}: {button['stop']}{warning}")


def _gait_fields(gait: _Judged) -> dict[str, Any]:
    reach, balance, judged = gait
    joint = reach.tightest
    return {
        "gait": reach.gait,
        "top_speed_mps": round(reach.top_speed, 4),
        "reach_error_mm": round(1e3 * reach.miss, 3),
        "tightest_joint": joint.joint,
        "joint_margin_deg": round(math.degrees(joint.margin), 2),
        "balance_margin_mm": None if balance.margin is None else round(1e3 * balance.margin, 1),
        "load": round(judged.load, 3),
        "refused": None if judged.plausible else judged.complaint(),
    }


def _show(
    blueprint: assembly.Blueprint, gaits: list[_Judged], buses: list[assembly.BusLoad], rate: int
) -> None:
    model = blueprint.model
    say(f"{model.name}: {len(model.legs)} legs, {len(model.joints)} joints, {model.mass:.2f} kg; files are sound")
    _show_calibration(blueprint)
    write_table(
        "gaits, at the longest stride in any direction and every height",
        ["gait", "top speed", "reach", "tightest joint", "its margin", "balance", "servos' load"],
        [
            [reach.gait, f"{reach.top_speed:.2f} m/s",
             "ok" if reach.miss <= checks.REACHED else f"{1e3 * reach.miss:.0f} mm short",
             reach.tightest.joint, f"{math.degrees(reach.tightest.margin):.1f} deg",
             "dynamic" if balance.margin is None else f"{1e3 * balance.margin:.0f} mm",
             f"{judged.load:.2f}" + ("" if judged.plausible else ", refused")]
            for reach, balance, judged in gaits
        ])
    write_table(
        f"buses, at {rate} Hz",
        ["bus", "baud", "servos", "wire time a tick", "at least", "of the tick", "largest rate"],
        [
            [bus.name, str(bus.baud), str(bus.servos), f"{1e3 * bus.wire_s:.2f} ms",
             f"{1e3 * bus.least_s:.2f} ms", f"{100 * bus.share:.0f} %", f"{bus.largest_rate_hz} Hz"]
            for bus in buses
        ])
    for bus in buses:
        raised = "; ".join(f"{remedy.what}: {remedy.largest_rate_hz} Hz" for remedy in bus.raised_by[:3])
        lowered = "; ".join(f"{remedy.what}: {remedy.largest_rate_hz} Hz" for remedy in bus.lowered_by)
        say(f"bus {bus.name}, largest rate with " + (f"{raised}" if raised else "nothing that we know would be higher"))
        say(f"  but with {lowered}")


def _show_supply(supply: assembly.SupplyLoad) -> None:
    stated = "not stated (hardware: power: max_current_a)" if supply.stated_a is None else f"{supply.stated_a:g} A"
    guessed = f", of {supply.unknown} by torque constant and resistance" if supply.unknown else ""
    say(
        f"supply: all servos stalled draw {supply.stall_a:.1f} A{guessed}; it gives {stated}. "
        f"{supply.supply_v:g} V would sag by {min(supply.sag_v, supply.supply_v):.1f} V")
