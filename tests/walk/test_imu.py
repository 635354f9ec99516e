"""A robot with an IMU, from MuJoCo's sensors through the bytes of its line to what the controller may read."""

import contextlib
import itertools
import math
import os
import re
import time
from pathlib import Path
from typing import Any

import pytest
import serial

from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.assembly.transcript import of_log
from robotwalk.cli.outing import Outing, Plan
from robotwalk.config import library
from robotwalk.errors import ConfigError
from robotwalk.loop import Tick
from robotwalk.testing import FakeRobot

from ..device import served

STANDING = Plan(speed=0.0, direction=0.0, heading=None, turn=0.0, height=None, duration=0.5, gait=None)


def with_imu(folder: Path, imu: str, locomotion: str = "") -> Path:
    """Write the hexapod's file, an IMU fitted, and return its path."""
    text = library.open_document("robots", "hexapod").text
    text = text.replace("hardware:\n", f"hardware:\n  imu: {{port: /dev/ttyUSB1, {imu}}}\n")
    if locomotion:
        text, count = re.subn(r"^  orientation:.*\n", locomotion, text, flags=re.MULTILINE)
        assert count == 1
    path = folder / "hexapod_imu.yaml"
    path.write_text(text)
    return path


KINDS = {
    "bno085-rvc": "kind: bno085-rvc, baud: 115200, mounting_deg: [180, 0, 90]",
    "wt901": "kind: wt901, baud: 115200, rate_hz: 100, mounting_deg: [10, -20, 135]",
    "wt61": "kind: wt61, baud: 115200",
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_read_is_what_the_body_does_however_the_sensor_is_mounted(kind: str, tmp_path: Path) -> None:
    with FakeRobot(with_imu(tmp_path, KINDS[kind])) as fake:
        errors, rates = [], []

        def watch(tick: Tick) -> None:
            imu = tick.estimate.imu
            if imu is not None:
                assert imu.valid
                assert imu.age <= 0.0101
                base = fake.base
                errors.append(math.degrees(max(abs(imu.roll - base.roll), abs(imu.pitch - base.pitch))))
                if imu.angular_velocity is not None:
                    rates.append(imu.angular_velocity)

        fake.robot.observers.append(watch)
        fake.robot.stand()
        assert fake.robot.state.imu is not None
        assert fake.robot.state.imu.acceleration == pytest.approx((0.0, 0.0, 9.81), abs=0.7)
        rates.clear()
        fake.robot.walk(wz=0.4, seconds=2.0)
        assert len(errors) > 300
        assert 0.0 < max(errors) < 3.5  # its bias, mostly
        statistics = fake.robot.imu_statistics()
    assert statistics is not None
    assert statistics.stray_bytes < 33  # of the measurement that was under way
    assert statistics.failure is None
    if kind == "bno085-rvc":
        assert not rates
    else:
        turned = sum(rate.z for rate in rates) * 0.01
        assert turned == pytest.approx(math.radians(fake.heading_change_deg), abs=0.06)


def test_a_silent_imu_is_no_data(tmp_path: Path) -> None:
    with FakeRobot(with_imu(tmp_path, KINDS["bno085-rvc"])) as fake:
        fake.robot.stand()
        fake.robot.walk(vx=0.05, seconds=0.5)
        fake.befall("unplug", bus="imu", for_=1.0)
        seen: list[Any] = []
        fake.robot.observers.append(lambda tick: seen.append(tick.estimate.imu))
        fake.robot.walk(vx=0.05, seconds=1.5)
    ages = [imu.age for imu in seen[:95]]
    assert all(after > before for before, after in itertools.pairwise(ages[5:]))
    assert not seen[60].valid
    assert seen[60].roll == seen[30].roll  # its last
    assert seen[140].valid
    told = [event.text for event in fake.robot.events if event.kind == "imu"]
    assert told == ["the IMU is silent", "the IMU is heard again"]


def test_noise_on_its_line_costs_measurements_and_nothing_else(tmp_path: Path) -> None:
    with FakeRobot(with_imu(tmp_path, KINDS["wt61"])) as fake:
        fake.befall("noise", bus="imu", every_ms=7)
        fake.robot.stand()
        statistics = fake.robot.imu_statistics()
        state = fake.robot.state.imu
    assert statistics is not None
    assert statistics.stray_bytes > 500
    assert state is not None
    assert abs(state.roll) < 0.05
    assert fake.robot.bus_statistics()["legs"].bad_frames == 0


def test_a_walk_with_an_imu_replays_bit_for_bit_and_tells_of_it(tmp_path: Path) -> None:
    log = tmp_path / "walk.mcap"
    simulation = assembly.simulate(str(with_imu(tmp_path, KINDS["wt61"])), log=log)
    outing = Outing(simulation, STANDING)
    outing.run(lambda text, share: None)
    report = outing.report()
    assert report["imu"]["reports"] == pytest.approx(report["ticks"], abs=3)
    assert 0.0 < report["imu"]["max_tilt_deg"] < 2.0
    assert {line.bus for line in of_log(log)} == {"legs"}  # the rest is no servos' talk
    replayed = replay(log)
    assert replayed.difference is None
    assert replayed.ticks == report["ticks"]


def test_robots_without_one_report_nothing_of_it() -> None:
    outing = Outing(assembly.simulate("hexapod"), STANDING)
    assert "imu" not in outing.report()


@pytest.mark.parametrize(("imu", "complaint"), [
    ("kind: bno055, baud: 115200", "no such IMU; there are bno085-rvc, wt61, wt901"),
    ("kind: bno085-rvc, baud: 9600", "bno085-rvc has only 115200"),
    ("kind: wt901, baud: 9600, rate_hz: 50", "carries 21.8 measurements of wt901 a second, which sends 50"),
    ("kind: wt61, baud: 115200, rate_hz: 200", "wt61 has at most 100 Hz"),
    ("kind: wt901, baud: 9600, stale_after_s: 0.1", "hardly longer than from one measurement to the next, at 10 Hz"),
    ("kind: wt61, baud: 115200, mounting_deg: [0, 0, 270]", "less than or equal to 180"),
    ("kind: wt61, baud: 115200, mounting: [0, 0, 90]", "mounting"),
])
def test_an_imu_that_cannot_be_is_refused_with_its_line(imu: str, complaint: str, tmp_path: Path) -> None:
    path = with_imu(tmp_path, imu)
    with pytest.raises(ConfigError) as caught:
        assembly.load(str(path))
    line = 1 + path.read_text().splitlines().index(f"  imu: {{port: /dev/ttyUSB1, {imu}}}")
    assert f"hexapod_imu.yaml:{line}:" in str(caught.value)
    assert complaint in str(caught.value)


def test_it_is_one_more_port_of_the_simulated_device_and_so_are_foot_switches(tmp_path: Path) -> None:
    robot = with_imu(tmp_path, KINDS["bno085-rvc"])
    robot.write_text(robot.read_text().replace(
        "hardware:\n", "hardware:\n  foot_switches: {port: /dev/ttyUSB2, inputs: {lf: 0, lm: 1, rr: 9}}\n"))
    with served(str(robot), "--pty", str(tmp_path / "dev")) as urls:
        assert urls == {name: str(tmp_path / "dev" / name) for name in ("legs", "imu", "feet")}
        time.sleep(0.5)  # while nobody listens
        late = os.open(urls["imu"], os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
        with contextlib.suppress(BlockingIOError):
            assert len(os.read(late, 4096)) < 200, "what it said before"
        os.close(late)
        with serial.serial_for_url(urls["imu"], 9600, timeout=0.2) as wrong:
            assert wrong.read(50) == b""
        session = assembly.connect(str(robot), urls)
        seen: list[Any] = []
        session.robot.observers.append(lambda tick: seen.append(tick.estimate.imu))
        with session.robot:
            session.robot.stand()
            standing = [switch.closed for switch in session.robot.state.switches]
        statistics = session.robot.imu_statistics()
    assert statistics is not None
    assert statistics.reports > 50
    heard = [imu for imu in seen if imu is not None and imu.valid]
    assert len(heard) > 0.8 * len(seen)
    assert abs(heard[-1].roll) < 0.1
    assert session.robot.state.odometry.roll == heard[-1].roll
    switches = session.robot.foot_switch_statistics()
    assert switches is not None
    assert switches.reports > 100
    assert standing == [True, True, None, None, None, True]


@pytest.mark.parametrize("levelling", ["", "  levelling: {}\n"])
def test_a_hexapod_with_an_imu_levels_its_body_on_a_slope_while_it_is_heard(levelling: str, tmp_path: Path) -> None:
    with FakeRobot(with_imu(tmp_path, KINDS["wt61"], levelling), terrain="ramp_8") as fake:
        fake.robot.stand()
        fake.robot.walk(vx=0.2, seconds=9.0)
        tilt = math.degrees(math.hypot(fake.base.roll, fake.base.pitch))
        if not levelling:
            assert tilt == pytest.approx(0.6 * 8.0, abs=0.8), "the share of its file"
            return
        assert tilt < 1.5
        assert not fake.fell
        pitches = []
        fake.robot.observers.append(lambda tick: pitches.append(math.degrees(fake.base.pitch)))
        fake.befall("unplug", bus="imu", for_=2.0)
        fake.robot.walk(vx=0.05, seconds=2.0)
        assert min(pitches) < -3.0
        seconds = fake.seconds
    assert fake.seconds < seconds + 8.0  # it does not try to be level on its belly
    assert "timeout" not in [event.kind for event in fake.robot.events]


def test_the_feet_and_the_imu_do_not_both_tilt_the_body(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"hexapod_imu.yaml:\d+:\d+: locomotion.levelling: by the IMU or by the feet"):
        assembly.load(str(with_imu(tmp_path, KINDS["wt61"], "  levelling: {}\n  orientation: {share: 0.5}\n")))
    assembly.load(str(with_imu(tmp_path, KINDS["wt61"], "  levelling: {}\n  orientation: {share: 0}\n")))


def test_levelling_needs_an_imu(tmp_path: Path) -> None:
    path = with_imu(tmp_path, KINDS["wt61"], "  levelling: {}\n")
    path.write_text("\n".join(line for line in path.read_text().splitlines() if not line.startswith("  imu:")))
    with pytest.raises(ConfigError, match=r"hexapod_imu.yaml:\d+:\d+: locomotion.levelling: this needs an IMU"):
        assembly.load(str(path))
