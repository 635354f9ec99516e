"""`robotwalk gait`: a gait in numbers, and drawn."""

from pathlib import Path
from typing import Any

from cyclopts import App

from robotwalk import assembly, checks
from robotwalk.cli.options import Json
from robotwalk.cli.output import say, write_json, write_table
from robotwalk.config import library
from robotwalk.errors import UsageError
from robotwalk.gait import Gait
from robotwalk.gait_figure import draw_gait
from robotwalk.plausibility import Plausibility, plausibility
from robotwalk.pseudo_physics_figure import draw_pseudo_physics

app = App(name="gait", help="Look at a gait.")


@app.command
def show(
    gait: str, /, *, robot: str | None = None, phase: float = 0.0, svg: Path | None = None, png: Path | None = None,
    json: Json = False,
) -> int:
    """Say what a gait is on a robot, and what it asks of its servos; draw it.

    Parameters
    ----------
    gait
        A name from `robotwalk list gaits`, or the path of a YAML file.
    robot
        A bundled name, or the path of a YAML file. Default: the first bundled robot that the gait fits.
    phase
        Of the needles that are drawn, in turns.
    svg
        Draw the circles, the gait diagram, the support polygons and the height by pseudo-physics here.
    png
        The same as PNG.
    """
    drawn = _pictures(svg, png)
    if not 0.0 <= phase <= 1.0:
        raise UsageError(f"--phase is 0 to 1 turn, not {phase}")
    blueprint, shown = _found(gait, robot)
    judged = plausibility(blueprint.model, shown, blueprint.strengths)
    for path in drawn:
        draw_gait(blueprint.model, shown, phase).save(path)
    if json:
        write_json(_fields(blueprint, shown, judged) | {"drawn": [str(path) for path in drawn]})
    else:
        _show(blueprint, shown, judged)
    return 0


@app.command
def pseudo_physics(
    *, period: float = 0.8, svg: Path | None = None, png: Path | None = None, json: Json = False,
) -> int:
    """Draw what pseudo-physics makes of a step: the phases of a stance, and the height that each foot gives (PPS).

    Parameters
    ----------
    period
        Of the gait, in seconds.
    svg
        Draw figures 9 to 11 of PPS here.
    png
        The same as PNG.
    """
    drawn = _pictures(svg, png)
    if not 0.0 < period <= 60.0:
        raise UsageError(f"--period is over 0 and up to 60 s, not {period}")
    if not drawn:
        raise UsageError("say where to draw: --svg FILE or --png FILE")
    figure = draw_pseudo_physics(period)
    for path in drawn:
        figure.save(path)
    if json:
        write_json({"period_s": period, "drawn": [str(path) for path in drawn]})
    else:
        say(f"drawn: {', '.join(map(str, drawn))}")
    return 0


def _pictures(svg: Path | None, png: Path | None) -> list[Path]:
    """Return where to draw.

    Raises:
        UsageError: a name does not fit its kind.
    """
    for path, suffix in ((svg, ".svg"), (png, ".png")):
        if path is not None and path.suffix != suffix:
            raise UsageError(f"{path} should end in {suffix}")
    return [path for path in (svg, png) if path is not None]


def _found(gait: str, robot: str | None) -> tuple[assembly.Blueprint, Gait]:
    """Return the robot and the gait on it.

    Raises:
        UsageError: there is no such gait, or no such robot, or they do not fit.
    """
    for name in library.names("robots") if robot is None else [robot]:
        blueprint = assembly.load(name)
        if not library.is_path(gait):
            found = blueprint.gaits.get(gait)
        else:
            own = assembly.load_gaits({gait: library.open_document("gaits", gait)}, blueprint.model)
            found = next(iter(own.values()), None)
        if found is not None:
            return blueprint, found
    if robot is None:
        raise UsageError(f"no gait {gait!r} fits any bundled robot; see `robotwalk list gaits`")
    raise UsageError(f"{robot} has no gait {gait!r}; it has {', '.join(assembly.load(robot).gaits)}")


def _fields(blueprint: assembly.Blueprint, gait: Gait, judged: Plausibility) -> dict[str, Any]:
    legs = [leg.name for leg in blueprint.model.legs]
    return {
        "gait": gait.name,
        "robot": blueprint.model.name,
        "slowest_period_s": round(gait.slowest_period, 4),
        "fastest_period_s": round(gait.fastest_period, 4),
        "top_speed_mps": round(checks.gait_speed(blueprint.model, gait), 4),
        "load": round(judged.load, 3),
        "refused": None if judged.plausible else judged.complaint(),
        "feet": {
            leg: {"swing": [[round(sector.start, 6), round(sector.start + sector.length, 6)] for sector in sectors],
                  "duty": round(1.0 - sum(sector.length for sector in sectors), 6)}
            for leg, sectors in zip(legs, gait.feet, strict=True)},
        "supports": [
            {"start": round(support.start, 6), "length": round(support.length, 6),
             "standing": [leg for leg, stands in zip(legs, support.standing, strict=True) if stands]}
            for support in gait.supports],
    }


def _show(blueprint: assembly.Blueprint, gait: Gait, judged: Plausibility) -> None:
    write_table(
        f"{gait.name} of {blueprint.model.name}", ["foot", "swings (turns)", "duty factor"],
        [[leg.name, ", ".join(f"{s.start:.3f} to {s.start + s.length:.3f}" for s in sectors),
          f"{1.0 - sum(s.length for s in sectors):.3f}"]
         for leg, sectors in zip(blueprint.model.legs, gait.feet, strict=True)])
    say(f"period {gait.slowest_period:.2f} s, at speed down to {gait.fastest_period:.2f} s; "
        f"at most {checks.gait_speed(blueprint.model, gait):.3f} m/s")
    say(f"the servos' load: {judged.load:.2f} of what they can give" if judged.plausible
        else f"refused: {judged.complaint()}")
