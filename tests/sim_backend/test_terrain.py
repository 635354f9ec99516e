"""The ground in MuJoCo is the one that the files tell of."""


import mujoco
import numpy as np
import pytest

from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.errors import ConfigError
from sim_backend.terrain.build import GROUP, add_floor, add_ground
from sim_backend.terrain.course import Ground, Terrain, read_terrain

BEGIN = 0.42  # m: 0.3 m ahead of a body whose front is at 0.12 m
FRONT = 0.12
BUNDLED = library.names("terrains")


def terrain(name: str) -> Terrain:
    return read_terrain(library.open_document("terrains", name))


def built(ground: Ground) -> tuple[mujoco.MjModel, mujoco.MjData]:
    spec = mujoco.MjSpec()
    add_floor(spec, ground, [1.0, 0.005, 0.0001])
    add_ground(spec, ground, [1.0, 0.005, 0.0001])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


class Rays:
    """Feels for the ground of a terrain from above."""

    def __init__(self, name: str, seed: int = 0) -> None:
        self.ground = terrain(name).lay_out(FRONT, seed)
        self.model, self.data = built(self.ground)
        self._groups = np.zeros(6, np.uint8)
        self._groups[GROUP] = 1
        self.geom = np.zeros(1, np.int32)

    def height(self, x: float, y: float = 0.0) -> float:
        start = np.array([x, y, 3.0])
        down = np.array([0.0, 0.0, -1.0])
        fall = mujoco.mj_ray(self.model, self.data, start, down, self._groups, 1, -1, self.geom)
        assert fall >= 0.0, "there is no ground"
        return 3.0 - float(fall)


@pytest.mark.parametrize(("name", "heights"), [  # in mm, so many mm behind the beginning of the course
    ("flat", {-100: 0, 100: 0, 2600: 0}),
    ("ramp_8", {-1: 0, 1000: 140.5, 2499: 351.2, 2600: 351.4}),
    ("ramp_15", {-1: 0, 1000: 267.9, 2499: 669.6, 2600: 669.9}),
    ("stairs_25", {-1: 0, 1: 25, 199: 25, 201: 50, 2399: 300, 2499: 300, 4000: 300}),
    ("stairs_40", {-1: 0, 1: 40, 199: 40, 201: 80, 2399: 480, 2499: 480, 4000: 480}),
    ("gap_60", {-1: 0, 1: -100, 59: -100, 61: 0, 499: 0, 501: -100, 559: -100, 2059: -100, 2061: 0, 4000: 0}),
    ("patch_02", {-1: 0, 1: 0, 2499: 0, 2600: 0}),
    ("loose", {-1: 0, 1: 0, 2499: 0, 2600: 0}),
    ("drop_50", {-1: 0, 1: -50, 2600: -50}),
    ("cliff", {-1: 0, 1: -500, 2600: -500}),
    ("blocks_60", {-1: 0, 2501: 0}),
    ("rough_15", {-1: 0, 2501: 0}),
    ("rough_30", {-1: 0, 2501: 0}),
])
def test_a_bundled_course_has_the_heights_of_its_name(name: str, heights: dict[int, float]) -> None:
    rays = Rays(name)
    for place, height in heights.items():
        assert 1e3 * rays.height(BEGIN + 1e-3 * place) == pytest.approx(height, abs=0.2), place


def test_every_bundled_course_is_2_5_m_long_and_begins_0_3_m_ahead_of_the_body() -> None:
    for name in BUNDLED:
        assert terrain(name).config.lead_mm == 300
        if name != "flat":
            assert terrain(name).length == pytest.approx(2.5)
    assert "flat" in BUNDLED
    assert len(BUNDLED) == 13


@pytest.mark.parametrize("name", BUNDLED)
def test_the_ground_that_heights_are_counted_from_is_that_of_mujoco(name: str) -> None:
    rays = Rays(name, seed=3)
    chance = np.random.default_rng(1)
    for x, y in chance.uniform([-1.0, -0.55], [BEGIN + 3.5, 0.55], (300, 2)):
        assert rays.height(x, y) == pytest.approx(rays.ground.height(x, y), abs=1e-5), (x, y)


def read(text: str) -> Terrain:
    return read_terrain(Document.parse("schema: 1\nname: mine\ndescription: a test\n" + text, "mine.yaml"))


@pytest.mark.parametrize(("text", "complaint"), [
    ("course:\n  - {element: stares, steps: 1}",
     "mine.yaml:5:15: course.0.element: no such element; did you mean 'stairs'? (got 'stares')"),
    ("course:\n  - {steps: 1}", "mine.yaml:5:5: course.0: missing key 'element'"),
    ("course:\n  - {element: drop, depth_cm: 5}", "mine.yaml:5:21: course.0: unknown key 'depth_cm': did you mean"),
    ("course:\n  - {element: stairs, steps: 0, rise_mm: 9, tread_mm: 9}",
     "mine.yaml:5:30: course.0.steps: expected a number greater than or equal to 1 (got 0)"),
    ("course:\n  - {element: ramp, length_mm: 100, slope_deg: 90}",
     "mine.yaml:5:48: course.0.slope_deg: expected a number less than 60 (got 90)"),
    ("course:\n  - {element: level, length_mm: 100, friction: 0}",
     "mine.yaml:5:48: course.0.friction: expected a number greater than 0 (got 0)"),
    ("course:\n  - {element: blocks, length_mm: 1000, block_mm: 90, heights_mm: [0, 60]}",
     "mine.yaml:5:50: course.0.block_mm: should divide the length of 1000 mm and the width of 2000 mm (got 90)"),
    ("course:\n  - {element: rough, length_mm: 1000, cell_mm: 100, heights_mm: [30, -30]}",
     "mine.yaml:5:65: course.0.heights_mm: should be [low, high] with low below high (got [30, -30])"),
    ("course:\n  - {element: loose, length_mm: 100, lane_mm: 100, field_mm: 20, edges_mm: [10, 20], mass_g: [1, 2]}",
     "mine.yaml:5:62: course.0.field_mm: should be at least 1.5 times the longest edge, or bodies would overlap"),
    ("course: []\nwidht_mm: 900", "mine.yaml:5:1: unknown key 'widht_mm': did you mean 'width_mm'?"),
])
def test_a_mistake_is_reported_with_its_place(text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as error:
        read(text)
    assert str(error.value).startswith(complaint)


def test_equal_seeds_give_equal_ground_and_others_another() -> None:
    for name in ("blocks_60", "rough_30", "loose"):
        first, again, other = (terrain(name).lay_out(FRONT, seed) for seed in (1, 1, 2))
        assert first == again
        assert first != other


def test_blocks_are_10_cm_wide_and_evenly_distributed_from_0_to_60_mm() -> None:
    rays = Rays("blocks_60", seed=5)
    tops = [
        [rays.height(BEGIN + 0.1 * row + 0.05, 0.1 * column - 0.55) for column in range(12)] for row in range(25)]
    assert 0.0 <= np.min(tops) < 0.003
    assert 0.057 < np.max(tops) <= 0.06
    assert np.mean(tops) == pytest.approx(0.03, abs=0.003)
    assert np.std(tops) == pytest.approx(0.06 / 12**0.5, abs=0.002)
    for inside in (0.002, 0.098):
        assert rays.height(BEGIN + 0.7 + inside, inside) == pytest.approx(tops[7][6])


@pytest.mark.parametrize(("name", "amplitude"), [("rough_15", 0.015), ("rough_30", 0.03)])
def test_rough_ground_has_its_points_every_100_mm_evenly_distributed(name: str, amplitude: float) -> None:
    rays = Rays(name, seed=5)
    points = [[rays.height(BEGIN + 0.1 * row, 0.1 * column - 0.9) for column in range(19)] for row in range(1, 25)]
    assert np.max(np.abs(points)) <= amplitude + 1e-6
    assert np.max(points) > 0.95 * amplitude
    assert np.mean(points) == pytest.approx(0.0, abs=0.1 * amplitude)
    assert np.std(points) == pytest.approx(2 * amplitude / 12**0.5, rel=0.06)


def test_the_slippery_patch_has_a_friction_of_0_2_and_what_is_around_it_has_not() -> None:
    spec = mujoco.MjSpec()
    ground = terrain("patch_02").lay_out(FRONT, 0)
    add_floor(spec, ground, [1.0, 0.005, 0.0001])
    for x in (BEGIN - 0.1, BEGIN + 1.0, BEGIN + 2.6):
        ball = spec.worldbody.add_body(pos=[x, 0.0, 0.009])
        ball.add_freejoint()
        ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], contype=0, condim=4)
    add_ground(spec, ground, [1.0, 0.005, 0.0001])
    data = mujoco.MjData(model := spec.compile())
    mujoco.mj_forward(model, data)
    found = {round(float(contact.pos[0]), 2): float(contact.friction[0]) for contact in data.contact}
    assert found == {0.32: 1.0, 1.42: pytest.approx(0.2), 3.02: 1.0}
    assert {int(contact.dim) for contact in data.contact} == {4}


def test_loose_bodies_weigh_20_to_80_g_and_lie_still_apart_from_each_other() -> None:
    ground = terrain("loose").lay_out(FRONT, 0)
    model, data = built(ground)
    masses = model.body_mass[1:]
    assert len(masses) == 80
    assert 0.02 <= masses.min() < 0.025
    assert 0.075 < masses.max() <= 0.08
    assert all(0 in model.geom_bodyid[contact.geom] for contact in data.contact), "two of them overlap"
    before = data.xpos.copy()
    mujoco.mj_step(model, data, 200)
    assert data.xpos == pytest.approx(before, abs=1e-3)
