"""The player in a browser: every control changes the step, and a run over 60 holes is small and quick."""

from dataclasses import replace

import pytest

from cutgap.instances.formats import write_instance
from cutgap.instances.generate import generate
from cutgap.views.cli import main

DESKTOP, PHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}
LARGEST = 2_000_000
QUICK_MS = 1000


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Pages of one run of each kind: by name, one head and two heads of 60 holes, and 14 for the passes."""
    folder = tmp_path_factory.mktemp("pages")
    whole = generate("random", holes=60, seed=7)
    one = replace(whole, heads=whole.heads[:1])
    few = replace(one, contours=one.contours[:14])
    runs = {
        "tour": (one, []),
        "split": (whole, []),
        "free": (whole, ["--method", "free"]),
        "contour-dp": (few, ["--method", "contour-dp"]),
    }
    for name, (instance, options) in runs.items():
        write_instance(instance, folder / f"{name}.json")
        assert main(["play", str(folder / f"{name}.json"), "-o", str(folder / f"{name}.html"), *options]) == 0
    return {name: folder / f"{name}.html" for name in runs}


KINDS = ("tour", "split", "free", "contour-dp")


def place(page):
    """Return the number of the step shown, from 1, and how many there are."""
    return tuple(int(part) for part in page.inner_text("#place").split("/"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_is_small_and_every_step_is_quick(pages, open_page, kind):
    assert pages[kind].stat().st_size <= LARGEST
    page = open_page(pages[kind])
    loaded = page.evaluate("performance.getEntriesByType('navigation')[0].domContentLoadedEventEnd")
    assert loaded <= QUICK_MS
    # From a click until the changed page is painted, at a few steps over the run.
    slowest = page.evaluate(
        """async () => {
          const frame = () => new Promise(done => requestAnimationFrame(() => setTimeout(done)));
          let slowest = 0;
          for (let i = 0; i < 20; i++) {
            go(Math.floor(i * steps.length / 20));
            const start = performance.now();
            document.getElementById("next").click();
            await frame();
            slowest = Math.max(slowest, performance.now() - start);
          }
          return slowest;
        }"""
    )
    assert slowest <= QUICK_MS


@pytest.mark.parametrize("kind", KINDS)
def test_every_step_can_be_shown(pages, open_page, kind):
    page = open_page(pages[kind])
    count = place(page)[1]
    for switch in ("#numbers", "#incumbent"):
        page.check(switch)
    page.evaluate("for (let i = 0; i < steps.length; i++) go(i)")
    assert place(page) == (count, count)
    assert page.evaluate("document.querySelectorAll('svg [x1=NaN], svg [cx=NaN], svg [y1=NaN]').length") == 0
    assert page.locator("#picture .best").count() > 0


@pytest.mark.parametrize("kind", KINDS)
def test_the_run_ends_with_its_plan_and_figures_are_whole(pages, open_page, kind):
    page = open_page(pages[kind], viewport=PHONE)
    page.click("#last")
    assert page.locator("#picture .best, #picture .edge").count() > 0
    cut = """[...document.querySelectorAll('#chart text')].filter(
        text => text.getBoundingClientRect().left < text.ownerSVGElement.getBoundingClientRect().left)"""
    assert page.evaluate(f"{cut}.map(text => text.textContent)") == []


def test_buttons_change_the_step(pages, open_page):
    page = open_page(pages["tour"])
    count = place(page)[1]
    before = page.inner_text("#text"), page.inner_html("#picture")
    page.click("#next")
    assert place(page) == (2, count)
    page.click("#next")
    assert (page.inner_text("#text"), page.inner_html("#picture")) != before
    page.click("#back")
    assert place(page) == (2, count)
    page.click("#last")
    assert place(page) == (count, count)
    page.click("#next")
    assert place(page) == (count, count)
    page.click("#first")
    assert place(page) == (1, count)


def test_the_slider_and_the_chart_go_to_a_step(pages, open_page):
    page = open_page(pages["split"])
    count = place(page)[1]
    page.fill("#slider", "7")
    assert place(page) == (8, count)
    box = page.locator("#chart").bounding_box()
    page.mouse.click(box["x"] + box["width"] - 12, box["y"] + 60)
    assert place(page)[0] >= count - 1


def test_keys_change_the_step(pages, open_page):
    page = open_page(pages["contour-dp"])
    count = place(page)[1]
    for key, expected in (("ArrowRight", 2), ("ArrowRight", 3), ("ArrowLeft", 2), ("End", count), ("Home", 1)):
        page.keyboard.press(key)
        assert place(page) == (expected, count)
    page.focus("#slider")
    page.keyboard.press("ArrowRight")
    assert place(page) == (2, count)


def test_it_plays_and_pauses(pages, open_page):
    page = open_page(pages["tour"])
    page.select_option("#pace", "200")
    page.locator("#pace").blur()
    page.evaluate("go(steps.length - 8)")
    page.keyboard.press(" ")
    assert page.get_attribute("#play", "aria-label") == "Pause"
    page.wait_for_function("place > steps.length - 8")
    page.keyboard.press(" ")
    stopped = place(page)
    page.wait_for_timeout(500)
    assert place(page) == stopped
    page.click("#play")
    page.wait_for_function(f"place >= {stopped[0]}")
    page.wait_for_function("place === steps.length - 1", timeout=15000)
    assert page.get_attribute("#play", "aria-label") == "Play"


def test_a_cut_that_is_chosen_is_the_one_that_is_shaded(pages, open_page):
    page = open_page(pages["tour"])
    index = page.evaluate("steps.findIndex(step => step.rows.filter(row => row.left !== null).length > 1)")
    page.evaluate(f"go({index})")
    shaded = []
    for number in (0, 1):
        page.locator("#rows button").nth(number).click()
        assert page.locator("#rows button[aria-pressed=true]").count() == 1
        members = page.evaluate(f"rowsOf(steps[{index}])[{number}].sets[0][1].length")
        assert page.locator("#picture circle.member").count() == members
        shaded.append(page.inner_html("#picture .blob >> xpath=.."))
    assert shaded[0] != shaded[1]


def test_an_edge_tells_its_value(pages, open_page):
    page = open_page(pages["tour"])
    page.evaluate("go(steps.findIndex(step => (step.legs || []).some(leg => leg[2] < 0.999)))")
    index = page.evaluate("steps[place].legs.findIndex(leg => leg[2] < 0.999)")
    page.locator("#picture line.hit").nth(index).dispatch_event("click")
    value = page.evaluate(f"steps[place].legs[{index}][2]")
    assert page.inner_text("#readout").startswith("edge ")
    assert float(page.inner_text("#readout").split(": ")[1]) == pytest.approx(value, abs=1e-3)
    dash = page.evaluate(
        "[...document.querySelectorAll('#picture .edge')].map(e => e.getAttribute('stroke-dasharray'))"
    )
    assert len(set(dash)) > 1


def test_each_kind_shows_its_own_diagram(pages, open_page):
    for kind, shown in (
        ("tour", ()),
        ("split", ("thresholds",)),
        ("free", ("tree",)),
        ("contour-dp", ("states",)),
    ):
        page = open_page(pages[kind])
        page.keyboard.press("End")
        for part in ("thresholds", "tree", "states"):
            assert page.locator(f"#{part}-part").is_visible() == (part in shown)
    page = open_page(pages["split"])
    assert page.locator("#thresholds rect.mark").count() == page.locator("#thresholds circle.mark").count() > 10


@pytest.mark.parametrize("kind", KINDS)
def test_it_fits_a_phone(pages, open_page, kind):
    page = open_page(pages[kind], PHONE)
    for _ in range(4):
        page.click("#next")
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    for control in ("#first", "#back", "#play", "#next", "#last", "#slider"):
        box = page.locator(control).bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= PHONE["width"]
        assert box["y"] + box["height"] <= PHONE["height"]


def test_it_follows_the_dark_mode(pages, open_page):
    light, dark = (open_page(pages["tour"], color_scheme=scheme) for scheme in ("light", "dark"))
    colours = [
        page.evaluate("['backgroundColor', 'color'].map(name => getComputedStyle(document.body)[name])")
        for page in (light, dark)
    ]
    brightness = [[sum(int(n) for n in c[4:-1].split(",")) for c in pair] for pair in colours]
    assert brightness[0][0] > brightness[0][1]
    assert brightness[1][0] < brightness[1][1]


def test_controls_have_names(pages, open_page):
    page = open_page(pages["free"])
    page.keyboard.press("ArrowRight")
    unnamed = page.evaluate(
        """[...document.querySelectorAll("button, input, select, svg[role=img]")].filter(e =>
          !e.getAttribute("aria-label") && !e.textContent.trim() && !e.closest("label")).map(e => e.id)"""
    )
    assert unnamed == []
