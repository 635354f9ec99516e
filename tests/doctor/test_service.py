"""What `robotwalk service install` writes: a unit that systemd takes, a rule that names the adapter."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from robotwalk.doctor.computer import Computer
from robotwalk.doctor.service import Service, service
from tests.cli.conftest import Run
from tests.cli.conftest import robotwalk as robotwalk


def plugged(root: Path) -> Computer:
    """Make up a computer with an adapter of two interfaces; the second is /dev/ttyUSB1."""
    usb = root / "sys/devices/pci0/usb1/1-2"
    tty = usb / "1-2:1.1/ttyUSB1"
    tty.mkdir(parents=True)
    (usb / "serial").write_text("FT9RZ42\n")
    (usb / "1-2:1.1/bInterfaceNumber").write_text("01\n")
    known = root / "sys/class/tty/ttyUSB1"
    known.mkdir(parents=True)
    (known / "device").symlink_to(tty)
    return Computer(root)


def described(root: Path, robot: str = "my hexapod") -> Service:
    command = [shutil.which("true") or "/bin/true", "teleop", f"/home/pi/100 %/{robot}.yaml", "--real", "--seated"]
    return service(robot, "root", command, {"legs": "/dev/ttyUSB1", "imu": "/dev/ttyUSB7"}, plugged(root))


def test_the_rule_names_the_adapter_and_not_the_port(tmp_path: Path) -> None:
    found = described(tmp_path)
    assert found.name == "robotwalk-my-hexapod"
    assert found.unknown == ("/dev/ttyUSB7",)
    assert found.rule.path == "/etc/udev/rules.d/70-robotwalk-my-hexapod.rules"
    assert (
        'SUBSYSTEM=="tty", ENV{ID_SERIAL_SHORT}=="FT9RZ42", ENV{ID_USB_INTERFACE_NUM}=="01", '
        'SYMLINK+="robotwalk-my-hexapod-legs", GROUP="dialout", MODE="0660"') in found.rule.text.splitlines()
    assert 'ATTR{latency_timer}="1"' in found.rule.text
    assert "ttyUSB" not in found.rule.text


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="needs systemd-analyze")
def test_systemd_takes_the_unit(tmp_path: Path) -> None:
    found = described(tmp_path / "computer")
    unit = tmp_path / Path(found.unit.path).name
    unit.write_text(f"{found.unit.text}\n")
    verified = subprocess.run(["systemd-analyze", "verify", str(unit)], capture_output=True, text=True, check=False)
    assert (verified.returncode, verified.stderr.strip()) == (0, "")
    unit.write_text(found.unit.text.replace("Restart=on-failure", "Restart=on-tuesdays"))
    verified = subprocess.run(["systemd-analyze", "verify", str(unit)], capture_output=True, text=True, check=False)
    assert "on-tuesdays" in verified.stderr  # it does look


def test_a_dry_run_prints_both_and_writes_nothing(robotwalk: Run) -> None:
    result = robotwalk("service", "install", "--dry-run", "hexapod", "--user", "pi", "--json")
    assert result.code == 0
    unit, rule = result.json["files"]
    assert not result.json["written"]
    assert result.json["unknown_ports"] == ["/dev/ttyUSB0"]
    assert " teleop hexapod --real --seated --input socket --listen 127.0.0.1:8765\n" in unit["text"]
    assert "User=pi\n" in unit["text"]
    assert not Path(unit["path"]).exists()
    assert not Path(rule["path"]).exists()
    assert robotwalk("service", "install", "--dry-run", "hexapud").code == 2
    assert "robotwalk-hexapod.service" in robotwalk("service", "install", "--dry-run").out
    nameless = robotwalk("service", "install")
    assert (nameless.code, "name the robot" in nameless.err) == (2, True)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write")
def test_writing_takes_root(robotwalk: Run) -> None:
    result = robotwalk("service", "install", "hexapod")
    assert result.code == 2
    assert "--dry-run" in result.err
