"""A log whose records come from another process says so where some of them found no room."""

from pathlib import Path

from robotwalk.process.log_feed import LogFeed, emptier
from robotwalk.process.mailbox import Ring
from robotwalk.recorder import Recorder
from robotwalk.tape import Call


def test_what_found_no_room_on_its_way_to_the_log_is_told_at_its_end(tmp_path: Path) -> None:
    ring = Ring(memoryview(bytearray(64 + 1024)))
    incomplete = "the log is incomplete: {} of the loop's records found no room on their way to it"
    for ticks, told in ((3, None), (100, incomplete)):
        recorder = Recorder(tmp_path / f"{ticks}.mcap", ("lf_coxa",), {})
        feed, empty = LogFeed(ring), emptier(ring, recorder)
        for _ in range(ticks):
            feed.tape.call("tick")  # which hands over the tick before
            feed.tape.add(Call("beat"))
        empty()
        assert recorder.close() == (told and told.format(ring.dropped))
    assert ring.dropped > 50
