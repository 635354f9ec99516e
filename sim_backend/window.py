"""Shows a robot that is served as a device: the browser's server runs in a process of its own, so serving never waits.

The processes share one array, the configuration `qpos` of MuJoCo's model. A picture drawn from a torn copy is the worst
that can come of it.
"""

import multiprocessing
import os
import signal
from multiprocessing.connection import Connection
from typing import Any

import mujoco
import numpy as np

from robotwalk.errors import UsageError
from sim_backend.simulation import SimulatedRobot
from sim_backend.viewer import Viewer

_RATE_HZ = 30
_STARTED = 60.0  # s within which the page must be there


class Window:
    """A page that follows a simulated robot."""

    def __init__(self, robot: SimulatedRobot) -> None:
        """Start its server.

        Raises:
            UsageError: the extra `robotwalk[view]` is not installed, or the page does not come up.
        """
        self._robot = robot
        self._data = robot.world.data
        context = multiprocessing.get_context("spawn")
        shared = context.RawArray("d", robot.world.model.nq)
        self._shared = np.frombuffer(shared)
        self._shared[:] = self._data.qpos
        self._stride = max(1, robot.world.steps_per_second // _RATE_HZ)
        self._steps = 0
        here, there = context.Pipe()
        self._process = context.Process(
            target=_show, args=(robot.world.model, shared, there), name="robotwalk-view", daemon=True)
        self._process.start()
        there.close()
        try:
            told = here.recv() if here.poll(_STARTED) else "the page does not come up"
        except EOFError:
            told = "the page does not come up"
        if isinstance(told, str):
            raise UsageError(told)
        (self.url,) = told
        robot.observers.append(self._observe)

    def close(self) -> None:
        """Close the page."""
        self._robot.observers.remove(self._observe)
        self._process.terminate()
        self._process.join(5.0)

    def _observe(self) -> None:
        self._steps += 1
        if self._steps % self._stride == 0:
            self._shared[:] = self._data.qpos


def _show(model: mujoco.MjModel, shared: Any, ready: Connection) -> None:
    """Draw what is shared, until the parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent says when
    parent = os.getppid()
    data = mujoco.MjData(model)
    qpos = np.frombuffer(shared)
    try:
        viewer = Viewer(model, data)
    except UsageError as error:
        ready.send(str(error))
        return
    ready.send((viewer.url,))
    frame = 0
    while os.getppid() == parent:
        frame += 1
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        viewer.update(frame / _RATE_HZ)
