"""`robotwalk stop ROBOT` reaches the loops of that robot, and no other."""

import json
import os
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotwalk.cli.stop import main
from robotwalk.errors import UsageError
from robotwalk.process.shared import Mailbox, create


@pytest.fixture
def loops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, Mailbox]]:
    """Make up the loops of two robots, which heed what they are told."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    shared = {name: create(name)[0] for name in ("hexapod", "my-hexapod")}
    boxes = {name: Mailbox(descriptor) for name, descriptor in shared.items()}
    over = threading.Event()

    def heed() -> None:
        while not over.wait(0.002):
            for box in boxes.values():
                if box.stop.number > box.heed.number:
                    box.heed.write(b"holds", box.stop.number)

    thread = threading.Thread(target=heed)
    thread.start()
    yield boxes
    over.set()
    thread.join()
    for descriptor in shared.values():
        os.close(descriptor)


def told(loops: dict[str, Mailbox]) -> dict[str, int]:
    return {name: box.stop.number for name, box in loops.items()}


def test_one_robot_is_told_by_its_name_its_loop_or_its_file(
    loops: dict[str, Mailbox], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text("# mine\nschema: 1\nname: hexapod  # of six legs\n")
    for robot in ("hexapod", f"hexapod-{os.getpid()}", str(file)):
        before = told(loops)
        assert main(["stop", robot, "--json"]) == 0
        assert [loop["loop"] for loop in json.loads(capsys.readouterr().out)["loops"]] == [f"hexapod-{os.getpid()}"]
        assert told(loops) == {**before, "hexapod": before["hexapod"] + 1}
    assert main(["clear", "my-hexapod"]) == 0
    assert told(loops) == {"hexapod": 3, "my-hexapod": 1}
    assert main(["stop"]) == 0
    assert told(loops) == {"hexapod": 4, "my-hexapod": 2}


def test_who_names_no_robot_that_runs_is_told_which_do(
    loops: dict[str, Mailbox], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stop", "octopod"]) == 4
    pid = os.getpid()
    assert capsys.readouterr().err == (
        f"robotwalk: no loop of octopod runs here; there are hexapod-{pid}, my-hexapod-{pid}\n")
    with pytest.raises(UsageError, match="`robotwalk stop` alone is for every robot"):
        main(["stop", "nowhere.yaml"])
    assert told(loops) == {"hexapod": 0, "my-hexapod": 0}
