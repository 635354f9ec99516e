"""The same courses with and without feeling: `python -m tests.walk.courses [ROBOT] [SEEDS] [TERRAIN ...] [--gait G]`.

One line a walk over 2.25 m: the share of the commanded distance, tilt, yaw, whether it fell.
"""

import argparse
import dataclasses
import sys

from robotwalk import assembly

from . import rig

_COURSES = ("flat", "stairs_25", "stairs_40", "ramp_15", "rough_30", "blocks_60", "patch_02", "drop_50")
_METRES = 2.25


def main() -> None:
    """Walk them all."""
    parser = argparse.ArgumentParser(prog="python -m tests.walk.courses", description=__doc__)
    parser.add_argument("robot", nargs="?", default="hexapod")
    parser.add_argument("seeds", nargs="?", type=int, default=10)
    parser.add_argument("courses", nargs="*", default=_COURSES, metavar="TERRAIN")
    parser.add_argument("--gait", help="its name (the robot's default)")
    parser.add_argument("--speed", type=float, default=0.06, help="m/s (0.06)")
    arguments = parser.parse_args()
    feeling = assembly.load(arguments.robot)
    blind = dataclasses.replace(
        feeling, model=dataclasses.replace(feeling.model, contact=None, orientation=None, levelling=None))
    for course in arguments.courses:
        for name, blueprint in (("feeling", feeling), ("blind", blind)):
            for seed in range(arguments.seeds):
                report = rig.walk(
                    blueprint, terrain=course, speed=arguments.speed, duration=_METRES / arguments.speed, seed=seed,
                    gait=arguments.gait)
                sys.stdout.write(
                    f"{course:10} {name:8} seed {seed}: {report['distance_m'] / _METRES:5.2f} of the way, "
                    f"tilt {report['max_tilt_deg']:4.1f} deg, yaw {report['heading_change_deg']:5.1f} deg"
                    f"{', fell' if report['fell'] else ''}\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
