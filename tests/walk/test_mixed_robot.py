"""One robot of two brands on two buses, and of two models on one of them."""

import re
from pathlib import Path

import pytest

from robotwalk import assembly

from ..robots import hexapod_that_does_not_feel
from .rig import walk


@pytest.fixture
def mixed(tmp_path: Path) -> str:
    """Return the hexapod with Feetechs on its right, and on its left two models of Dynamixel, which share a wire."""
    text = hexapod_that_does_not_feel().replace(
        "    legs: {port: /dev/ttyUSB0, baud: 1000000}\n",
        "    left: {port: /dev/ttyUSB0, baud: 1000000}\n    right: {port: /dev/ttyUSB1, baud: 1000000}\n")
    text = re.sub(r"(?m)^(    r\w+: +\{bus: )legs(.*servo: )xl430-w250", r"\1right\2sts3215-12v", text)
    text = re.sub(r"(?m)^(    l\w_coxa: +\{bus: )legs(.*servo: )xl430-w250", r"\1left\2xl330-m288", text)
    path = tmp_path / "mixed.yaml"
    path.write_text(text.replace("bus: legs", "bus: left"))
    return str(path)


def test_it_walks_with_each_servo_spoken_to_in_its_own_way(mixed: str) -> None:
    blueprint = assembly.load(mixed)
    models = {bus: {servo.model.name for servo in wired} for bus, wired in blueprint.wiring.items()}
    assert models == {"left": {"xl430-w250", "xl330-m288"}, "right": {"sts3215-12v"}}
    report = walk(blueprint, speed=0.05, duration=4.0)
    assert not report["fell"]
    assert report["distance_m"] == pytest.approx(0.2, rel=0.15)
    for bus in report["bus"].values():
        assert (bus["lost_replies"], bus["bad_frames"], bus["watchdog_trips"]) == (0, 0, 0)
    assert report["timing"]["missed_deadlines"] == 0


def test_losses_on_one_bus_cost_the_other_nothing(mixed: str) -> None:
    losses = [{"at": 6, "fault": "drop_reply", "rate": 0.2, "bus": "right"}]
    report = walk(mixed, speed=0.05, duration=3.0, faults=losses)
    assert not report["fell"]
    assert report["bus"]["right"]["lost_replies"] > 100
    assert report["bus"]["left"]["lost_replies"] == 0
