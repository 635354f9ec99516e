"""The supervisor's states, drawn from its own table: a Mermaid diagram, as docs/safety.md shows it.

    python -m robotwalk.state_figure
"""

import sys

from robotwalk.supervisor import BY_ITSELF, TRANSITIONS, State


def mermaid() -> str:
    """Return the diagram's text: what may be asked for, and in brackets what comes about by itself."""
    arrows: dict[tuple[State, State], list[str]] = {}
    for (before, request), after in TRANSITIONS.items():
        if before is not after:
            arrows.setdefault((before, after), []).append(request.value)
    for before, after, why in BY_ITSELF:
        arrows.setdefault((before, after), []).append(f"({why})")
    lines = ["stateDiagram-v2", f"    [*] --> {State.STOP.name}"]
    lines += [
        f"    {before.name} --> {after.name}: {', '.join(why)}" for (before, after), why in arrows.items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(mermaid())
