"""What `robotwalk doctor` finds on made-up computers, and on this one."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from robotwalk.cli.doctor import treat
from robotwalk.doctor import rights
from robotwalk.doctor.checks import Finding, Level, diagnose
from robotwalk.doctor.computer import Computer

HEALTHY = {"feetech-servo-sdk": "1.0.0", "mujoco": "3.17.0"}
USER = os.getuid() + 1  # not the owner of what the tests make
PI = {
    "/proc/sys/kernel/osrelease": "6.12.47-v8-rt",
    "/proc/self/status": f"Name:\tpython\nUid:\t{USER}\t{USER}\t{USER}\t{USER}\nGid:\t{USER}\t{USER}\t{USER}\t{USER}\n"
                         f"Groups:\t4 {os.getgid()} \nCapEff:\t0000000000000000",
    "/proc/self/limits": "Limit                     Soft Limit           Hard Limit           Units     \n"
                         "Max locked memory         unlimited            unlimited            bytes     \n"
                         "Max realtime priority     80                   80                             ",
    "/proc/1/comm": "systemd",
    "/proc/device-tree/model": "Raspberry Pi 4 Model B Rev 1.4\0",
    "/sys/kernel/realtime": "1",
    "/sys/devices/system/cpu/online": "0-3",
    "/sys/devices/system/cpu/isolated": "3",
    "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor": "performance",
    "/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor": "performance",
    "/sys/devices/system/clocksource/clocksource0/current_clocksource": "arch_sys_counter",
    "/sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "1",
    "/dev/ttyUSB0": "",
    "/dev/cpu_dma_latency": "",
    "/etc/os-release": 'PRETTY_NAME="Debian GNU/Linux 13 (trixie)"\nID=debian',
    "/etc/passwd": f"root:x:0:0::/root:/bin/sh\npi:x:{USER}:{USER}::/home/pi:/bin/bash",
    "/etc/group": f"dialout:x:{os.getgid()}:pi\npi:x:{USER}:",
    "/etc/security/limits.d/README": "",
    "/etc/udev/rules.d/README": "",
}


def computer(root: Path, changes: Mapping[str, str | None] = {}, asked_for: int | None = None) -> Computer:
    """Make up a computer: the healthy one, but for some files; those that are None are missing."""
    for path, text in {**PI, **changes}.items():
        if text is not None:
            file = root / path[1:]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(f"{text}\n")
            file.chmod(0o660)
    return Computer(root, asked_for)


def ailing(found: list[Finding]) -> list[Finding]:
    return [finding for finding in found if finding.level is not Level.FINE]


def test_a_healthy_computer_is_told_so_and_nothing_is_written_to_it(tmp_path: Path) -> None:
    found = diagnose(computer(tmp_path), HEALTHY)
    assert ailing(found) == []
    assert {finding.check for finding in found} == {
        "kernel", "governor", "priority", "memory", "sleep", "cores", "clock", "latency", "port", "feetech", "mujoco"}
    assert all(finding.text and finding.why for finding in found)
    assert treat(Computer(tmp_path), found) == []


@pytest.mark.parametrize(("changes", "check", "level", "says", "command"), [
    ({"/sys/kernel/realtime": None}, "kernel", "advice", "without PREEMPT_RT", None),
    ({"/sys/kernel/realtime": None, "/proc/device-tree/model": None}, "kernel", "advice", "without PREEMPT_RT",
     "sudo apt install linux-image-rt-"),
    ({"/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor": "ondemand"}, "governor", "advice", "ondemand",
     "printf '%s\\n' performance | sudo tee /sys/devices/system/cpu/cpu1/cpufreq/scaling_governor"),
    ({"/proc/self/limits": "Max realtime priority  9  9\nMax locked memory  unlimited  unlimited  bytes"},
     "priority", "advice", "no right to run first", "/etc/security/limits.d/robotwalk.conf"),
    ({"/proc/self/limits": "Max realtime priority  80  80\nMax locked memory  8388608  8388608  bytes"},
     "memory", "advice", "no right to lock memory", "/etc/security/limits.d/robotwalk.conf"),
    ({"/sys/devices/system/cpu/online": "0"}, "cores", "advice", "1 processor", None),
    ({"/sys/devices/system/cpu/isolated": "", "/boot/firmware/cmdline.txt": "console=tty1"}, "cores", "advice",
     "isolated: none", "sed -i '1s/$/ isolcpus=3/' /boot/firmware/cmdline.txt"),
    ({"/sys/devices/system/cpu/isolated": "", "/etc/default/grub": ""}, "cores", "advice",
     "isolated: none", "isolcpus=3\"' | sudo tee /etc/default/grub.d/robotwalk.cfg && sudo update-grub"),
    ({"/sys/devices/system/clocksource/clocksource0/current_clocksource": "hpet",
      "/sys/devices/system/clocksource/clocksource0/available_clocksource": "hpet tsc acpi_pm"},
     "clock", "advice", "hpet", "tsc | sudo tee"),
    ({"/sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "16"}, "latency", "problem", "ttyUSB0 waits 16 ms",
     "printf '%s\\n' 1 | sudo tee /sys/bus/usb-serial/devices/ttyUSB0/latency_timer"),
    ({"/proc/812/comm": "ModemManager"}, "modem", "problem", "ModemManager runs", "sudo systemctl disable"),
])
def test_each_lack_is_found_alone_with_its_command(
    tmp_path: Path, changes: Mapping[str, str | None], check: str, level: str, says: str, command: str | None
) -> None:
    found = ailing(diagnose(computer(tmp_path, changes), HEALTHY))
    assert [(finding.check, finding.level.value) for finding in found] == [(check, level)]
    assert says in found[0].text
    if command is None:
        assert found[0].remedy is None
    else:
        assert found[0].remedy is not None
        assert command in found[0].remedy.command


def test_a_port_of_others_is_a_problem_and_the_group_is_named(tmp_path: Path) -> None:
    box = computer(tmp_path, {"/proc/self/status": PI["/proc/self/status"].replace(f" {os.getgid()} ", " ")})
    found = {finding.check: finding for finding in ailing(diagnose(box, HEALTHY))}
    assert set(found) == {"port", "sleep"}
    assert found["port"].level is Level.PROBLEM
    assert found["port"].remedy is not None
    assert found["port"].remedy.command == "sudo usermod -aG dialout $USER"
    assert found["port"].remedy.writes == ()  # who is in which group is for people to say


@pytest.mark.parametrize(("packages", "check", "command"), [
    ({**HEALTHY, "ftservo-python-sdk": "2.0.1"}, "feetech", "uninstall -y ftservo-python-sdk"),
    ({**HEALTHY, "mujoco": "4.0.0"}, "mujoco", "install 'mujoco!=4.0.0'"),
])
def test_packages_that_do_not_work(
    tmp_path: Path, packages: Mapping[str, str], check: str, command: str
) -> None:
    (finding,) = ailing(diagnose(computer(tmp_path), packages))
    assert (finding.check, finding.level) == (check, Level.PROBLEM)
    assert finding.remedy is not None
    assert command in finding.remedy.command


ILL = {
    "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor": "powersave",
    "/sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "16",
    "/sys/devices/system/clocksource/clocksource0/current_clocksource": "hpet",
    "/sys/devices/system/clocksource/clocksource0/available_clocksource": "hpet tsc",
    "/proc/812/comm": "ModemManager",
}


def test_fixing_writes_what_it_says_and_nothing_else(tmp_path: Path) -> None:
    """Root mends for the user who said `sudo`, whose rights are not root's."""
    box = computer(tmp_path, ILL, asked_for=USER)
    before = {path: path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    done = treat(box, diagnose(box, HEALTHY))
    assert all(failure is None for _, failure in done)
    written = {write.path: write.text for write, _ in done}
    assert set(written) == {
        "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "/sys/bus/usb-serial/devices/ttyUSB0/latency_timer",
        "/etc/security/limits.d/robotwalk.conf", "/etc/udev/rules.d/70-robotwalk-latency.rules"}
    for path in tmp_path.rglob("*"):
        if path.is_file():
            name = f"/{path.relative_to(tmp_path)}"
            assert path.read_text() == (f"{written[name]}\n" if name in written else before[path])
    # What is left is for people; a second time there is nothing to do.
    left = diagnose(box, HEALTHY)
    assert [finding.check for finding in ailing(left)] == ["clock", "modem"]
    assert treat(box, left) == []


def test_the_command_that_is_shown_writes_what_fixing_writes(tmp_path: Path) -> None:
    for right in (rights.FIRST, rights.MEMORY, rights.AWAKE):
        (write,) = right.remedy.writes
        command = right.remedy.command.replace("sudo ", "").replace(write.path, str(tmp_path / "file"))
        subprocess.run(["/bin/sh", "-c", command], check=True, capture_output=True)
        assert (tmp_path / "file").read_text() == f"{write.text}\n"


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    box = computer(tmp_path, ILL)
    timer = "/sys/bus/usb-serial/devices/ttyUSB0/latency_timer"
    found = [finding for finding in diagnose(box, HEALTHY) if finding.check == "latency"]
    (tmp_path / timer[1:]).unlink()
    (tmp_path / timer[1:]).mkdir()
    ((write, failure),) = treat(box, found)
    assert write.path == timer
    assert failure == "Is a directory"


def test_a_loop_says_what_it_lacks_with_the_doctors_command() -> None:
    assert rights.lacking([]) == []
    first, awake = rights.lacking([rights.FIRST, rights.MEMORY, rights.AWAKE])
    assert "no right to run first (FIFO priority) or to lock memory" in first
    assert rights.FIRST.remedy.command in first
    assert rights.AWAKE.remedy.command in awake


def test_this_computer_is_looked_at() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from robotwalk.cli.main import main; main()", "doctor", "--json"],
        capture_output=True, text=True, check=False)
    report = json.loads(done.stdout)
    assert report["schema"] == 1
    assert done.returncode == (0 if report["ok"] else 1)
    assert report["ok"] == all(finding["level"] != "problem" for finding in report["findings"])
    assert {"kernel", "governor", "priority", "memory", "cores", "clock", "port", "feetech", "mujoco"} <= {
        finding["check"] for finding in report["findings"]}
    assert report["fixes"] == []
