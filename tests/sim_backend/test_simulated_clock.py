"""Simulated time passes only while somebody waits, and in order."""

from sim_backend.simulated_clock import SimulatedClock


class Mailbox:
    """A port that holds what events put into it."""

    def __init__(self) -> None:
        self.bytes = b""

    def fileno(self) -> int:
        return -1

    def write(self, data: bytes) -> None:
        self.bytes += data

    def waiting(self) -> int:
        return len(self.bytes)

    def read(self) -> bytes:
        data, self.bytes = self.bytes, b""
        return data

    def close(self) -> None:
        pass


def test_waiting_moves_time_to_the_deadline_and_no_further() -> None:
    clock = SimulatedClock()
    assert clock.now() == 0
    clock.wait((), 1_000)
    assert clock.now() == 1_000
    clock.wait((), 500)
    assert clock.now() == 1_000, "time does not go back"


def test_events_run_in_the_order_of_their_times_and_then_of_their_scheduling() -> None:
    clock = SimulatedClock()
    seen: list[tuple[str, int]] = []
    for name, when in (("c", 30), ("a", 10), ("b", 20), ("b2", 20)):
        clock.schedule(when, lambda name=name: seen.append((name, clock.now())))
    clock.wait((), 25)
    assert seen == [("a", 10), ("b", 20), ("b2", 20)]
    clock.wait((), 30)
    assert seen[-1] == ("c", 30)


def test_an_event_may_schedule_others_and_one_in_the_past_runs_now() -> None:
    clock = SimulatedClock()
    seen: list[int] = []
    clock.schedule(10, lambda: clock.schedule(3, lambda: seen.append(clock.now())))
    clock.wait((), 100)
    assert seen == [10]


def test_bytes_end_the_wait_early() -> None:
    clock, port = SimulatedClock(), Mailbox()
    clock.schedule(40, lambda: port.write(b"x"))
    clock.schedule(50, lambda: port.write(b"y"))
    clock.wait((Mailbox(), port), 1_000)
    assert clock.now() == 40
    clock.wait((port,), 1_000)
    assert clock.now() == 40, "they are still unread"
    assert port.read() == b"x"
    clock.wait((port,), 1_000)
    assert (clock.now(), port.read()) == (50, b"y")
