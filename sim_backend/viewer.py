"""Shows the simulation in a browser, on this machine only, at the pace of real time."""

import sys
import threading
import time
from contextlib import AbstractContextManager, redirect_stdout

import mujoco

from robotwalk.errors import UsageError

_HOST = "127.0.0.1"  # a page that shows a robot is for whoever sits at it
_CAMERA_DISTANCE = 0.9  # m
_FRAME_S = 1.0 / 30.0


class Viewer:
    """A page with the MuJoCo scene."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, port: int = 8080) -> None:
        """Start the server.

        Raises:
            UsageError: mjviser is not installed.
        """
        try:
            from mjviser import ViserMujocoScene
            from viser import ViserServer
        except ImportError as error:
            raise UsageError("--view needs the extra: pip install 'robotwalk[view]'") from error
        self._data = data
        with _no_word_on_stdout():
            self._server = ViserServer(host=_HOST, port=port, verbose=False)
            self._scene = ViserMujocoScene(self._server, model, num_envs=1)
        self._scene.create_scene_gui(camera_distance=_CAMERA_DISTANCE)
        self._looked_at = threading.Event()
        self._server.on_client_connect(lambda client: self._looked_at.set())
        self._began = 0.0
        self._next_frame = 0.0

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{_HOST}:{self._server.get_port()}"

    def wait_for_browser(self) -> None:
        """Say where the page is, and wait until somebody looks."""
        sys.stderr.write(f"robotwalk: open {self.url} to see it walk\n")
        while not self._looked_at.wait(0.2):
            pass

    def update(self, sim_seconds: float) -> None:
        """Draw if a frame is due, and sleep while the simulation is ahead of real time."""
        if not self._began:
            self._began = time.monotonic() - sim_seconds
        if sim_seconds >= self._next_frame:
            self._next_frame = sim_seconds + _FRAME_S
            self._scene.update_from_mjdata(self._data)
        ahead = self._began + sim_seconds - time.monotonic()
        if ahead > 0.0:
            time.sleep(ahead)

    def close(self) -> None:
        """Stop the server."""
        with _no_word_on_stdout():
            self._server.stop()


def _no_word_on_stdout() -> AbstractContextManager[object]:
    """Send what viser prints to stderr: stdout is for data."""
    return redirect_stdout(sys.stderr)
