"""What is looked at. Each check returns what it found, why that matters, and what mends it."""

import platform
import sys
from collections.abc import Iterator, Mapping
from enum import Enum
from typing import NamedTuple

from robotwalk.doctor.computer import IPC_LOCK, SYS_NICE, Computer
from robotwalk.doctor.remedy import Remedy, writing
from robotwalk.doctor.rights import AWAKE, FIRST, GROUP, MEMORY, Right
from robotwalk.realtime import ISOLATED, LOOP_PRIORITY, processors

_GOVERNORS = "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"
_CLOCK = "/sys/devices/system/clocksource/clocksource0"
_QUICK_CLOCKS = ("tsc", "arch_sys_counter", "kvm-clock", "hyperv_clocksource_tsc_page")  # read without a system call
_ADAPTERS = "/sys/bus/usb-serial/devices/*/latency_timer"
_PORTS = ("/dev/ttyUSB*", "/dev/ttyACM*", "/dev/ttyAMA*")
_PIP = f"{sys.executable} -m pip"
_FEETECH = ("feetech-servo-sdk", "ftservo-python-sdk")
_WORST_MUJOCO = "4.0.0"
_MANY_CORES = 4  # of which one can be spared
_PI_BOOT = "/boot/firmware/cmdline.txt"


class Level(Enum):
    """How much a finding matters."""

    FINE = "fine"
    ADVICE = "advice"  # a robot walks without, later or less steadily
    PROBLEM = "problem"  # something will not work


class Finding(NamedTuple):
    """What a check found."""

    check: str
    level: Level
    text: str
    why: str
    remedy: Remedy | None = None


def diagnose(computer: Computer, packages: Mapping[str, str]) -> list[Finding]:
    """Look at a computer, and at the versions of the Python packages on it."""
    return [
        _kernel(computer), _governor(computer), *_rights(computer), _cores(computer), _clock(computer),
        *_latency_timers(computer), *_ports(computer), *_grabbers(computer), _feetech(packages), _mujoco(packages)]


def _kernel(computer: Computer) -> Finding:
    why = "an ordinary kernel may wake the loop milliseconds late"
    release = computer.text("/proc/sys/kernel/osrelease") or "unknown"
    if computer.text("/sys/kernel/realtime") == "1":
        return Finding("kernel", Level.FINE, f"{release}, PREEMPT_RT", why)
    system = _facts(computer.text("/etc/os-release") or "").get("ID")
    command = None
    if system == "debian" and computer.text("/proc/device-tree/model") is None:  # not a Raspberry Pi's Debian
        architecture = {"x86_64": "amd64", "aarch64": "arm64"}.get(platform.machine(), platform.machine())
        command = f"sudo apt install linux-image-rt-{architecture}"
    elif system == "ubuntu":
        command = "sudo pro enable realtime-kernel"
    remedy = Remedy(command, then="from the next boot on") if command else None
    return Finding("kernel", Level.ADVICE, f"{release}, without PREEMPT_RT", why, remedy)


def _facts(text: str) -> dict[str, str]:
    rows = (line.partition("=") for line in text.splitlines())
    return {name: value.strip('"') for name, _, value in rows}


def _governor(computer: Computer) -> Finding:
    why = "a processor that was slowed down takes milliseconds to be quick again"
    governors = computer.texts(_GOVERNORS)
    if not governors:
        return Finding("governor", Level.FINE, "this computer does not let Linux change its frequency", why)
    slow = [path for path, governor in governors.items() if governor != "performance"]
    found = ", ".join(sorted(set(governors.values())))
    if not slow:
        return Finding("governor", Level.FINE, found, why)
    return Finding("governor", Level.ADVICE, found, why, writing("performance", slow, "until the next boot"))


def _rights(computer: Computer) -> Iterator[Finding]:
    first = computer.may(SYS_NICE) or computer.limit("Max realtime priority") >= LOOP_PRIORITY
    memory = computer.may(IPC_LOCK) or computer.limit("Max locked memory") == float("inf")
    yield _right(computer, "priority", FIRST, first)
    yield _right(computer, "memory", MEMORY, memory)
    if computer.paths("/dev/cpu_dma_latency"):
        yield _right(computer, "sleep", AWAKE, computer.usable("/dev/cpu_dma_latency"))


def _right(computer: Computer, check: str, right: Right, had: bool) -> Finding:
    if computer.asked_for is not None:  # this process is root, and has them all; what grants them to others?
        had = all(computer.text(write.path) == write.text for write in right.remedy.writes)
    if had:
        return Finding(check, Level.FINE, f"there is the right to {right.name}", right.why)
    return Finding(check, Level.ADVICE, f"no right to {right.name}", right.why, right.remedy)


def _cores(computer: Computer) -> Finding:
    why = "the loop wants a processor of its own"
    online = processors(computer.text("/sys/devices/system/cpu/online") or "0")
    isolated = processors(computer.text(ISOLATED) or "")
    text = f"{len(online)} processor(s), isolated: {', '.join(map(str, isolated)) or 'none'}"
    enough = len(online) > 1 and (isolated or len(online) < _MANY_CORES)
    return Finding(
        "cores", Level.FINE if enough else Level.ADVICE, text, why,
        None if enough or len(online) == 1 else _isolating(computer, max(online)))


def _isolating(computer: Computer, processor: int) -> Remedy | None:
    """Return what keeps Linux from running others on a processor. It changes how the computer boots: people decide."""
    option, then = f"isolcpus={processor}", "from the next boot on"
    if computer.paths(_PI_BOOT):
        return Remedy(f"sudo sed -i '1s/$/ {option}/' {_PI_BOOT}", then=then)
    if not computer.paths("/etc/default/grub"):
        return None
    line = f'GRUB_CMDLINE_LINUX_DEFAULT="$GRUB_CMDLINE_LINUX_DEFAULT {option}"'
    written = writing(line, ["/etc/default/grub.d/robotwalk.cfg"])
    return Remedy(f"{written.command} && sudo update-grub", then=then)


def _clock(computer: Computer) -> Finding:
    why = "each look at another clock costs a microsecond or more"
    current = computer.text(f"{_CLOCK}/current_clocksource") or "unknown"
    if current in _QUICK_CLOCKS:
        return Finding("clock", Level.FINE, current, why)
    available = (computer.text(f"{_CLOCK}/available_clocksource") or "").split()
    better = next((clock for clock in _QUICK_CLOCKS if clock in available), None)
    # Linux has left that clock for a reason, perhaps: people decide.
    remedy = better and writing(better, [f"{_CLOCK}/current_clocksource"], "until the next boot")._replace(writes=())
    return Finding("clock", Level.ADVICE, current, why, remedy or None)


def _latency_timers(computer: Computer) -> Iterator[Finding]:
    why = "an FTDI adapter keeps the end of a reply for so long: 1 ms is its least"
    for path, milliseconds in computer.texts(_ADAPTERS).items():
        adapter = path.split("/")[-2]
        text = f"{adapter} waits {milliseconds} ms"
        if milliseconds == "1":
            yield Finding("latency", Level.FINE, text, why)
        else:
            yield Finding("latency", Level.PROBLEM, text, why, writing("1", [path], "until it is plugged in again"))


def _ports(computer: Computer) -> Iterator[Finding]:
    why = "a port that this user may not open is a bus without servos"
    ports = [path for pattern in _PORTS for path in computer.paths(pattern)]
    if not ports:
        yield Finding("port", Level.FINE, "no serial adapter is plugged in", why)
    for path in ports:
        if computer.usable(path):
            yield Finding("port", Level.FINE, f"{path} may be used", why)
            continue
        group = computer.group_of(path)
        remedy = Remedy(f"sudo usermod -aG {group} $USER", then="who logs in again")
        if group == "root":
            remedy = writing(
                f'SUBSYSTEM=="tty", KERNEL=="{path.removeprefix("/dev/")}", GROUP="{GROUP}", MODE="0660"',
                ["/etc/udev/rules.d/70-robotwalk-port.rules"], "when it is plugged in again")
        yield Finding("port", Level.PROBLEM, f"{path} is for members of {group} alone", why, remedy)


def _grabbers(computer: Computer) -> Iterator[Finding]:
    """Look for a daemon that talks to whatever is plugged in."""
    if "ModemManager" in computer.texts("/proc/[0-9]*/comm").values():
        yield Finding(
            "modem", Level.PROBLEM, "ModemManager runs", "it takes adapters for modems, and servos hear what it says",
            Remedy("sudo systemctl disable --now ModemManager"))


def _feetech(packages: Mapping[str, str]) -> Finding:
    why = "both install the module scservo_sdk, and which one is there is a matter of luck"
    ours, theirs = _FEETECH
    if not all(name in packages for name in _FEETECH):
        return Finding("feetech", Level.FINE, f"{ours} {packages.get(ours, 'is not installed')}", why)
    return Finding(
        "feetech", Level.PROBLEM, f"{ours} and {theirs} overwrite each other", why,
        Remedy(f"{_PIP} uninstall -y {theirs} && {_PIP} install --force-reinstall --no-deps {ours}"))


def _mujoco(packages: Mapping[str, str]) -> Finding:
    why = "the solver of 4.0.0 is wrong where contacts are many (mujoco#3767)"
    version = packages.get("mujoco")
    if version != _WORST_MUJOCO:
        return Finding("mujoco", Level.FINE, version or "not installed: no simulation", why)
    return Finding("mujoco", Level.PROBLEM, version, why, Remedy(f"{_PIP} install 'mujoco!={_WORST_MUJOCO}'"))
