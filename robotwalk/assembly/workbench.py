"""One serial line and its servos, for the tools of `robotwalk servo`: no robot's file is needed."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from hal.maintenance import backup as backup_file
from hal.maintenance import quantity as quantity  # named twice: what `robotwalk servo` works with
from hal.maintenance.address import set_baud as set_baud
from hal.maintenance.address import set_id as set_id
from hal.maintenance.adopt import Vacancy
from hal.maintenance.backup import Backup as Backup
from hal.maintenance.bench import Bench as Bench
from hal.maintenance.identity import Identity as Identity
from hal.maintenance.monitor import Sample as Sample
from hal.maintenance.monitor import sample as sample
from hal.maintenance.place import Place as Place
from hal.maintenance.scan import Clash as Clash
from hal.maintenance.scan import Finding as Finding
from hal.maintenance.scan import Noise as Noise
from hal.maintenance.scan import Progress as Progress
from hal.maintenance.servo import Change as Change
from hal.maintenance.servo import Servo as Servo
from hal.maintenance.vendor_sdk import Keep as Keep
from hal.maintenance.wiggle import Wiggled as Wiggled
from hal.maintenance.wiggle import wiggle as wiggle
from hal.register_map import ProtocolName as ProtocolName
from hal.register_map import Register as Register
from hal.register_map import ServoModel as ServoModel
from hal.serial_transport import names_hardware, open_port
from hal.wired import Wired as Wired
from robotwalk.assembly.blueprint import Blueprint, load
from robotwalk.assembly.blueprint import load_servos as load_servos
from robotwalk.clock import WallClock
from robotwalk.config.document import Document
from robotwalk.errors import ServoError, UsageError


class Seat(NamedTuple):
    """A joint of a robot, and the line on which its servo is, or is to be."""

    blueprint: Blueprint
    wired: Wired
    url: str

    @property
    def baud(self) -> int:
        """The baud rate of its bus."""
        return self.blueprint.bauds[self.bus]

    @property
    def bus(self) -> str:
        """The name of its bus."""
        return self.blueprint.hardware.joints[self.wired.joint].bus

    @property
    def vacancy(self) -> Vacancy:
        """Its place, for a new servo."""
        places = [Place(self.baud, wired.id) for wired in self.blueprint.wiring[self.bus]]
        place = Place(self.baud, self.wired.id)
        return Vacancy(self.wired.joint, place, self.wired.model, [other for other in places if other != place])

    def servo(self, bench: Bench) -> Servo:
        """Return the servo that is there.

        Raises:
            BusError: nobody answers.
            ServoError: it is of another model than the robot's file says.
        """
        servo = bench.servo(self.wired.id)
        if servo.model.name != self.wired.model.name:
            raise ServoError(
                f"{servo} is in the place of {self.wired.joint}, which has an {self.wired.model.name} by the robot's "
                "file")
        return servo


def seat(robot: str, joint: str, port: str | None, *, calibrated: bool = True) -> Seat:
    """Return a joint of a robot, on the line that its file names or on another.

    Raises:
        UsageError: no such robot or joint.
        ConfigError: a file is wrong.
    """
    blueprint = load(robot, calibrated=calibrated)
    for bus, wires in blueprint.wiring.items():
        for wired in wires:
            if wired.joint == joint:
                return Seat(blueprint, wired, port or blueprint.hardware.buses[bus].port)
    names = blueprint.model.joint_names
    near = get_close_matches(joint, names, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(names)}"
    raise UsageError(f"{blueprint.model.name} has no joint {joint!r}; {hint}")


@contextmanager
def bench(
    url: str, *, baud: int, protocol: str | None, real: bool, writes: bool,
    servos: Mapping[str, ServoModel] | None = None,
) -> Iterator[Bench]:
    """Open one line for the maintenance of single servos; `protocol` is the only one to be tried, if given.

    They are of one of the models `servos`, by default of a bundled one.

    Raises:
        UsageError: no servo has this baud rate or protocol, or a physical one would be changed and was not asked for.
        BusError: the port does not open.
    """
    if writes and not real and names_hardware(url):
        raise UsageError(f"{url} may be a physical robot, and this changes or moves a servo: say --real to do it")
    models = [model for model in (servos or load_servos()).values() if protocol in (None, model.protocol)]
    bauds = sorted({rate for model in models for rate in model.baud_rates})
    if baud not in bauds:
        whose = f"of {protocol}" if protocol else "that we know"
        raise UsageError(f"no servo {whose} has {baud} baud; there are {', '.join(map(str, bauds))}")
    port = open_port(url, baud)
    try:
        yield Bench(port, WallClock(), models)
    finally:
        port.close()


def read_backup(path: Path, servos: Mapping[str, ServoModel]) -> Backup:
    """Read the backup of a servo of one of these models.

    Raises:
        ConfigError: the file is wrong.
    """
    document = Document.read(path)
    backup = document.validate(Backup)
    if backup.model not in servos:
        raise document.error(("model",), f"no such servo; there are {', '.join(servos)}", backup.model)
    for name, what, got in backup_file.problems(backup, servos[backup.model]):
        raise document.error(("registers", name), what, got)
    return backup


def backup_text(backup: Backup, path: Path, servos: Mapping[str, ServoModel]) -> str:
    """Return what to write to a file of that name: JSON if it is called so, else YAML."""
    if path.suffix == ".json":
        return backup_file.to_json(backup)
    return backup_file.to_yaml(backup, servos[backup.model])
