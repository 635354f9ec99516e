"""What a thread needs to keep deadlines on Linux: to run first, to be woken on time, by a processor that is awake."""

import contextlib
import ctypes
import os
import resource
import signal
import socket
from collections.abc import Iterator

LOOP_PRIORITY = 10  # of 99: above all that is ordinary, below what the kernel itself needs
DEVICE_PRIORITY = 5  # of a simulated robot that must answer in time, on the computer of its loop
_PR_SET_TIMERSLACK = 29  # linux/prctl.h
_PR_SET_PDEATHSIG = 1
_PR_SET_NAME = 15
_MCL_CURRENT, _MCL_FUTURE = 1, 2  # sys/mman.h
_LATENCY = "/dev/cpu_dma_latency"
ISOLATED = "/sys/devices/system/cpu/isolated"
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4  # malloc.h
_SPARE = 4 << 20  # bytes in advance; a tick makes some ten thousand of them
_ARENA = 1 << 20  # bytes that Python asks for at once
_SMALL = 400  # bytes of an object for which it does so
_kept: list[bytes] = []
_claims: list[socket.socket] = []  # held until this process ends


def sharpen_timers() -> None:
    """Have this thread's sleeps end within microseconds; Linux otherwise lets them end 50 us late."""
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1))


def raise_priority(priority: int = LOOP_PRIORITY) -> bool:
    """Have this process run before ordinary ones; return whether it has the right to."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    return True


def own_processor() -> int:
    """Return the processor that a loop would take now."""
    claimed = _claimed()
    if claimed is None:
        return _choices()[0]
    processor, claim = claimed
    claim.close()
    return processor


def pin() -> bool:
    """Keep this process on a processor that no other loop has; return whether there was one, else it shares."""
    claimed = _claimed()
    if claimed is None:
        processor = _choices()[0]
    else:
        processor, claim = claimed
        _claims.append(claim)
    with contextlib.suppress(OSError):  # isolated ones may be for others alone
        os.sched_setaffinity(0, {processor})
    return claimed is not None


def _choices() -> list[int]:
    """Return the processors for loops, the best first: the last ones, for the first ones get most interrupts.

    Isolated ones, on which Linux runs nothing of its own accord, come before all others.
    """
    try:
        with open(ISOLATED) as file:
            isolated = processors(file.read())
    except OSError:
        isolated = []
    others = set(os.sched_getaffinity(0)).difference(isolated)
    return [*sorted(isolated, reverse=True), *sorted(others, reverse=True)]


def _claimed() -> tuple[int, socket.socket] | None:
    """Return the best processor that no loop of anybody has claimed, and the claim: it ends when that is closed.

    A claim is an abstract unix socket, of which there is one of a name in a computer, or in a container.
    """
    for processor in _choices():
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            claim.bind(f"\0robotwalk-processor-{processor}")
        except OSError:
            claim.close()
        else:
            return processor, claim
    return None


def processors(text: str) -> list[int]:
    """Return the numbers of processors that Linux lists, as in 0-3,7."""
    numbers: list[int] = []
    for part in filter(None, text.strip().split(",")):
        first, _, last = part.partition("-")
        numbers.extend(range(int(first), int(last or first) + 1))
    return numbers


def lock_memory() -> bool:
    """Keep all memory of this process from being paged out, now and later; return whether there is the right to.

    Not under a limit: an allocation beyond it would fail.
    """
    unlimited = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY
    if not (unlimited or os.geteuid() == 0):
        return False
    return bool(ctypes.CDLL(None).mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0)


def keep_memory() -> None:
    """Have this process give no memory back, and get some in advance: each page that it asks for anew is a fault.

    Python asks for a megabyte at a time and gives it back once it is empty, perhaps in every tick. With locked memory
    one such turn took 0.4 ms here (a virtual machine; 16 ms at the 99th percentile while it was busy). For malloc the
    real-time Linux wiki tells what keeps it from that; in each of Python's own arenas an object is kept.
    """
    libc = ctypes.CDLL(None)
    libc.mallopt(_M_TRIM_THRESHOLD, -1)
    libc.mallopt(_M_MMAP_MAX, 0)
    _kept.extend([bytes(_SMALL) for _ in range(_SPARE // _SMALL)][::_ARENA // _SMALL // 2])


def name_process(name: str) -> None:
    """Call this process `name`, up to 15 characters, for `ps` and `top`."""
    ctypes.CDLL(None).prctl(_PR_SET_NAME, name.encode())


def end_with(parent: int) -> None:
    """Have SIGTERM sent to this process when its parent, of that process id, dies, or at once if it is dead."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, ctypes.c_ulong(signal.SIGTERM))
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)


@contextlib.contextmanager
def processors_awake() -> Iterator[bool]:
    """Keep idle processors out of sleep that they are slow to leave; yield whether there is the right to.

    It costs power, and no process any time. cyclictest does the same.
    Source: Linux, Documentation/power/pm_qos_interface.rst.
    """
    try:
        descriptor = os.open(_LATENCY, os.O_WRONLY | os.O_CLOEXEC)
    except OSError:
        yield False
        return
    try:
        os.write(descriptor, bytes(4))  # us, an int; in force for as long as this is open
        yield True
    finally:
        os.close(descriptor)
