"""The same courses with and without feeling: `python -m tests.walk.courses [ROBOT] [SEEDS] [TERRAIN ...]`.

One line a walk, at 0.06 m/s over 2.25 m: the share of the commanded distance, tilt, yaw, whether it fell.
"""

import dataclasses
import sys

from robotwalk import assembly

from . import rig

_COURSES = ("flat", "stairs_25", "stairs_40", "ramp_15", "rough_30", "blocks_60", "patch_02", "drop_50")
_SPEED, _SECONDS = 0.06, 37.5


def main() -> None:
    """Walk them all."""
    _, *arguments = sys.argv
    robot = arguments[0] if arguments else "hexapod"
    seeds = int(arguments[1]) if len(arguments) > 1 else 10
    courses = arguments[2:] or _COURSES
    feeling = assembly.load(robot)
    blind = dataclasses.replace(
        feeling, model=dataclasses.replace(feeling.model, contact=None, orientation=None))
    for course in courses:
        for name, blueprint in (("feeling", feeling), ("blind", blind)):
            for seed in range(seeds):
                report = rig.walk(blueprint, terrain=course, speed=_SPEED, duration=_SECONDS, seed=seed)
                sys.stdout.write(
                    f"{course:10} {name:8} seed {seed}: {report['distance_m'] / (_SPEED * _SECONDS):5.2f} of the way, "
                    f"tilt {report['max_tilt_deg']:4.1f} deg, yaw {report['heading_change_deg']:5.1f} deg"
                    f"{', fell' if report['fell'] else ''}\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
