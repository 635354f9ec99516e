"""Real signals, sent to this very process."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from robotwalk.interrupts import Interrupts

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture
def interrupts() -> Iterator[Interrupts]:
    before = [signal.getsignal(number) for number in SIGNALS]
    made = Interrupts()
    made.install()
    yield made
    for number, handler in zip(SIGNALS, before, strict=True):
        signal.signal(number, handler)


def send(*numbers: int) -> None:
    for number in numbers:
        os.kill(os.getpid(), number)


def test_nothing_came(interrupts: Interrupts) -> None:
    interrupts.check()


def test_a_signal_waits_for_the_end_of_the_tick(interrupts: Interrupts) -> None:
    send(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        interrupts.check()
    interrupts.check()  # and is raised once


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_exit_codes_are_those_of_shells(interrupts: Interrupts, number: int, code: int) -> None:
    send(number)
    with pytest.raises(SystemExit) as stop:
        interrupts.check()
    assert stop.value.code == code


def test_each_of_several_is_raised_in_its_turn(interrupts: Interrupts) -> None:
    send(signal.SIGTERM, signal.SIGINT)
    with pytest.raises(SystemExit):
        interrupts.check()
    with pytest.raises(KeyboardInterrupt):
        interrupts.check()
    interrupts.check()


def test_on_the_way_down_only_a_new_ctrl_c_counts_but_all_that_come_while_the_robot_is_held(
    interrupts: Interrupts
) -> None:
    send(signal.SIGINT, signal.SIGHUP)
    interrupts.heed_only_ctrl_c()
    with pytest.raises(SystemExit) as stop:
        interrupts.check(held=True)  # as it was already when that came
    assert stop.value.code == 129
    send(signal.SIGTERM)
    interrupts.check()
    interrupts.check(held=True)  # what came before is past
    send(signal.SIGTERM, signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        interrupts.check()


def test_the_signals_are_given_back(interrupts: Interrupts) -> None:
    interrupts.restore()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    with pytest.raises(KeyboardInterrupt):
        send(signal.SIGINT)
    interrupts.check()
    interrupts.restore()  # may be called twice


def test_other_threads_leave_the_signals_alone() -> None:
    before = [signal.getsignal(number) for number in SIGNALS]
    made = Interrupts()
    done = []
    thread = threading.Thread(target=lambda: done.append((made.install(), made.check(), made.restore())))
    thread.start()
    thread.join()
    assert done
    assert [signal.getsignal(number) for number in SIGNALS] == before


def test_a_process_ends_with_the_signals_code() -> None:
    code = (
        "import os, signal\n"
        "from robotwalk.interrupts import Interrupts\n"
        "interrupts = Interrupts()\n"
        "interrupts.install()\n"
        "os.kill(os.getpid(), signal.SIGTERM)\n"
        "print('finished the tick', flush=True)\n"
        "interrupts.check()\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=False)
    assert (run.returncode, run.stdout) == (143, "finished the tick\n")
