"""A robot as its files describe it: what locomotion, the servos and the simulator each need of them."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from hal.calibration import Calibration
from hal.drive import response
from hal.hardware import HardwareConfig, foot_switch_problems, imu_problems, problems, stop_input_problems
from hal.imu.model import ImuModel
from hal.joint_calibration import CalibrationConfig
from hal.register_map import ServoModel
from hal.wired import Wired
from robotwalk import checks
from robotwalk.assembly.calibration import calibrate
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.config.schema import RobotConfig
from robotwalk.errors import ConfigError, UsageError
from robotwalk.gait import Gait
from robotwalk.gait_rules import fitted, read_gait
from robotwalk.model import RobotModel
from robotwalk.plausibility import Plausibility, plausibility
from robotwalk.types import DriveResponse, Strength

_USUAL_GAITS = ("tripod", "tetrapod", "trot", "wave")  # of six, eight, four legs; of any number
LIMP = "limp"  # the gait of a robot that has lost a leg
_CALIBRATION = "calibration.yaml"
_HUNG_TORQUE = 0.35


class Files(NamedTuple):
    """What a robot is read from: its own file, others by the names of theirs, and its calibration."""

    robot: Document
    servos: Mapping[str, Document]
    gaits: Mapping[str, Document]
    calibration: Document | None = None  # None: not calibrated, or to be taken as if it were not
    imus: Mapping[str, Document] = MappingProxyType({})

    def texts(self) -> dict[str, str]:
        """Return the text of each by its place ("robot.yaml", "servos/NAME.yaml"), a servo's with its base."""
        return {
            "robot.yaml": self.robot.text,
            **({_CALIBRATION: self.calibration.text} if self.calibration else {}),
            **{f"servos/{name}.yaml": document.whole_text for name, document in self.servos.items()},
            **{f"gaits/{name}.yaml": document.text for name, document in self.gaits.items()},
            **{f"imus/{name}.yaml": document.text for name, document in self.imus.items()},
        }

    @classmethod
    def parse(cls, texts: Mapping[str, str]) -> "Files":
        """Return what `texts` returned the text of. Raises ConfigError if it is not all there, or no YAML."""
        documents = {place: Document.parse(text, place) for place, text in texts.items()}
        if "robot.yaml" not in documents:
            raise ConfigError("robot.yaml: missing")
        return cls(
            documents["robot.yaml"], _in_folder(documents, "servos"), _in_folder(documents, "gaits"),
            documents.get(_CALIBRATION), _in_folder(documents, "imus"))


@dataclass(frozen=True)
class Blueprint:
    """A robot as its files describe it, every check passed that needs no motion."""

    document: Document
    model: RobotModel
    gaits: Mapping[str, Gait]
    hardware: HardwareConfig
    servos: Mapping[str, ServoModel]
    files: Files  # without servos and IMUs that it does not have
    calibration: CalibrationConfig | None = None  # which the rest then takes into account
    imu: ImuModel | None = None  # of what `hardware.imu` is
    hung: bool = False  # on a stand, its feet off the ground

    @property
    def default_gait(self) -> str:
        """The first of tripod, tetrapod, trot and wave that its feet can do; else the first of all."""
        able = [name for name in (*_USUAL_GAITS, *self.gaits) if name in self.gaits and name not in self.refused]
        return next(iter([*able, *self.gaits]))

    @property
    def bauds(self) -> dict[str, int]:
        """The baud rate of each bus."""
        return {name: bus.baud for name, bus in self.hardware.buses.items()}

    @property
    def lines(self) -> dict[str, int]:
        """The baud rate of each serial line: the buses, and those on which sensors talk."""
        return {**self.bauds, **{name: sensor.baud for name, sensor in self.hardware.sensors.items()}}

    @cached_property
    def wiring(self) -> dict[str, list[Wired]]:
        """The servos of each bus, in joint order."""
        wires: dict[str, list[Wired]] = {name: [] for name in self.hardware.buses}
        limbs = [leg.name for leg in self.model.legs for _ in leg.joints]
        for slot, (limb, joint) in enumerate(zip(limbs, self.model.joints, strict=True)):
            row = self.hardware.joints[joint.name]
            servo = self.servos[row.servo]
            calibration = Calibration(
                row.direction, math.radians(row.zero_deg), servo.encoder.centre, servo.encoder.radians_per_tick)
            wires[row.bus].append(
                Wired(joint.name, limb, slot, row.id, servo, calibration, joint.lower, joint.upper))
        return wires

    @property
    def torque(self) -> float:
        """Share of their largest output that the servos may use."""
        return _HUNG_TORQUE if self.hung else 1.0

    @property
    def blind(self) -> "Blueprint":
        """The same robot as it walks when it neither feels the ground nor keeps itself level."""
        return replace(self, model=replace(self.model, contact=None, orientation=None, levelling=None))

    def hang(self) -> "Blueprint":
        """Return the same robot as it is on a stand: its legs bear nothing, and its feet find no ground."""
        blind, safety = self.blind.model, self.model.safety
        fall = safety.fall.model_copy(update={"least_share": 0.0})
        model = replace(
            blind, leads=blind.leads._replace(load=False), safety=safety.model_copy(update={"fall": fall}))
        return replace(self, model=model, hung=True)

    def without(self, lost: Collection[str]) -> "Left":
        """Return what is left without some legs."""
        model = self.model.without(lost)
        legs = tuple(index for index, leg in enumerate(self.model.legs) if leg.name not in lost)
        joints = range(len(self.model.joints))
        slots = tuple(slot for index in legs for slot in joints[self.model.legs[index].span])
        return Left(model, load_gaits({LIMP: self.files.gaits[LIMP]}, model), slots, legs)

    @cached_property
    def drives(self) -> tuple[DriveResponse, ...]:
        """How each joint follows its goals."""
        return tuple(response(self.servos[self.hardware.joints[name].servo]) for name in self.model.joint_names)

    @cached_property
    def strengths(self) -> tuple[Strength, ...]:
        """What each joint's servo can give, in joint order."""
        rated = (self.servos[self.hardware.joints[name].servo].specification.rated for name in self.model.joint_names)
        return tuple(Strength(sheet.stall_torque_nm, sheet.no_load_speed) for sheet in rated)

    @cached_property
    def plausibilities(self) -> dict[str, Plausibility]:
        """What each gait asks of the servos, against what they can give."""
        return {name: plausibility(self.model, gait, self.strengths) for name, gait in self.gaits.items()}

    @cached_property
    def refused(self) -> dict[str, str]:
        """Gaits that ask for more than the servos can give, and what it is."""
        return {name: judged.complaint() for name, judged in self.plausibilities.items() if not judged.plausible}


class Left(NamedTuple):
    """What is left of a robot that has lost legs."""

    model: RobotModel
    gaits: Mapping[str, Gait]  # the one that bears that
    slots: tuple[int, ...]  # of its joints, in the whole robot's joint order
    legs: tuple[int, ...]  # in the whole robot's order


def load(robot: str, *, calibrated: bool = False) -> Blueprint:
    """Read a robot and all that it refers to; `calibrated`: as the one that was built is, not as its file has it.

    A servo's file in the folder `servos` beside the robot's counts before the bundled one of its name.

    Simulations are not calibrated, or the same file would walk otherwise on another computer.

    Raises:
        UsageError: no robot is bundled under that name.
        ConfigError: a file is wrong.
    """
    servos = {**_bundled("servos"), **library.beside(robot, "servos")}
    imus = {**_bundled("imus"), **library.beside(robot, "imus")}
    gaits = {**_bundled("gaits"), **library.beside(robot, "gaits")}
    files = Files(library.open_document("robots", robot), servos, gaits, imus=imus)
    path = library.calibration_path(robot)
    if calibrated and path.exists():
        files = files._replace(calibration=Document.read(path))
    return build(files)


def build(files: Files) -> Blueprint:
    """Make a robot of its files, in which there may be servos, IMUs and gaits that it does not need.

    Raises:
        ConfigError: a file is wrong.
    """
    document = files.robot
    config = document.validate(RobotConfig)
    checks.require_consistent(document, config)
    model = RobotModel.from_config(config)
    checks.require_reachable(document, model)
    hardware = document.validate(HardwareConfig, at=("hardware",))
    servos = {name: servo.validate(ServoModel) for name, servo in files.servos.items()}
    limits = {
        joint.name: (math.degrees(joint.lower), math.degrees(joint.upper)) for joint in model.joints}
    imus = {name: imu.validate(ImuModel) for name, imu in files.imus.items()}
    legs = [leg.name for leg in model.legs]
    for path, what, got in (
        *problems(hardware, limits, servos), *imu_problems(hardware, imus), *foot_switch_problems(hardware, legs),
        *stop_input_problems(hardware),
    ):
        raise document.error(("hardware", *path), what, got)
    if model.levelling is not None and hardware.imu is None:
        raise document.error(("locomotion", "levelling"), "this needs an IMU, which hardware: imu does not have")
    used = {joint.servo for joint in hardware.joints.values()}
    kinds = [] if hardware.imu is None else [hardware.imu.kind]
    needed = files._replace(
        servos={name: files.servos[name] for name in sorted(used)}, imus={kind: files.imus[kind] for kind in kinds})
    calibration = None
    if files.calibration is not None:
        calibration, hardware, model = calibrate(files.calibration, document, model, hardware, servos)
    return Blueprint(
        document, model, load_gaits(files.gaits, model), hardware, servos, needed, calibration,
        imus[hardware.imu.kind] if hardware.imu is not None else None)


def load_servo(name: str) -> ServoModel:
    """Read a bundled servo model."""
    return library.open_document("servos", name).validate(ServoModel)


def load_servos(own: Path | None = None) -> dict[str, ServoModel]:
    """Read all bundled servo models, and those in a folder of the user's own, which count before them.

    Raises:
        UsageError: there is no such folder.
        ConfigError: a file is wrong.
    """
    if own is not None and not own.is_dir():
        raise UsageError(f"{own} is no folder with servos' files")
    documents = {**_bundled("servos"), **(library.folder(own, "servos") if own is not None else {})}
    return {name: document.validate(ServoModel) for name, document in documents.items()}


def _bundled(kind: library.Kind) -> dict[str, Document]:
    return {name: library.open_document(kind, name) for name in library.names(kind)}


def load_gaits(documents: Mapping[str, Document], model: RobotModel) -> dict[str, Gait]:
    """Return every gait that is for this robot's feet. Files for other feet may share its name."""
    gaits = {}
    for document in documents.values():
        config = read_gait(document)
        checks.require_sound_gait(document, config)
        circles = fitted(config, model.legs)
        if circles is not None:
            gaits[config.name] = Gait(circles, model)
    return gaits


def _in_folder(documents: Mapping[str, Document], folder: str) -> dict[str, Document]:
    """Return the documents of a folder by their names in it."""
    return {
        place.removeprefix(f"{folder}/").removesuffix(".yaml"): document
        for place, document in documents.items() if place.startswith(f"{folder}/")}
