"""A wire that loses and spoils replies: the robot walks on, and no goal derives from a read that failed."""

import dataclasses
import hashlib
import math
from itertools import pairwise
from random import Random
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.loop import Tick
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.reply import Reply

from .rig import walk

pytestmark = pytest.mark.usefixtures("watched_joints")

HEXAPOD = assembly.load("hexapod")
LOSSES = [
    {"at": 0, "fault": "drop_reply", "rate": 0.05},
    {"at": 0, "fault": "corrupt_frame", "rate": 0.01},
]


def hexapod(*, fast: bool = True, later_ids_answer: bool = False) -> assembly.Blueprint:
    """Return the hexapod with other firmware in its servos."""
    model = HEXAPOD.servos["xl430-w250"]
    firmware = model.firmware.model_copy(update={"later_ids_answer": later_ids_answer})
    first = model.fast_sync_read_firmware if fast else None
    changed = model.model_copy(update={"firmware": firmware, "fast_sync_read_firmware": first})
    return dataclasses.replace(HEXAPOD, servos={**HEXAPOD.servos, model.name: changed})


@pytest.mark.parametrize(("fast", "later_ids_answer"), [(True, False), (False, False), (False, True)])
def test_with_one_reply_in_twenty_lost_and_one_in_a_hundred_spoilt_it_walks_its_metre(
    fast: bool, later_ids_answer: bool
) -> None:
    report = walk(hexapod(fast=fast, later_ids_answer=later_ids_answer), speed=0.10, duration=10.0, faults=LOSSES)
    assert not report["fell"]
    assert report["distance_m"] == pytest.approx(1.0, rel=0.15)
    assert report["bus"]["legs"]["lost_replies"] > 0.05 * 18 * 1000
    assert [event["kind"] for event in report["events"] if event["kind"] == "safety_stop"] == []


def test_faults_that_never_begin_change_nothing() -> None:
    never = [{"at": 1000, "fault": name, **keys} for name, keys in {
        "drop_reply": {}, "noise": {}, "brown_out": {}, "stuck_joint": {"joint": "lf_coxa"}, "push": {"force_n": 5}
    }.items()]
    plain, threatened = (walk("hexapod", speed=0.1, duration=1.0, faults=faults) for faults in ([], never))
    assert plain["state_hash"] == threatened["state_hash"]


def test_equal_seeds_suffer_equal_faults() -> None:
    first, again = (walk("hexapod", speed=0.1, duration=0.1, faults=LOSSES, seed=0) for _ in range(2))
    assert first["state_hash"] == again["state_hash"]
    assert first["bus"] == again["bus"]


def test_it_is_armed_through_losses_whatever_their_seed() -> None:
    for seed in range(1, 5):
        simulation = assembly.simulate("hexapod", faults=LOSSES, seed=seed)
        with simulation.robot as robot:
            robot.stand()
            assert simulation.world.truth().base.z > 0.1
            for servo in simulation.world.servos:
                assert servo.table["torque_enable"] == 1
                wanted = servo.model.arming.set
                assert {name: servo.table[name] for name in wanted} == wanted
        assert simulation.world.truth().base.z < 0.04
        assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)


class Scribe:
    """Sits at the wire beside each servo: loses and spoils replies, and notes the positions that got through intact.

    Where it strikes goes by one seed, what it puts in place of a byte by another. It leaves alone what frames a
    reply, so that equally many bytes count as one in every run.
    """

    def __init__(self, simulation: assembly.Simulation, garbage: int) -> None:
        self.strike, self.garbage = Random(1), Random(garbage)
        self.intact: list[list[float]] = []  # by joint: angles told since the last tick
        self.strikes = False
        self.spoilt = 0
        self.sent = hashlib.sha256()
        world = simulation.world
        for joint, servo in zip(HEXAPOD.model.joint_names, world.servos, strict=True):
            assert isinstance(servo, DynamixelServo)
            self.intact.append([])
            servo.interferences.append(self._beside(servo, HEXAPOD.hardware.joints[joint], self.intact[-1]))
        port, write = world.ports["legs"], world.ports["legs"].write

        def listen(data: bytes) -> None:
            self.sent.update(f"{world.clock.now()} {data.hex()}\n".encode())
            write(data)

        port.write = listen  # type: ignore[method-assign]

    def _beside(self, servo: DynamixelServo, row: Any, told: list[float]) -> Any:
        def pass_on(reply: Reply) -> Reply | None:
            chance, from_end, change = self.strike.random(), self.strike.randint(1, 12), self.garbage.randrange(1, 256)
            if self.strikes and chance < 0.05:
                return None
            if self.strikes and chance < 0.08 and len(reply.data) > 12:
                self.spoilt += 1
                data = bytearray(reply.data)
                data[-from_end] ^= change
                return reply._replace(data=bytes(data))
            if bytes(servo.table.data[132:136]) in reply.data:
                ticks = servo.table["present_position"]
                told.append(row.direction * (ticks - 2048) * math.tau / 4096 + math.radians(row.zero_deg))
            return reply

        return pass_on


def scribbled_walk(robot: assembly.Blueprint, garbage: int) -> tuple[Scribe, list[Tick], list[list[list[float]]]]:
    """Walk 2 s with a heading to hold, which odometry and so every joint's position has a say in."""
    simulation = assembly.simulate(robot)
    scribe = Scribe(simulation, garbage)
    ticks: list[Tick] = []
    told: list[list[list[float]]] = []

    def note(tick: Tick) -> None:
        ticks.append(tick)
        told.append([list(angles) for angles in scribe.intact])
        for angles in scribe.intact:
            angles.clear()

    with simulation.robot as walker:
        walker.observers.append(note)
        walker.stand()
        scribe.strikes = True
        walker.walk(vx=0.10, seconds=2.0, heading=0.1)
    return scribe, ticks, told


@pytest.mark.parametrize(("fast", "later_ids_answer"), [(True, False), (False, False), (False, True)])
def test_no_goal_derives_from_a_failed_read(fast: bool, later_ids_answer: bool) -> None:
    robot = hexapod(fast=fast, later_ids_answer=later_ids_answer)
    scribe, ticks, told = scribbled_walk(robot, garbage=1)
    assert scribe.spoilt > 50
    assert sum(not all(tick.joints.valid) for tick in ticks) > 100
    for (before, tick), answers in zip(pairwise(ticks), told[1:], strict=True):
        for slot, (position, valid) in enumerate(zip(tick.joints.position, tick.joints.valid, strict=True)):
            if valid:
                assert any(math.isclose(position, angle, abs_tol=1e-9) for angle in answers[slot])
            else:
                assert position == before.joints.position[slot]
    # Whatever the spoilt bytes were, every byte that is sent, and when, is the same.
    assert scribbled_walk(robot, garbage=2)[0].sent.hexdigest() == scribe.sent.hexdigest()
