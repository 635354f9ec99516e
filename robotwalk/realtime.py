"""What a thread needs to keep deadlines on Linux: to run first, to be woken on time, by a processor that is awake."""

import contextlib
import ctypes
import os
from collections.abc import Iterator

LOOP_PRIORITY = 10  # of 99: above all that is ordinary, below what the kernel itself needs
_PR_SET_TIMERSLACK = 29  # linux/prctl.h
_LATENCY = "/dev/cpu_dma_latency"


def sharpen_timers() -> None:
    """Have this thread's sleeps end within microseconds; Linux otherwise lets them end 50 us late."""
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1))


def raise_priority() -> bool:
    """Have this process run before ordinary ones; return whether it has the right to."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LOOP_PRIORITY))
    except OSError:
        return False
    return True


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
