"""Scripts of faults: a list in YAML or from Python, checked against the robot and carried out by its clock.

    - {at: 0, fault: drop_reply, rate: 0.05}
    - {at: 4.5, for: 0.2, fault: push, force_n: 8, direction_deg: 90}

`at` counts simulated seconds from the moment that the simulation begins: 0 is before the first byte, so that what
begins then is there while the robot is armed. Chances come from the run's seed; each fault and each servo has its own.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

from robotwalk.config.document import Document
from sim_backend.faults.body import PressStop, Push, StuckJoint
from sim_backend.faults.fault import Fault
from sim_backend.faults.replies import CorruptFrame, DelayReply, DropReply
from sim_backend.faults.servos import BrownOut, DeadServo, Overheat, Overload, VoltageDrop, WrongFirmware
from sim_backend.faults.wires import DuplicateId, Noise, Unplug

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot

_NS = 1_000_000_000

Script = str | Path | Sequence[Mapping[str, Any]]

FAULTS: Mapping[str, type[Fault]] = {fault.kind(): fault for fault in (
    DropReply, CorruptFrame, DelayReply, DuplicateId, Noise, Unplug, BrownOut, Overload, Overheat, DeadServo,
    StuckJoint, VoltageDrop, WrongFirmware, Push, PressStop)}


def read_script(script: Script, wiring: Mapping[str, str], other_lines: Collection[str] = ()) -> list[Fault]:
    """Read a file, or a list of mappings as such a file has them.

    Args:
        script: the file or list.
        wiring: the bus of each of a robot's joints.
        other_lines: names of those on which no servos are.

    Raises:
        ConfigError: it is no such list, or does not fit the robot; says where.
    """
    if isinstance(script, str | Path):
        document = Document.read(Path(script))
    else:
        document = Document("faults", "", None, [dict(entry) for entry in script])
    entries = document.value(())
    if not isinstance(entries, list):
        raise document.error((), "expected a list of faults", entries)
    return [_read_fault(document, index, wiring, other_lines) for index in range(len(entries))]


def _read_fault(
    document: Document, index: int, wiring: Mapping[str, str], other_lines: Collection[str]
) -> Fault:
    name = document.value((index, "fault"))
    if not isinstance(name, str) or name not in FAULTS:
        near = get_close_matches(str(name), FAULTS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(FAULTS)}"
        raise document.error((index, "fault"), f"no such fault; {hint}", name)
    fault = document.validate(FAULTS[name], at=(index,))
    for key, problem, got in fault.complaints(wiring, other_lines):
        raise document.error((index, key), problem, got)
    return fault


def stage(robot: "SimulatedRobot", faults: Sequence[Fault], seed: int | str) -> None:
    """Have a simulated robot suffer faults, each at its time."""
    for index, fault in enumerate(faults):
        begin = _beginning(robot, fault, Random(f"{seed} {index} {fault.kind()}"))
        if fault.at == 0.0:
            begin()
        else:
            robot.clock.schedule(round(fault.at * _NS), begin)


def _beginning(robot: "SimulatedRobot", fault: Fault, chance: Random) -> Callable[[], None]:
    def begin() -> None:
        end = fault.begin(robot, chance)
        if end is not None and fault.lasts is not None:
            robot.clock.schedule(robot.clock.now() + round(fault.lasts * _NS), end)
    return begin


def explain_faults() -> list[dict[str, Any]]:
    """Tell of each fault its name, what happens, and its keys: what each means, and its value when left out."""
    return [
        {"name": name, "description": _flowing(fault.__doc__ or ""), "keys": _keys(fault)}
        for name, fault in FAULTS.items()]


def _flowing(docstring: str) -> str:
    return " ".join(docstring.split())


def _keys(fault: type[Fault]) -> dict[str, dict[str, Any]]:
    """Return the keys but the fault's name, in the order in which people write them."""
    return {
        field.alias or key: {"description": field.description, "required": field.is_required()}
        | ({} if field.is_required() else {"default": field.default})
        for key, field in fault.model_fields.items() if key != "fault"}
