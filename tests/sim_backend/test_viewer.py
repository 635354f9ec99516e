"""The page of `walk --view`, in a real browser."""

import json
import shutil
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
from PIL import Image

pytest.importorskip("mjviser", reason="the extra robotwalk[view] is not installed")
CHROMIUM = shutil.which("chromium")
URL = "http://127.0.0.1:8080"

pytestmark = pytest.mark.xdist_group("viewer")  # there is one such port


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")
def test_a_browser_sees_the_robot_walk_and_stdout_is_left_to_the_data(tmp_path: Path) -> None:
    walk = subprocess.Popen(
        [sys.executable, "-c", "from robotwalk.cli.main import main; main()", "walk", "hexapod", "--duration", "3",
         "--view", "--json"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        wait_for_page(walk)
        assert CHROMIUM is not None
        picture = tmp_path / "page.png"
        subprocess.run(
            [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", f"--user-data-dir={tmp_path / 'profile'}",
             "--virtual-time-budget=8000", "--timeout=6000", "--window-size=320,240", f"--screenshot={picture}", URL],
            capture_output=True, timeout=60, check=True)
        out, err = walk.communicate(timeout=60)
    finally:
        walk.kill()
    assert walk.returncode == 0, err
    assert out.startswith('{"schema": 1')
    assert out.count("\n") == 1
    with Image.open(picture) as page:
        orange = sum(count for count, (r, g, b) in page.convert("RGB").getcolors(1 << 24)
                     if r > 180 and 90 < g < 190 and b < 120)
    assert orange > 30, "the body is orange"


def test_a_served_robot_has_a_page_too(tmp_path: Path) -> None:
    sim = subprocess.Popen(
        [sys.executable, "-c", "from robotwalk.cli.main import main; main()", "sim", "hexapod", "--pty",
         str(tmp_path / "dev"), "--view"], stdout=subprocess.PIPE, text=True)
    try:
        assert sim.stdout is not None
        page = json.loads(sim.stdout.readline())["view"]
        with urllib.request.urlopen(page, timeout=20.0) as answer:
            assert answer.status == 200
    finally:
        sim.terminate()
        assert sim.wait(20) == 143
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(page, timeout=20.0)


def wait_for_page(walk: subprocess.Popen[str]) -> None:
    """Wait until the page is served. It waits for a browser, which this is not."""
    deadline = time.monotonic() + 30.0
    while True:
        try:
            with urllib.request.urlopen(URL, timeout=1.0) as page:
                assert page.status == 200
                return
        except OSError:
            assert walk.poll() is None, walk.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.1)
