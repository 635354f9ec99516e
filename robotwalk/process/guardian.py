"""Who stands behind the loop: its parent, which opened the ports, takes the robot over when the loop is gone.

A thread of the driver's process, for it must watch while the driver computes. It shows the loop that the process lives,
and looks for the loop's own sign of life. Where that fails the loop is killed, so that nobody else talks on the wires;
then the robot is held, lowered, and its torque switched off (`robotwalk.process.rescue`).
"""

import contextlib
import os
import select
import signal
import subprocess
import threading
import time
from collections.abc import Callable

from robotwalk.process.mailbox import unpacked
from robotwalk.process.shared import Mailbox

_LOOK = 0.02  # s between looks
_SILENT = 300_000_000  # ns without a sign of life
_AGREEING = 5  # looks in a row that must find it silent: whole computers stall, and all in them


class Guardian:
    """Watches one loop.

    Attributes:
        reason: why it took over, in words; None: it did not.
        doubtful: joints at which torque may still be on after that.
    """

    def __init__(
        self, process: subprocess.Popen[bytes], mailbox: Mailbox, rescue: Callable[[], list[str]],
        empty: Callable[[], None],
    ) -> None:
        """Watch from now on.

        Args:
            process: the loop's.
            mailbox: shared with it.
            rescue: brings the robot down, returns the joints at which torque may still be on. Never raises.
            empty: takes what the loop has sent for the log.
        """
        self.reason: str | None = None
        self.doubtful: list[str] = []
        self._process, self._mailbox = process, mailbox
        self._rescue, self._empty = rescue, empty
        self._stop = threading.Event()
        self._over = threading.Event()
        self._silent_looks = 0
        self._death = os.pidfd_open(process.pid)
        self._thread = threading.Thread(target=self._watch, name="robotwalk-guardian", daemon=True)
        self._thread.start()

    def stand_down(self) -> None:
        """Watch no more: the loop has ended in good order."""
        self._stop.set()
        self._thread.join()

    def wait(self) -> None:
        """Return once the robot is down."""
        self._over.wait()

    def _watch(self) -> None:
        while not self._stop.is_set():
            self._mailbox.guardian.write(b"")
            self._empty()
            select.select([self._death], [], [], _LOOK)
            reason = self._judge()
            if reason is not None:
                self._take_over(reason)
                break
        self._empty()
        os.close(self._death)

    def _judge(self) -> str | None:
        """Return why the loop is no good any more, if that is so."""
        code = self._process.poll()
        if code is not None:
            message = self._mailbox.status.read()
            if message is not None and unpacked(message.data).ended is not None:
                self._stop.set()
                return None
            return f"the loop's process {_death(code)}"
        silent = time.monotonic_ns() - self._mailbox.pulse.time
        known = self._mailbox.status.number > 0  # it takes its time to start
        self._silent_looks = self._silent_looks + 1 if known and silent > _SILENT else 0
        if self._silent_looks >= _AGREEING:
            return f"the loop's process gave no sign of life for {1e-9 * silent:.1f} s"
        return None

    def _take_over(self, reason: str) -> None:
        with contextlib.suppress(OSError):
            self._process.kill()  # a stopped one, too
        self._process.wait()
        if self._mailbox.pulse.armed:
            self.reason = f"{reason}: the robot was held where it was, then lowered"
            self.doubtful = self._rescue()
        else:
            self.reason = reason
        self._over.set()


def _death(code: int) -> str:
    """Return how a process ended, in words."""
    return f"was killed ({signal.Signals(-code).name})" if code < 0 else f"ended by itself with code {code}"
