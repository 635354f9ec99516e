"""rustypot, on a pseudo terminal in real time, on every model: all instructions that it has, and errors."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

from .reference_list import ALERT, AX, MX, SCS, STS, X_SERIES

rustypot = pytest.importorskip("rustypot", reason="rustypot is not installed")
BAUD = 1_000_000
AWAY = 0.35  # s, silent after a restart, and some patience


def client(kind: str, folder: Path, name: str) -> Any:
    return closing(getattr(rustypot, f"{kind}PyController")(str(folder / name), BAUD, 0.3))


def eventually(seen: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 5.0
    while not seen():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def dynamixel(name: str, folder: Path) -> None:
    fast = name in X_SERIES
    with client("Xl330" if "330" in name else "Xl430", folder, name) as bus:
        eventually(lambda: bool(bus.broadcast_scan().keys() == {1, 2}))
        eventually(lambda: bool(bus.scan([1, 2, 3]).keys() == {1, 2}))  # its patience is small, and a computer busy
        write = bus.write_raw_data_with_error
        assert write(1, 65, [1]) == 0
        assert list(bus.read_raw_data(1, 65, 1)) == [1]
        assert write(1, 146, [1]) == 7, "read-only"
        assert write(1, 11, [2]) == 4, "no such mode"
        assert write(1, 116, [0, 8]) == 5, "half a register"
        assert write(1, 116, [0, 0x20, 0, 0]) == 6, "beyond the limits"
        bus.sync_write_raw_data([1, 2], 84, [[1, 2], [3, 4]])
        bus.set_fast_sync_read(False)
        assert [*map(list, bus.sync_read_raw_data([2, 1], 84, 2))] == [[3, 4], [1, 2]]
        if fast:
            bus.set_fast_sync_read(True)
            assert bus.sync_read_present_position([1, 2]) == pytest.approx(bus.sync_read_present_position([2, 1]))
            assert [round(x) for x in bus.sync_read_position_p_gain([1, 2])] == [0x201, 0x403]
        assert write(1, 31, [10]) == 0, "a temperature limit below the room's"
        eventually(lambda: bool(bus.read_raw_data_with_error(1, 70, 1) == ([4], ALERT)))
        assert bus.reboot(1)
        assert not bus.ping(1), "it is away"
        time.sleep(AWAY)
        eventually(lambda: bool(bus.read_raw_data_with_error(1, 84, 2)[1] == ALERT))
        bus.factory_reset(2, True, True)
        time.sleep(AWAY)
        assert list(bus.read_raw_data(2, 84, 2)) != [3, 4]


def ax(name: str, folder: Path) -> None:
    with client("Ax", folder, name) as bus:
        assert bus.ping(1)
        eventually(lambda: bool(bus.scan([1, 2, 3]).keys() == {1, 2}))
        write = bus.write_raw_data_with_error
        assert write(1, 25, [1]) == 0
        assert list(bus.read_raw_data(1, 25, 1)) == [1]
        assert write(1, 6, [100, 0]) == 0
        assert write(1, 30, [99, 0]) == 0x02, "angle limit"
        assert write(1, 36, [0, 0]) == 0x08, "range"
        bus.sync_write_raw_data([1, 2], 25, [[0], [1]])
        assert [list(bus.read_raw_data(i, 25, 1)) for i in (1, 2)] == [[0], [1]]
        with suppress(RuntimeError):
            bus.reboot(1)  # which an AX does not know: an instruction error, that rustypot keeps to itself
        assert write(1, 11, [10]) == 0
        eventually(lambda: bool(bus.read_raw_data_with_error(1, 36, 2)[1] == 0x04))
        assert write(1, 11, [70]) in {0, 4}
        assert write(1, 12, [140]) in {0, 4}
        eventually(lambda: bool(bus.read_raw_data_with_error(1, 36, 2)[1] == 0x01))


def feetech(name: str, folder: Path) -> None:
    sts = name in STS
    with client("Sts3215" if sts else "Scs0009", folder, name) as bus:
        assert bus.ping(1)
        eventually(lambda: bool(bus.scan([1, 2, 3]).keys() == {1, 2}))
        write = bus.write_raw_data_with_error
        assert write(1, 42, [1, 2]) == 0
        assert list(bus.read_raw_data(1, 42, 2)) == [1, 2]
        bus.sync_write_raw_data([1, 2], 42, [[2, 1], [1, 1]])
        assert list(bus.read_raw_data(1, 42, 2)) == [2, 1]
        if sts:
            assert [*map(list, bus.sync_read_raw_data([2, 1], 42, 2))] == [[1, 1], [2, 1]]
        assert not bus.reboot(1), "not known"
        assert write(1, 13, [10]) == 0
        eventually(lambda: bool(bus.read_raw_data_with_error(1, 65, 1) == ([4], 4)))
        assert write(1, 13, [70]) in {0, 4}
        assert write(1, 14, [20]) in {0, 4}
        eventually(lambda: bool(bus.read_raw_data_with_error(1, 65, 1) == ([1], 1)))


PARTS = {**dict.fromkeys(X_SERIES + MX, dynamixel), **dict.fromkeys(AX, ax), **dict.fromkeys(STS + SCS, feetech)}
_TABLE = {0x01, 0x02, 0x03, 0x83}
INSTRUCTIONS = {
    **dict.fromkeys(X_SERIES, _TABLE | {0x06, 0x08, 0x82, 0x8A}), **dict.fromkeys(MX, _TABLE | {0x06, 0x08, 0x82}),
    **dict.fromkeys(AX + SCS, _TABLE), **dict.fromkeys(STS, _TABLE | {0x82})}
_NUMBERS, _BITS_1, _BITS = {4, 5, 6, 7, ALERT}, {0x01, 0x02, 0x04, 0x08, 0x40}, {0x01, 0x04}
ERRORS = {
    **dict.fromkeys(X_SERIES + MX, _NUMBERS), **dict.fromkeys(AX, _BITS_1), **dict.fromkeys(STS + SCS, _BITS)}


def test_all_that_it_has_on_every_model(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tests.contract.tour_server", str(tmp_path), *PARTS]
    root = Path(__file__).parents[2]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=root) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        try:
            assert server.stdout.readline() == "ready\n"
            for name, part in PARTS.items():
                part(name, tmp_path)
        finally:
            server.stdin.close()
        witnessed = json.loads(server.stdout.read())
    for name, (instructions, errors) in witnessed.items():
        assert set(instructions) == INSTRUCTIONS[name], name
        assert set(errors) == ERRORS[name], name
