"""What is installed: the three packages and the data, never the tests; and it walks outside the checkout."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("wheel")

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel and unpack it, as an installer would."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run(build, check=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def test_the_wheel_holds_the_packages_and_the_data_and_nothing_else(installed: Path) -> None:
    names = {path.name for path in installed.iterdir() if not path.name.endswith(".dist-info")}
    assert names == {"robotwalk", "hal", "sim_backend"}
    for kind in ("robots", "servos", "gaits"):
        bundled = {path.name for path in (ROOT / "configs" / kind).glob("*.yaml")}
        assert {path.name for path in (installed / "robotwalk" / "configs" / kind).glob("*.yaml")} == bundled
    assert not list(installed.rglob("test_*"))


def test_an_install_outside_the_checkout_walks(installed: Path, tmp_path: Path) -> None:
    program = (
        "import robotwalk, sim_backend\n"
        "print(robotwalk.__file__)\n"
        "with robotwalk.open('hexapod') as robot:\n"
        "    robot.stand()\n"
        "    robot.walk(vx=0.1, seconds=1.0)\n"
        "    print(robot.state.odometry.x)\n")
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(installed)},
        capture_output=True, text=True, check=True)
    where, distance = done.stdout.split()
    assert Path(where).is_relative_to(installed)
    assert float(distance) == pytest.approx(0.1, rel=0.2)
