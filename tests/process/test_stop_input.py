"""A stop button between processes: it is believed once it has settled, and its reader's silence is a stop."""

import os
import threading
import time

import pytest

from robotwalk.clock import WallClock
from robotwalk.process.mailbox import Slot
from robotwalk.process.shared import Stop
from robotwalk.process.stop_input import Settled, StopWatch, serve

MS = 1_000_000


class Button:
    reading: str | None = None

    def read(self) -> str | None:
        return self.reading

    def close(self) -> None:
        pass


def test_a_reading_counts_once_it_has_settled_either_way() -> None:
    button = Button()
    settled = Settled(button, 20 * MS)
    for now, reading, believed in [
        (0, None, None), (5, "open", None), (10, None, None), (15, "open", None), (20, "open", None),
        (30, "gone", None), (35, "open", "open"), (40, None, "open"), (45, "open", "open"), (50, None, "open"),
        (70, None, None),
    ]:
        button.reading = reading
        assert settled.read(now * MS) == believed, now
    button.reading = "open"
    assert settled.read(900 * MS) is None, "one reading is none, however late it is"


@pytest.mark.parametrize("stop", [Stop.HOLD, Stop.LIMP])
def test_what_is_read_is_heeded_and_a_reader_that_is_gone_is_a_stop(stop: Stop) -> None:
    button, slot = Button(), Slot(memoryview(bytearray(512)))
    end, lease = os.pipe()
    reader = threading.Thread(target=serve, args=(Settled(button, 0), slot, WallClock(), end))
    reader.start()
    watch = StopWatch(slot, stop)
    none = StopWatch(slot, None)

    def await_reason(wanted: str | None) -> None:
        deadline = time.monotonic() + 30.0
        while True:
            heeded = watch.look()
            assert none.look() is None
            if (heeded and heeded.reason) == (wanted and f"told to stop by the stop input ({wanted})"):
                assert heeded is None or heeded.stop is stop
                return
            assert time.monotonic() < deadline
            time.sleep(0.005)

    await_reason(None)
    button.reading = "its line DSR is off"
    await_reason("its line DSR is off")
    button.reading = None
    await_reason(None)
    os.close(lease)
    reader.join(30)
    assert not reader.is_alive()
    await_reason("nothing is heard of it")
    os.close(end)
