"""Figures 9 to 11 of PPS, drawn from what walks: the phases of a stance, one foot's trajectory, the body's of two."""

from collections.abc import Sequence
from itertools import groupby

from robotwalk.figure import Figure
from robotwalk.gait import Sector
from robotwalk.pseudo_physics import Particle, Stage, step_at

_WIDTH, _MARGIN, _LEFT, _RIGHT = 860.0, 20.0, 90.0, 840.0
_GREY, _PALE, _FOOT, _OTHER, _BODY = "#888888", "#dddddd", "#3b6ea5", "#7fa7cf", "#c0392b"
_COLOURS = {Stage.SWING: "#e8833a", Stage.RECEPTION: "#3b6ea5", Stage.PROPULSION: "#8fb8de"}
_BAR, _HALF, _PANEL = 20.0, 62.0, 240.0
_SAMPLES, _TURNS = 120, 2

EVEN = (Sector(0.0, 0.5, 0.5),)  # PPS figure 9a: swing as long as stance
LONG_SWING = (Sector(0.0, 2.0 / 3.0, 1.0 / 3.0),)  # figure 9b
_BETWEEN_FEET = 0.25  # turns, in figure 11; at half a turn two such feet would cancel each other


def draw_pseudo_physics(period: float) -> Figure:
    """Return the figures, for a period of the gait in s."""
    figure = Figure(_WIDTH, 50.0 + 3.0 * _PANEL)
    figure.text((_MARGIN, 28.0), f"pseudo-physics (PPS figures 9 to 11), two turns of {period:g} s", size=18.0)
    for place, (stage, colour) in enumerate(_COLOURS.items()):
        x = 530.0 + 110.0 * place
        figure.box(x, 17.0, 12.0, 12.0, colour)
        figure.text((x + 18.0, 27.0), stage.value)
    even, long_swing = (_heights(sectors, period) for sectors in (EVEN, LONG_SWING))
    shift = round(_BETWEEN_FEET * _SAMPLES)
    other = [even[(sample - shift) % _SAMPLES] for sample in range(_SAMPLES)]
    body = [0.5 * (a + b) for a, b in zip(even, other, strict=True)]
    _panel(figure, 50.0, "9a, 10a: swing as long as stance: nearly a sine", [EVEN], [(even, _FOOT)])
    _panel(figure, 50.0 + _PANEL, "9b, 10b: swing 2/3 of the turn: arcs of free flight", [LONG_SWING], [
        (long_swing, _FOOT)])
    _panel(
        figure, 50.0 + 2.0 * _PANEL, "11: two feet of 9a a quarter of a turn apart, each as if alone; in red the body",
        [EVEN, (EVEN[0]._replace(start=_BETWEEN_FEET),)], [(even, _FOOT), (other, _OTHER), (body, _BODY)])
    return figure


def _heights(sectors: Sequence[Sector], period: float) -> list[float]:
    """Return a turn of a foot's steady particle, m over the preferred height."""
    return [Particle.steady(sectors, sample / _SAMPLES, period).height for sample in range(_SAMPLES)]


def _panel(
    figure: Figure, top: float, title: str, feet: Sequence[Sequence[Sector]],
    curves: Sequence[tuple[Sequence[float], str]],
) -> None:
    """Draw feet's phases as bars, and curves of heights, a turn each, below them."""
    figure.text((_MARGIN, top + 14.0), title)
    y = top + 24.0
    for sectors in feet:
        stages = (step_at(sectors, (sample + 0.5) / _SAMPLES % 1.0).stage for sample in range(_TURNS * _SAMPLES))
        begin = 0
        for stage, samples in groupby(stages):
            end = begin + sum(1 for _ in samples)
            figure.box(_at(begin), y, _at(end) - _at(begin), _BAR - 4.0, _COLOURS[stage])
            begin = end
        y += _BAR
    middle = y + _HALF + 12.0
    largest = max(max(map(abs, curve)) for curve, _ in curves)
    figure.line(((_LEFT, middle), (_RIGHT, middle)), _PALE)
    for curve, colour in curves:
        points = [
            (_at(sample), middle - _HALF * curve[sample % _SAMPLES] / largest)
            for sample in range(_TURNS * _SAMPLES + 1)]
        figure.line(points, colour, 2.5 if colour == _BODY else 1.5)
    for sign in (1, -1):
        place = _LEFT - 8.0, middle - sign * _HALF + 4.0
        figure.text(place, f"{sign * 1e3 * largest:+.0f} mm", "end", 10.0, _GREY)
    figure.text((_LEFT - 8.0, middle + 4.0), "preferred", "end", 10.0, _GREY)


def _at(sample: int) -> float:
    return _LEFT + (_RIGHT - _LEFT) * sample / (_TURNS * _SAMPLES)
