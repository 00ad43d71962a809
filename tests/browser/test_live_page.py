"""The live notebook in a browser: a slider moves the plan's value; errors are texts."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "live" / "two_heads.py"
PHONE = {"width": 390, "height": 844}
SLOW = 120_000
"""Most ms that a busy machine may take to answer; how soon it does is not what is tested."""
VALUE = re.compile(r"travel (\d+\.\d\d) mm")


@pytest.fixture(scope="module")
def address():
    """Serve the notebook on a free port of this machine."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "marimo", "-q", "run", str(NOTEBOOK), "--headless", "--no-token"]
    command += ["--host", "127.0.0.1", "--port", str(port)]
    server = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    url = f"http://127.0.0.1:{port}"
    try:
        _wait(url, server)
        yield url
    finally:
        os.killpg(server.pid, signal.SIGTERM)
        server.wait(timeout=10)


def _wait(url, server):
    end = time.monotonic() + SLOW / 1000
    while time.monotonic() < end and server.poll() is None:
        try:
            with urllib.request.urlopen(f"{url}/health", timeout=1):
                return
        except OSError:
            time.sleep(0.1)
    pytest.fail("the notebook's server did not start")


@pytest.fixture(scope="module")
def live_page(browser, address):
    """Open the notebook as a phone shows it; fails if the page wrote an error to its console."""
    context, errors = browser.new_context(viewport=PHONE), []
    page = context.new_page()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.goto(address)
    page.get_by_text(VALUE).first.wait_for(timeout=SLOW)
    yield page
    context.close()
    assert not errors


def value_of(page):
    return float(VALUE.search(page.get_by_text(VALUE).first.inner_text())[1])


def wait_for_plan(page, holes):
    name = f"random-{holes}-s1: plan of {holes} holes for two heads"
    page.get_by_role("img", name=name).first.wait_for(timeout=SLOW)


def test_a_slider_moves_value_plan_and_ladder(live_page):
    before = value_of(live_page)
    wait_for_plan(live_page, holes=18)
    live_page.get_by_role("slider").first.press("ArrowRight")
    wait_for_plan(live_page, holes=19)
    assert value_of(live_page) != before
    ladder = live_page.get_by_role("img", name=re.compile("^bounds in mm: .*held-karp"))
    ladder.first.wait_for(timeout=SLOW)


def test_a_gap_that_no_plan_keeps_is_said_in_words(live_page):
    live_page.get_by_role("slider").nth(4).press("End")
    live_page.get_by_text("No plan is allowed").first.wait_for(timeout=SLOW)
    assert live_page.get_by_text("Traceback").count() == 0
    width = live_page.evaluate("document.documentElement.scrollWidth")
    assert width <= 390
