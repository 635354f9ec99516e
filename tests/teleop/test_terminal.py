"""A terminal is left as it was found, whatever it sends late."""

import os
import select
import termios
import time

import pytest

from robotwalk.errors import UsageError
from robotwalk.teleop.keystrokes import Event, Stroke
from robotwalk.teleop.terminal import Terminal

from .rig import Kitty, await_that


def test_releases_are_told_and_late_ones_do_not_reach_the_shell() -> None:
    kitty = Kitty()
    before = termios.tcgetattr(kitty.slave)
    terminal = Terminal(kitty.slave)
    await_that(lambda: terminal.read(time.monotonic()) and terminal.tells_releases, "it knows the protocol")
    await_that(lambda: b"\x1b[>11u" in kitty.seen, "it asks for releases")
    kitty.key(100, modifiers=5)
    strokes: list[object] = []
    await_that(lambda: strokes.extend(terminal.read(time.monotonic())) or strokes, "Ctrl-D is heard")
    assert strokes == [Stroke("d", ctrl=True, event=Event.PRESSED)]
    kitty.key(100, 3, modifiers=5)  # would log a shell out
    terminal.close()
    assert b"\x1b[<u" in kitty.seen, "the mode is given back"
    assert termios.tcgetattr(kitty.slave) == before
    assert not select.select([kitty.slave], [], [], 0.3)[0], "nothing is left to be read"
    kitty.hang_up()


def test_a_terminal_without_the_protocol_is_not_told_of_it() -> None:
    master, slave = os.openpty()
    terminal = Terminal(slave)
    assert os.read(master, 100) == b"\x1b[?u\x1b[c"
    os.write(master, b"\x1b[?1;2ci")  # as tmux answers
    said: list[object] = []
    await_that(lambda: said.extend(terminal.read(time.monotonic())) or Stroke("i") in said, "the key is heard")
    assert not terminal.tells_releases
    terminal.close()
    assert not select.select([master], [], [], 0.1)[0]
    os.close(master)
    os.close(slave)


def test_a_pipe_is_refused() -> None:
    read, write = os.pipe()
    with pytest.raises(UsageError, match="no terminal"):
        Terminal(read)
    os.close(read)
    os.close(write)
