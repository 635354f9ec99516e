"""The rooms of the house: who may import whom."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("robotwalk", "hal", "sim_backend")
CONTRACTS = ("robotwalk.ports", "robotwalk.types", "robotwalk.errors")
ALLOWED = {
    "robotwalk": ("robotwalk",),
    "hal": ("hal", *CONTRACTS),
    "sim_backend": (
        "sim_backend", "hal.register_map", "robotwalk.config", "robotwalk.model", "robotwalk.realtime", *CONTRACTS),
}
COMPOSITION_ROOT = Path("robotwalk/assembly")


def imported(source: str, package: tuple[str, ...]) -> set[str]:
    """Return the full names of all modules that a source imports, at any depth, from anywhere in it."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module) if part)
            names.update(f"{module}.{alias.name}" for alias in node.names)
    return names


def strangers(source: str, path: Path) -> set[str]:
    """Return the imports of our own packages that a file at `path` may not have."""
    if path.is_relative_to(COMPOSITION_ROOT):
        return set()
    allowed = ALLOWED[path.parts[0]]
    ours = {name for name in imported(source, path.parent.parts) if name.split(".")[0] in ROOMS}
    return {name for name in ours if not any(name == a or name.startswith(f"{a}.") for a in allowed)}


SOURCES = sorted(path.relative_to(ROOT) for room in ROOMS for path in (ROOT / room).rglob("*.py"))


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_a_room_imports_only_what_it_may(path: Path) -> None:
    assert strangers((ROOT / path).read_text(), path) == set()


def test_there_are_sources_in_every_room() -> None:
    assert {path.parts[0] for path in SOURCES} == set(ROOMS)


@pytest.mark.parametrize(("path", "source", "found"), [
    ("robotwalk/gait.py", "import hal.servo_bus", {"hal.servo_bus"}),
    ("robotwalk/cli/walk.py", "def f():\n    from sim_backend import film", {"sim_backend.film"}),
    ("hal/servo_bus.py", "from robotwalk.model import Leg", {"robotwalk.model.Leg"}),
    ("hal/servo_bus.py", "from robotwalk.types import Pose", set()),
    ("sim_backend/world.py", "from hal.encoding import pack", {"hal.encoding.pack"}),
    ("sim_backend/world.py", "from hal import encoding", {"hal.encoding"}),
    ("sim_backend/world.py", "from robotwalk import kinematics", {"robotwalk.kinematics"}),
    ("robotwalk/assembly/session.py", "import hal.servo_bus, sim_backend.world", set()),
])
def test_the_rule_sees_a_forbidden_import(path: str, source: str, found: set[str]) -> None:
    assert strangers(source, Path(path)) == found
