"""The page of what happens when something goes wrong: its diagram is the code's, and every fault is in its table."""

import re
from pathlib import Path

from robotwalk.state_figure import mermaid
from robotwalk.supervisor import BY_ITSELF, State, Supervisor
from sim_backend.faults.script import FAULTS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "safety.md").read_text()


def test_the_diagram_is_drawn_from_the_code() -> None:
    (drawn,) = re.findall(r"```mermaid\n(.*?)```", PAGE, re.DOTALL)
    assert drawn == mermaid(), "python -m robotwalk.state_figure prints it"


def test_every_fault_of_the_simulation_has_its_row() -> None:
    rows = set(re.findall(r"^\| `(\w+)`", PAGE, re.MULTILINE))
    assert set(FAULTS) <= rows


def test_what_comes_about_by_itself_is_what_the_supervisor_does() -> None:
    seen = set()
    for state in State:
        for fault in (None, "a fault"):
            for seated in (False, True):
                for helping in (None, "a servo let go"):
                    for earlier in (None, "a fault"):
                        for does in ("step", "hold", "clear"):
                            watched = Supervisor()
                            watched.state, watched.fault = state, earlier
                            if does == "step":
                                watched.step(fault, seated=seated, helping=helping)
                            else:
                                getattr(watched, does)()
                            if watched.state is not state:
                                seen.add((state, watched.state))
    again = Supervisor()
    again.state = State.WALK
    again.step(None, seated=False, helping="a servo let go")
    again.step(None, seated=True)
    assert (again.state, again.step(None, seated=False, standing=True)) == (State.STAND, State.WALK)
    seen.add((State.STAND, State.WALK))
    assert seen == {(before, after) for before, after, _ in BY_ITSELF}
