"""The page about foot switches: its section is understood, its sketch sends what the driver hears."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from hal.foot_switches.frame import FRAMING, decode
from hal.foot_switches.model import FootSwitchConfig
from hal.unasked_frames import FrameReceiver
from robotwalk import assembly
from robotwalk.config import library

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "foot-switches.md").read_text()
# An Arduino of which pins 2 and 3 are pulled low in the loops that a line of stdin names.
ARDUINO = """
#include <cstdio>
typedef unsigned char byte;
enum { INPUT_PULLUP, LOW = 0 };
int level[20];
struct { void begin(long) {} void write(byte *data, int size) { fwrite(data, 1, size, stdout); } } Serial;
void pinMode(int, int) {}
int digitalRead(int pin) { return level[pin]; }
void delay(int) {}
"""
MAIN = """
int main() {
  setup();
  for (int i = 0; i < 20; i++) level[i] = 1;
  while (scanf("%d %d", &level[2], &level[3]) == 2) loop();
}
"""


def test_its_section_is_understood_and_its_table_is_whole(tmp_path: Path) -> None:
    (section,) = re.findall(r"```yaml\nhardware:\n(.*?)```", PAGE, re.DOTALL)
    robot = tmp_path / "my_robot.yaml"
    robot.write_text(library.open_document("robots", "hexapod").text.replace("hardware:\n", f"hardware:\n{section}"))
    config = assembly.load(str(robot)).hardware.foot_switches
    assert config is not None
    rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]*) \|", PAGE.partition("\n## What")[0], re.MULTILINE))
    assert set(rows) == set(FootSwitchConfig.model_fields)
    for key in ("baud", "rate_hz", "stale_after_s", "closes_at_n"):
        assert float(rows[key]) == getattr(config, key)


def test_the_example_frame_says_what_the_page_says() -> None:
    (example, inputs) = re.findall(r"`(46 53 \w\w \w\w \w\w)` says that inputs ([\d, and]+) are", PAGE)[0]
    (frame,) = FrameReceiver(FRAMING).take(bytes.fromhex(example))
    assert decode(frame) == sum(1 << int(number) for number in re.findall(r"\d+", inputs))


@pytest.mark.skipif(shutil.which("g++") is None, reason="compiles the page's sketch")
def test_the_sketch_sends_what_the_driver_hears(tmp_path: Path) -> None:
    (sketch,) = re.findall(r"```cpp\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "sketch.cpp").write_text(ARDUINO + sketch + MAIN)
    subprocess.run(["g++", "-std=c++11", "-o", tmp_path / "sketch", tmp_path / "sketch.cpp"], check=True)
    pins = ["1 1", "0 1", "0 1", "1 1", "0 0", "0 0", "1 0", "1 0"]  # pin 2 bounces once
    done = subprocess.run([tmp_path / "sketch"], input="\n".join(pins).encode(), capture_output=True, check=True)
    receiver = FrameReceiver(FRAMING)
    assert [decode(frame) for frame in receiver.take(done.stdout)] == [0, 0, 1, 1, 1, 3, 3, 2]
    assert receiver.stray_bytes == 0
