"""`robotwalk list`: what is bundled."""

from textwrap import fill
from typing import Any

from cyclopts import App

from robotwalk import assembly
from robotwalk.cli.options import Json
from robotwalk.cli.output import say, write_json, write_table
from robotwalk.config import library
from robotwalk.config.schema import RobotConfig
from robotwalk.gait_rules import fitted, read_gait
from robotwalk.model import RobotModel

app = App(name="list", help="List the bundled robots, servos, IMUs, gaits or terrains, or the faults of a simulation.")


@app.command
def robots(*, json: Json = False) -> None:
    """List the robots."""
    rows = []
    for name in library.names("robots"):
        config = _robot(name)
        joints = sum(len(leg.joints) for leg in config.skeleton.legs.values())
        rows.append({
            "name": name, "description": config.description, "legs": len(config.skeleton.legs), "joints": joints})
    _show("robots", rows, json)


@app.command
def servos(*, json: Json = False) -> None:
    """List the servo models."""
    models = [assembly.load_servo(name) for name in library.names("servos")]
    _show("servos", [
        {"name": model.name, "description": model.description, "protocol": model.protocol,
         "model_number": model.model_number}
        for model in models
    ], json)


@app.command
def imus(*, json: Json = False) -> None:
    """List the kinds of IMU."""
    models = [library.open_document("imus", name).validate(assembly.ImuModel) for name in library.names("imus")]
    _show("imus", [
        {"name": model.name, "description": model.description, "frames": model.frames, "rate_hz": model.rate_hz,
         "baud_rates": list(model.baud_rates)}
        for model in models
    ], json)


@app.command
def gaits(*, json: Json = False) -> None:
    """List the gaits, each with the bundled robots that it fits."""
    legs = {name: RobotModel.from_config(_robot(name)).legs for name in library.names("robots")}
    rows = []
    for file in library.names("gaits"):
        gait = read_gait(library.open_document("gaits", file))
        fits = [robot for robot, its in legs.items() if fitted(gait, its) is not None]
        rows.append({"name": gait.name, "description": gait.description, "robots": fits})
    _show("gaits", rows, json)


@app.command
def terrains(*, json: Json = False) -> None:
    """List the terrains that --terrain takes."""
    rows = []
    for name in library.names("terrains"):
        terrain = assembly.load_terrain(name)
        kinds = dict.fromkeys(element.kind() for element in terrain.elements)
        rows.append({
            "name": name, "description": terrain.config.description, "elements": list(kinds),
            "length_m": round(terrain.length, 6)})
    _show("terrains", rows, json)


@app.command
def faults(*, json: Json = False) -> None:
    """List the faults that a script for --faults may hold, with their keys."""
    rows = assembly.explain_faults()
    if json:
        write_json({"faults": rows})
        return
    for row in rows:
        say(f"{row['name']}\n{fill(row['description'], 100, initial_indent='    ', subsequent_indent='    ')}")
        for key, facts in row["keys"].items():
            default = "" if facts.get("default") is None else f", {facts['default']} if left out"
            say(f"        {key + ('' if facts['required'] else '?'):15}{facts['description']}{default}")
    say("A script is a YAML list of these, each as {fault: NAME, at: SECONDS, ...}; a key with ? may be left out.")


def _robot(name: str) -> RobotConfig:
    return library.open_document("robots", name).validate(RobotConfig)


def _show(kind: str, rows: list[dict[str, Any]], json: bool) -> None:
    if json:
        write_json({kind: rows})
        return
    columns = list(rows[0])
    cells = [[", ".join(map(str, v)) if isinstance(v, list) else str(v) for v in row.values()] for row in rows]
    write_table(kind, columns, cells)
