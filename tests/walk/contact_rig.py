"""What the feet of a walking robot feel, against MuJoCo's contacts.

`python -m tests.walk.contact_rig [ROBOT] [TERRAIN ...]` prints the figures of docs/contact.md.
"""

import math
import statistics
import sys
from typing import NamedTuple

from robotwalk import assembly
from robotwalk.loop import Tick
from robotwalk.types import Vec3

_APART = 5  # ticks without contact before a touchdown, and with it after
_WINDOW = 15  # ticks in which it should be felt
_SLIP = 5e-3  # m that a foot moves over the ground while it bears a load and should stand
_NOTICED = 30  # ticks from a slip's begin in which the load is felt to be gone


class Figures(NamedTuple):
    """Of one walk."""

    touchdowns: int
    delay_ms: float  # median, from MuJoCo's contact to the tick that tells of it
    missed: int
    false: int  # touchdowns felt of which there were none, of the foot nor of its leg
    shins: int  # felt while another part of the leg touched something
    slips: int
    noticed: int


class _Foot:
    """What one foot felt, touched and did, tick by tick."""

    def __init__(self) -> None:
        self.felt: list[bool] = []
        self.touched: list[bool] = []
        self.leaned: list[bool] = []  # some other part of its leg did
        self.planted: list[bool] = []
        self.places: list[Vec3] = []


def measure(
    robot: str, terrain: str, *, speed: float, seconds: float, seed: int = 0, supply_v: float | None = None
) -> Figures:
    """Walk and compare; with another supply than the servos are rated for, V, if one is given."""
    simulation = assembly.simulate(robot, terrain=terrain, seed=seed)
    if supply_v is not None:
        simulation.world.physics.supply_v[:] = supply_v
    world = simulation.world.world
    feet = [_Foot() for _ in simulation.blueprint.model.legs]
    geoms = [world.model.geom(f"{leg.name}_foot").id for leg in simulation.blueprint.model.legs]

    names = [leg.name for leg in simulation.blueprint.model.legs]
    leg_of = {
        geom: names.index(name.split("_")[0]) for geom in range(world.model.ngeom)
        if (name := world.model.geom(geom).name).split("_")[0] in names and geom not in geoms}

    def watch(tick: Tick) -> None:
        if not tick.estimate.felt:
            return
        contacts = simulation.world.truth().contacts
        leaning = {leg_of.get(geom) for contact in world.data.contact for geom in (contact.geom1, contact.geom2)}
        for index, foot in enumerate(feet):
            foot.leaned.append(index in leaning)
        for foot, felt, touched, planted, geom in zip(
            feet, tick.estimate.felt, contacts, tick.wanted.planted, geoms, strict=True,
        ):
            foot.felt.append(felt is not None and felt.touching)
            foot.touched.append(touched)
            foot.planted.append(planted)
            foot.places.append(Vec3(*world.data.geom_xpos[geom].tolist()))

    with simulation.robot as walker:
        walker.stand()
        walker.observers.append(watch)
        walker.walk(vx=speed, seconds=seconds)
        walker.observers.clear()
    return _figures(feet, 1e3 / walker.loop.rate_hz)


def _figures(feet: list[_Foot], tick_ms: float) -> Figures:
    delays: list[int] = []
    touchdowns = missed = false = shins = slips = noticed = 0
    for foot in feet:
        for t in range(_APART, len(foot.felt) - _WINDOW):
            if all(foot.touched[t:t + _APART]) and not any(foot.touched[t - _APART:t]):
                touchdowns += 1
                felt = next((k for k in range(_WINDOW) if foot.felt[t + k]), None)
                if felt is None:
                    missed += 1
                else:
                    delays.append(felt)
            if all(foot.felt[t:t + 2]) and not any(foot.felt[t - _APART:t]):
                none = not any(foot.touched[t - 2:t + 2])
                shins += none and any(foot.leaned[t - 2:t + 2])
                false += none and not any(foot.leaned[t - 2:t + 2])
        moved, since = 0.0, 0
        for t in range(1, len(foot.felt) - _NOTICED):
            standing = foot.touched[t] and foot.planted[t] and foot.planted[t - 1]
            moved = moved + math.dist(foot.places[t][:2], foot.places[t - 1][:2]) if standing else 0.0
            since = since if moved > 0.0 else t
            if moved > _SLIP:
                slips += 1
                noticed += any(not foot.felt[k] for k in range(since, t + _NOTICED) if foot.planted[k])
                moved, since = 0.0, t
    delay = statistics.median(delays) * tick_ms if delays else math.nan
    return Figures(touchdowns, delay, missed, false, shins, slips, noticed)


if __name__ == "__main__":
    _, *arguments = sys.argv
    for ground in arguments[1:] or ["flat", "stairs_25", "rough_30", "patch_02"]:
        figures = measure((arguments or ["hexapod"])[0], ground, speed=0.06, seconds=25.0)
        sys.stdout.write(f"{ground} {figures}\n")
