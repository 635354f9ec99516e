"""A robot that stands: whose leg is out of its place steps back, whoever has how many, and nobody else does."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from robotwalk import assembly
from robotwalk.chain import foot_position
from robotwalk.contact import Felt
from robotwalk.controller import Controller, Wanted
from robotwalk.estimator import Estimate
from robotwalk.kinematics import resting_angles
from robotwalk.supervisor import State
from robotwalk.support import centre_of_mass, support_margin
from robotwalk.types import LEVEL, Command, Twist, Vec3

DT = 0.01
TO_REST = 3.0  # s, ample for every gait; the crawl's body shifts first


class Standing:
    """A robot with perfect joints, but for feet that something has dragged off or dug out.

    Attributes:
        dragged: by how far each leg's foot is not where it is told to be, m ahead, until it steps.
        bears: each foot the N that it does; empty: nobody feels anything.
    """

    def __init__(self, robot: str, gait: str | None = None, *, reflex: bool = True) -> None:
        blueprint = assembly.load(robot)
        self.model = replace(blueprint.model, stance_reflex=reflex)
        self.controller = Controller(self.model, blueprint.gaits, gait or blueprint.default_gait)
        self.controller.start(resting_angles(self.model, 0.5 * self.model.body_box.z))
        self.state, self.command = State.STAND, Command()
        self.dragged: dict[int, float] = {}
        self.bears: list[float] = []
        self.heard = True
        self.mends = True  # a step does
        self._feet: tuple[Vec3 | None, ...] = ()
        for wanted in self.run(10.0):
            if wanted.standing:
                break

    def run(self, seconds: float) -> Iterator[Wanted]:
        for _ in range(round(seconds / DT)):
            felt = tuple(Felt(Vec3(0.0, 0.0, load), load, load > 1.5, load > 1.5) for load in self.bears)
            feet = self._feet if self.heard else (None,) * len(self.model.legs)
            wanted = self.controller.step(
                self.state, self.command, Estimate(LEVEL, len(self.model.legs), feet=feet, felt=felt), DT)
            told = [foot_position(leg, wanted.angles[leg.span]) for leg in self.model.legs]
            for leg, stands in enumerate(wanted.planted):
                if not stands and self.mends:
                    self.dragged.pop(leg, None)
            self._feet = tuple(foot._replace(x=foot.x + self.dragged.get(leg, 0.0)) for leg, foot in enumerate(told))
            yield wanted

    def in_air(self, seconds: float) -> list[tuple[int, ...]]:
        """Return which feet were in the air together, one after the other."""
        lifted: list[tuple[int, ...]] = []
        before: tuple[int, ...] = ()
        for wanted in self.run(seconds):
            now = tuple(leg for leg, stands in enumerate(wanted.planted) if not stands)
            if now and now != before:
                lifted.append(now)
            before = now
        return lifted


@pytest.mark.parametrize(("robot", "gait", "leg"), [
    ("hexapod", "tripod", 1), ("hexapod", "free", 4), ("octopod", "wave", 6), ("pentapod", "wave", 0),
    ("quadruped", "crawl", 3), ("quadruped", "trot", 0), ("quadruped", "free", 2)])
def test_a_leg_that_is_stretched_steps_back_alone_and_the_body_stays_over_the_others(
    robot: str, gait: str, leg: int
) -> None:
    standing = Standing(robot, gait)
    standing.dragged[leg] = 0.3 * standing.model.legs[leg].max_stride
    lifted = False
    for wanted in standing.run(TO_REST):
        if not all(wanted.planted):
            lifted = True
            assert wanted.recalled is not None
            assert [number for number, stands in enumerate(wanted.planted) if not stands] == [leg]
            others = [
                foot_position(other, wanted.angles[other.span])
                for other, stands in zip(standing.model.legs, wanted.planted, strict=True) if stands]
            assert support_margin(others, centre_of_mass(standing.model, wanted.angles)) > 0.008
    assert lifted
    assert wanted.standing
    assert wanted.recalled is None
    assert standing.in_air(1.0) == []


def test_the_leg_that_is_farthest_off_comes_first() -> None:
    standing = Standing("hexapod")
    standing.dragged = {0: -0.05, 4: 0.03}  # of other tripods, but alone they step
    assert standing.in_air(4.0) == [(0,), (4,)]


def _barely(standing: Standing) -> None:
    standing.dragged = {1: 0.018}  # as far as soft servos may sag


def _unheard(standing: Standing) -> None:
    standing.heard = False


def _sits(standing: Standing) -> None:
    standing.state = State.SIT


def _faulty(standing: Standing) -> None:
    standing.state = State.FAULT


def test_it_can_be_turned_off() -> None:
    standing = Standing("hexapod", reflex=False)
    standing.dragged = {1: 0.04}
    assert standing.in_air(1.5) == []


@pytest.mark.parametrize("why_not", [_barely, _unheard, _sits, _faulty])
def test_no_leg_steps_that_need_not_or_must_not(why_not: Callable[[Standing], None]) -> None:
    standing = Standing("hexapod")
    standing.dragged = {1: 0.04}
    why_not(standing)
    assert standing.in_air(1.5) == []


def test_a_shove_comes_to_its_end_first() -> None:
    standing = Standing("hexapod")
    for tick in range(100):
        standing.dragged = {1: 0.05 * tick * DT}
        assert all(all(wanted.planted) for wanted in standing.run(DT))
    assert standing.in_air(1.0) == [(1,)]


def test_what_three_steps_do_not_mend_no_fourth_one_tries() -> None:
    standing = Standing("hexapod")
    standing.mends = False
    standing.dragged = {1: 0.04}
    assert standing.in_air(8.0) == [(1,)] * 3


def test_who_is_told_to_walk_walks() -> None:
    standing = Standing("hexapod")
    standing.dragged = {1: 0.04}
    list(standing.run(0.2))
    standing.state, standing.command = State.WALK, Command(Twist(0.1, 0.0, 0.0))
    assert all(wanted.recalled is None for wanted in standing.run(1.0))


def test_a_foot_under_which_the_ground_gives_way_steps_and_one_that_never_bore_much_does_not() -> None:
    standing = Standing("hexapod")
    standing.bears = [4.0] * 5 + [1.8]
    assert standing.in_air(2.0) == []
    standing.bears[5] = 0.0
    assert standing.in_air(1.0) == []
    standing.bears[2], standing.bears[5] = 0.0, 1.8
    assert standing.in_air(0.9) == [(2,)]
