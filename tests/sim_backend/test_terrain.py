"""The ground in MuJoCo is the one that the files tell of."""


import mujoco
import numpy as np
import pytest

from robotwalk.config import library
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
