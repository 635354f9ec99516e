"""A gait, drawn: its circles and needles, its diagram, its supports, and what pseudo-physics makes of it (PPS)."""

import math

from robotwalk.figure import Figure, on_circle
from robotwalk.gait import Gait, Support
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.pseudo_physics import Particle
from robotwalk.support import centre_of_mass, support_polygon

_WIDTH = 860.0
_MARGIN = 20.0
_INK, _GREY, _PALE = "#222222", "#888888", "#dddddd"
_SWING, _STANCE, _POLYGON, _NEEDLE = "#e8833a", "#3b6ea5", "#cfe0f1", "#c0392b"
_CIRCLE = 34.0
_CELL = 102.0  # of circles and of supports
_ROW = 22.0
_SAMPLES = 120


def draw_gait(model: RobotModel, gait: Gait, phase: float) -> Figure:
    """Return the figure of a gait on a robot, its needles at a phase."""
    cells = int((_WIDTH - 2.0 * _MARGIN) // _CELL)
    circles = -(-len(gait.feet) // cells) * (_CELL + 8.0)
    diagram = len(gait.feet) * _ROW + 56.0
    supports = -(-len(gait.supports) // cells) * (_CELL + 20.0) + 30.0
    figure = Figure(_WIDTH, 60.0 + circles + diagram + supports + 190.0)
    figure.text((_MARGIN, 30.0), f"{gait.name}, {model.name}", size=18.0)
    figure.text(
        (_WIDTH - _MARGIN, 30.0),
        f"period {gait.slowest_period:.2f} s, down to {gait.fastest_period:.2f} s at speed", "end")
    _circles(figure, model, gait, phase, 44.0, cells)
    _diagram(figure, model, gait, phase, 44.0 + circles)
    _supports(figure, model, gait, 44.0 + circles + diagram, cells)
    _heights(figure, model, gait, 44.0 + circles + diagram + supports)
    return figure


def _circles(figure: Figure, model: RobotModel, gait: Gait, phase: float, top: float, cells: int) -> None:
    for index, (leg, sectors) in enumerate(zip(model.legs, gait.feet, strict=True)):
        x = _MARGIN + (index % cells + 0.5) * _CELL
        y = top + (index // cells) * (_CELL + 8.0) + _CIRCLE + 8.0
        figure.disc((x, y), _CIRCLE, _STANCE)
        for sector in sectors:
            figure.wedge((x, y), _CIRCLE, sector.start, sector.length, _SWING)
        figure.line(((x, y), on_circle((x, y), _CIRCLE + 4.0, phase)), _INK, 2.5)
        figure.disc((x, y), 3.5, _INK)
        figure.text((x, y + _CIRCLE + 17.0), leg.name, "middle")


def _diagram(figure: Figure, model: RobotModel, gait: Gait, phase: float, top: float) -> None:
    left, right = _MARGIN + 50.0, _WIDTH - _MARGIN - 60.0
    width, bottom = right - left, top + 20.0 + len(gait.feet) * _ROW
    figure.text((_MARGIN, top + 10.0), "stance (blue) and swing (orange) over one turn; at the right, the duty factor")
    for index, (leg, sectors) in enumerate(zip(model.legs, gait.feet, strict=True)):
        y = top + 20.0 + index * _ROW
        figure.text((left - 8.0, y + 15.0), leg.name, "end")
        figure.box(left, y + 3.0, width, _ROW - 6.0, _STANCE)
        for sector in sectors:
            for start in (sector.start, sector.start - 1.0):  # what runs past the end comes in at the begin
                begin, end = max(start, 0.0), min(start + sector.length, 1.0)
                if end > begin:
                    figure.box(left + width * begin, y + 3.0, width * (end - begin), _ROW - 6.0, _SWING)
        figure.text((right + 8.0, y + 15.0), f"{1.0 - sum(sector.length for sector in sectors):.2f}")
    for tick in range(5):
        x = left + 0.25 * tick * width
        figure.line(((x, bottom), (x, bottom + 4.0)), _GREY)
        figure.text((x, bottom + 17.0), f"{0.25 * tick:g}", "middle", 11.0, _GREY)
    x = left + width * phase
    figure.line(((x, top + 18.0), (x, bottom + 2.0)), _INK, 2.5)


def _supports(figure: Figure, model: RobotModel, gait: Gait, top: float, cells: int) -> None:
    figure.text(
        (_MARGIN, top + 10.0),
        "who stands in each part of the turn, seen from above, ahead is up; the cross is the centre of mass")
    reach = max(math.hypot(leg.rest_foot.x, leg.rest_foot.y) for leg in model.legs)
    centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
    for index, support in enumerate(gait.supports):
        x = _MARGIN + (index % cells + 0.5) * _CELL
        y = top + 22.0 + (index // cells) * (_CELL + 20.0) + 0.5 * _CELL
        scale = 0.42 * _CELL / reach
        _support(figure, model, support, (x, y), scale)
        cx, cy = x - scale * centre.y, y - scale * centre.x
        figure.line(((cx - 5.0, cy), (cx + 5.0, cy)), _NEEDLE, 2.0)
        figure.line(((cx, cy - 5.0), (cx, cy + 5.0)), _NEEDLE, 2.0)
        span = f"{support.start:.2f} to {support.start + support.length:.2f}"
        figure.text((x, y + 0.5 * _CELL + 8.0), span, "middle", 11.0, _GREY)


def _support(figure: Figure, model: RobotModel, support: Support, middle: tuple[float, float], scale: float) -> None:
    feet = [leg.rest_foot for leg in model.legs]
    places = [(middle[0] - scale * foot.y, middle[1] - scale * foot.x) for foot in feet]
    standing = [foot for foot, stands in zip(feet, support.standing, strict=True) if stands]
    if support_polygon(standing):
        # Round their middle, the corners are in order.
        x, y = sum(foot.x for foot in standing) / len(standing), sum(foot.y for foot in standing) / len(standing)
        ordered = sorted(standing, key=lambda foot: math.atan2(foot.y - y, foot.x - x))
        figure.area([(middle[0] - scale * foot.y, middle[1] - scale * foot.x) for foot in ordered], _POLYGON)
    elif len(standing) == 2:
        figure.line([(middle[0] - scale * foot.y, middle[1] - scale * foot.x) for foot in standing], _POLYGON, 3.0)
    for place, stands in zip(places, support.standing, strict=True):
        figure.disc(place, 5.0, _STANCE if stands else _PALE)


def _heights(figure: Figure, model: RobotModel, gait: Gait, top: float) -> None:
    """Draw what each foot's particle does, and the body as their mean (PPS figures 10 and 11)."""
    left, right, middle, half = _MARGIN + 50.0, _WIDTH - _MARGIN - 60.0, top + 90.0, 66.0
    period = gait.slowest_period
    figure.text((_MARGIN, top + 10.0), "height by pseudo-physics: one particle a foot, and in red their weighted mean")
    curves = []
    for sectors in gait.feet:
        moments = [Particle.steady(sectors, sample / _SAMPLES, period) for sample in range(_SAMPLES + 1)]
        curves.append(tuple(moment.height for moment in moments))
    weights = model.reactions.weights
    mean = [sum(weight * height for weight, height in zip(weights, moment, strict=True))
            for moment in zip(*curves, strict=True)]
    largest = max(max(map(abs, curve)) for curve in curves)
    figure.line(((left, middle), (right, middle)), _PALE)
    for curve, colour, width in [*((curve, _GREY, 1.0) for curve in dict.fromkeys(curves)), (mean, _NEEDLE, 2.5)]:
        figure.line(
            [(left + (right - left) * k / _SAMPLES, middle - half * h / largest) for k, h in enumerate(curve)],
            colour, width)
    for sign in (1, -1):
        figure.text((left - 8.0, middle - sign * half + 4.0), f"{sign * 1e3 * largest:+.0f} mm", "end", 10.0, _GREY)
    figure.text((left - 8.0, middle + 4.0), "wanted", "end", 10.0, _GREY)
