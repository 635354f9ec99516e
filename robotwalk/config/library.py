"""Where configuration files are found: those that ship with the package, and the user's own by path."""

import os
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Literal

from robotwalk.config import inheritance
from robotwalk.config.document import Document
from robotwalk.errors import UsageError

Kind = Literal["robots", "servos", "imus", "gaits", "terrains"]


@cache
def root() -> Path:
    """Return the folder of the bundled files: inside the package where installed, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "configs"
    return installed if installed.is_dir() else package.parent / "configs"


def names(kind: Kind) -> list[str]:
    """Return the names of the bundled files of a kind, sorted."""
    return sorted(path.stem for path in (root() / kind).glob("*.yaml"))


def open_document(kind: Kind, name: str) -> Document:
    """Read a bundled file by its name, or any file by its path; one of a servo together with what it is based on.

    A bundled file is read once; nobody may change what is in it.

    Raises:
        UsageError: nothing of that name is bundled.
        ConfigError: the file cannot be read or is no YAML.
    """
    return _read(kind, name, ()) if is_path(name) else _open_bundled(kind, name)


def beside(robot: str, kind: Kind) -> dict[str, Document]:
    """Read the user's own files of a kind: those in a folder of its name beside the robot's file, by their names.

    Raises:
        ConfigError: one cannot be read or is no YAML.
    """
    return folder(Path(robot).parent / kind, kind) if is_path(robot) else {}


def folder(path: Path, kind: Kind) -> dict[str, Document]:
    """Read all files of a kind in a folder, by their names.

    Raises:
        ConfigError: one cannot be read or is no YAML.
    """
    return {file.stem: open_document(kind, str(file)) for file in sorted(path.glob("*.yaml"))}


@cache  # what ships with the package stays as it is
def _open_bundled(kind: Kind, name: str) -> Document:
    bundled = names(kind)
    if name not in bundled:
        near = get_close_matches(name, bundled, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"bundled are: {', '.join(bundled)}"
        raise UsageError(f"no {kind.removesuffix('s')} is named {name!r}; {hint}")
    return _read(kind, str(root() / kind / f"{name}.yaml"), ())


def _read(kind: Kind, path: str, derived: tuple[str, ...]) -> Document:
    """Read a file; `derived` are those that are based on it."""
    document = Document.read(Path(path))
    if kind != "servos":
        return document

    def open_base(base: str) -> Document:
        if base in (*derived, path):
            raise document.error(("base",), "a file cannot be based on itself", base)
        try:
            return _read(kind, base, (*derived, path)) if is_path(base) else _open_bundled(kind, base)
        except UsageError as error:
            raise document.error(("base",), str(error)) from error

    return inheritance.resolve(document, open_base)


def calibration_path(robot: str) -> Path:
    """Return where a robot's calibration is kept: beside the user's own file, else in the user's configuration.

    The latter is ~/.config, or what XDG_CONFIG_HOME says (XDG Base Directory Specification).
    """
    if is_path(robot):
        return Path(robot).with_suffix(".calibration.yaml")
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    home = Path(folder) if folder.startswith("/") else Path.home() / ".config"
    return home / "robotwalk" / f"{robot}.calibration.yaml"


def is_path(name: str) -> bool:
    """Tell whether a name is a file's path, not that of a bundled one."""
    return name.endswith((".yaml", ".yml")) or "/" in name
