"""The `robotwalk` command's commands."""

from cyclopts import App

import robotwalk

_EPILOGUE = (
    "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 bad config, 4 bus or servo not found, 5 safety stop or fall, "
    "129/130/143 after a hang-up, Ctrl-C or SIGTERM and a safe stop."
)

app = App(
    name="robotwalk",
    help="Walk a legged servo robot, or its simulation through the same bytes.",
    help_epilogue=_EPILOGUE,
    version=robotwalk.__version__,
    suppress_keyboard_interrupt=False,
)
# Loaded when called: `--help` need not wait for MuJoCo.
app.command("robotwalk.cli.walk:walk", help="Stand up, walk, stop and sit: in simulation, or on a bus.")
app.command("robotwalk.cli.teleop:teleop", help="Drive: by keys, a gamepad, or a program.")
app.command("robotwalk.cli.stop:stop", help="Stop every robot that runs, or one: hold it where it is.")
app.command("robotwalk.cli.stop:clear", help="Let robots go that were told to stop: they sit down.")
app.command("robotwalk.cli.replay:replay", help="Run the loop of a log again, and compare every byte that it sends.")
app.command("robotwalk.cli.sim:sim", help="Serve a simulated robot as a device, in real time.")
app.command("robotwalk.cli.servo:app", name="servo", help="Look after single servos on one bus.")
app.command("robotwalk.cli.calibrate:calibrate", help="Find out how each servo sits in its joint, by hand.")
app.command("robotwalk.cli.check:check", help="Check a robot's files: reach, balance, bus time.")
app.command("robotwalk.cli.doctor:doctor", help="Look at this computer, and say what mends it.")
app.command("robotwalk.cli.service:app", name="service", help="Have this computer offer a robot after every boot.")
app.command("robotwalk.cli.gait:app", name="gait", help="Look at a gait: in numbers, and drawn.")
app.command("robotwalk.cli.list:app", name="list", help="List the bundled robots, servos or gaits.")
app.command("robotwalk.cli.bench:app", name="bench", help="Measure the tick or the simulation on this computer.")
