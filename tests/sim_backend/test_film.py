"""What a person sees of a film, and what happens when it cannot be written."""

import math
import os
import subprocess
import sys
import textwrap
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image, ImageChops

from robotwalk.errors import UsageError
from sim_backend.film import Film, check_writable
from sim_backend.terrain.course import Ground
from sim_backend.terrain.shapes import Slab, Span

SIZE = (240, 160)


@pytest.fixture(autouse=True)
def _no_gl(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disabled")


@pytest.fixture(scope="module")
def model():
    """An orange box on six green legs, each turned by one hinge."""
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
    body = spec.worldbody.add_body(pos=[0, 0, 0.1])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.12, 0.10, 0.025], rgba=[0.93, 0.52, 0.18, 1])
    for degrees in (45, 90, 135, -135, -90, -45):
        yaw = math.radians(degrees)
        leg = body.add_body(pos=[0.13 * math.cos(yaw), 0.1 * math.sin(yaw), 0], euler=[0, 0, yaw])
        leg.add_joint(axis=[0, 0, 1])
        leg.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0, 0, 0, 0.1, 0, -0.09], size=[0.01, 0, 0],
            rgba=[0.1, 0.6, 0.2, 1],
        )
        leg.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=[0.1, 0, -0.09], size=[0.009, 0, 0])
    spec.compiler.degree = False
    return spec.compile()


def shoot(film, model, frames, *, speed=0.0, swing=0.0, caption="t {:.2f} s"):
    """Film `frames` frames of a robot that slides along x and swings its legs."""
    data = mujoco.MjData(model)
    for number in range(frames):
        seconds = number / 20
        film.due(seconds)
        data.qpos[0] = speed * seconds
        data.qpos[7:] = swing * math.sin(6.0 * seconds)
        film.shoot(data, caption.format(seconds))


def frames_of(path):
    with Image.open(path) as gif:
        frames = []
        for number in range(gif.n_frames):
            gif.seek(number)
            frames.append((gif.convert("RGB"), gif.info["duration"]))
    return frames


def changed_pixels(first, second):
    return int(np.count_nonzero(np.asarray(ImageChops.difference(first, second)).max(axis=2) > 8))


def test_a_film_loops_at_its_speed_and_size(model, tmp_path):
    film = Film(model, fps=20, size=SIZE)
    shoot(film, model, 10, speed=0.1)
    film.save(tmp_path / "walk.gif")
    with Image.open(tmp_path / "walk.gif") as gif:
        assert (gif.format, gif.size, gif.info["loop"]) == ("GIF", (240, 160), 0)
    assert [duration for _, duration in frames_of(tmp_path / "walk.gif")] == [50] * 10


@pytest.mark.parametrize(
    ("fps", "loop_hz", "durations"),
    [(30, 100, [30, 40, 30, 30, 40, 30]), (25, 100, [40] * 6), (20, 10, [100, 100, 100, 100, 100, 50])],
)
def test_playback_keeps_time_whatever_the_rates(model, tmp_path, fps, loop_hz, durations):
    film = Film(model, fps=fps, size=SIZE)
    data = mujoco.MjData(model)
    tick, shot = 0, 0
    while shot < 6:
        if film.due(3.0 + tick / loop_hz):
            film.shoot(data, f"frame {shot}")
            shot += 1
        tick += 1
    film.save(tmp_path / "walk.gif")
    assert [duration for _, duration in frames_of(tmp_path / "walk.gif")] == durations


def test_one_second_at_100_hz_is_20_frames(model):
    film = Film(model, fps=20, size=SIZE)
    data = mujoco.MjData(model)
    due = 0
    for tick in range(100):
        if film.due(7.5 + tick * 0.01):
            due += 1
            film.shoot(data, "")
    assert due == 20


@pytest.mark.parametrize("motion", [{"speed": 0.4}, {"swing": 0.5}])
def test_consecutive_frames_show_the_motion(model, tmp_path, motion):
    film = Film(model, size=SIZE)
    shoot(film, model, 5, caption="", **motion)
    film.save(tmp_path / "walk.gif")
    frames = [frame for frame, _ in frames_of(tmp_path / "walk.gif")]
    assert [changed_pixels(*pair) > 100 for pair in pairwise(frames)] == [True] * 4


def test_a_robot_that_stands_leaves_the_picture_still(model, tmp_path):
    film = Film(model, size=SIZE)
    shoot(film, model, 5)
    film.save(tmp_path / "walk.gif")
    frames = [frame.crop((0, 40, *SIZE)) for frame, _ in frames_of(tmp_path / "walk.gif")]
    assert [changed_pixels(frames[0], frame) for frame in frames] == [0] * 5


def test_the_camera_keeps_a_walking_robot_in_the_middle(model, tmp_path):
    film = Film(model, size=SIZE)
    shoot(film, model, 10, speed=2.0)
    film.save(tmp_path / "walk.gif")
    for frame, _ in frames_of(tmp_path / "walk.gif")[::3]:
        red, green, blue = frame.getpixel((120, 76))
        assert (red > 200, 110 < green < 180, blue < 110) == (True, True, True), "the body's orange"


def test_legs_have_their_colour_and_far_ones_are_paler(model, tmp_path):
    film = Film(model, size=SIZE)
    shoot(film, model, 1, caption="")
    film.save(tmp_path / "walk.gif")
    pixels = np.asarray(frames_of(tmp_path / "walk.gif")[0][0]).astype(int)
    green = (pixels[:, :, 1] > pixels[:, :, 0] + 12) & (pixels[:, :, 1] > pixels[:, :, 2] + 8)
    near_feet, far_leg = green[120:, 80:160], green[:, 160:]
    assert np.count_nonzero(near_feet) > 60
    assert np.count_nonzero(far_leg) > 40
    assert pixels[:, 160:][far_leg].mean() > pixels[120:, 80:160][near_feet].mean() + 20


def test_the_robot_throws_a_shadow(model, tmp_path):
    film = Film(model, size=SIZE)
    shoot(film, model, 1, caption="")
    film.save(tmp_path / "walk.gif")
    pixels = np.asarray(frames_of(tmp_path / "walk.gif")[0][0]).astype(int)
    grey = np.ptp(pixels, axis=2) < 30
    assert np.count_nonzero(grey & (pixels.mean(axis=2) > 150) & (pixels.mean(axis=2) < 205)) > 200


def test_the_ground_ahead_is_seen(model, tmp_path):
    """A riser is darker than level ground, a slippery stretch is blue."""
    ahead = Span(0.2, 20.0, -1.0, 1.0)
    frames = {}
    for name, slab in (("level", Slab(ahead, 0.0)), ("riser", Slab(ahead, 0.06)), ("ice", Slab(ahead, 0.0, 0.2))):
        film = Film(model, ground=Ground(-0.01, [Slab(Span(-9.0, 0.2, -9.0, 9.0), 0.0), slab]), size=SIZE)
        shoot(film, model, 1, caption="")
        film.save(tmp_path / name)
        frames[name] = np.asarray(frames_of(tmp_path / name)[0][0]).astype(int)
    darker = (frames["level"] - frames["riser"]).min(axis=2) > 20
    bluer = (frames["ice"] - frames["level"])[:, :, 2] - (frames["ice"] - frames["level"])[:, :, 0] > 25
    assert np.count_nonzero(darker) > 300
    assert np.count_nonzero(bluer) > 3000


def test_the_caption_is_written_at_the_top(model, tmp_path):
    for name, caption in (("with", "hexapod  tripod"), ("without", "")):
        film = Film(model, size=SIZE)
        shoot(film, model, 1, caption=caption)
        film.save(tmp_path / name)
    frames = [frames_of(tmp_path / name)[0][0].crop((0, 0, 240, 40)) for name in ("with", "without")]
    assert changed_pixels(*frames) > 100


def test_half_a_second_of_film_is_small(model, tmp_path):
    film = Film(model)
    shoot(film, model, 10, speed=0.1, swing=0.3)
    film.save(tmp_path / "walk.gif")
    assert (tmp_path / "walk.gif").stat().st_size < 67_000  # bytes


def test_progress_rises_to_one(model, tmp_path):
    film = Film(model, size=SIZE)
    shoot(film, model, 4)
    told = []
    film.save(tmp_path / "walk.gif", told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize("name", ["missing/walk.gif", "."])
def test_an_unwritable_path_is_a_usage_error(model, tmp_path, name):
    with pytest.raises(UsageError, match="cannot write"):
        check_writable(tmp_path / name)
    film = Film(model, size=SIZE)
    shoot(film, model, 1)
    with pytest.raises(UsageError, match="cannot write"):
        film.save(tmp_path / name)


def test_looking_whether_a_path_is_writable_changes_nothing(tmp_path):
    (tmp_path / "old.gif").write_bytes(b"old")
    check_writable(tmp_path / "old.gif")
    check_writable(tmp_path / "new.gif")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("old.gif", b"old")]


def test_an_empty_film_and_an_odd_frame_rate_are_usage_errors(model, tmp_path):
    with pytest.raises(UsageError, match="no frames"):
        Film(model).save(tmp_path / "walk.gif")
    for fps in (0, 51):
        with pytest.raises(UsageError, match="1 to 50 frames per second"):
            Film(model, fps=fps)


@pytest.mark.parametrize("backend", ["disabled", "glfw"])
def test_no_gl_is_needed_and_none_is_complained_about(tmp_path, backend):
    script = """
        import sys
        from pathlib import Path
        import mujoco
        from sim_backend.film import Film
        model = mujoco.MjModel.from_xml_string(
            "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
        film = Film(model, size=(120, 80))
        film.shoot(mujoco.MjData(model), "t 0 s")
        film.save(Path(sys.argv[1]))
    """
    hidden = {"DISPLAY", "WAYLAND_DISPLAY"}
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    path = tmp_path / "walk.gif"
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), str(path)], check=False, capture_output=True,
        text=True, cwd=Path(__file__).parents[2], env={**environment, "MUJOCO_GL": backend},
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert len(frames_of(path)) == 1
