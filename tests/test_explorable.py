"""Scenes with parameters: the page shows the linkage that kinlib makes, whatever the reader does."""

from fractions import Fraction

import numpy as np
import pytest

import kinlib as kl
from browser import console_messages, requested_urls, screen, wait_until
from kinlib.gallery import FOUR_POSES, THREE_POSES
from kinlib.pictures import (
    Choice,
    Frame,
    Label,
    Pad,
    Rod,
    Samples,
    Seen,
    Slider,
    explorable_scene,
    goldberg_scene,
    sampled_linkages_scene,
    static_files,
)

ALT = "A Goldberg linkage through three poses follows the number z."


@pytest.fixture(scope="module")
def goldberg():
    return goldberg_scene(THREE_POSES, alt=ALT)


@pytest.fixture(scope="module")
def saved(goldberg, tmp_path_factory):
    return goldberg.save(tmp_path_factory.mktemp("scene") / "scene.html")


@pytest.fixture
def scene(chromium, saved):
    """The page of the scene, at rest; the network is not asked, and nothing is complained of."""

    def at(state="", path=saved):
        chromium.get("about:blank")
        console_messages(chromium), requested_urls(chromium)
        chromium.get(path.as_uri() + state)
        wait_until(lambda: chromium.execute_script("return window.kinlib && kinlib.ready"))
        chromium.execute_script("kinlib.pause()")
        return chromium

    yield at
    assert console_messages(chromium) == []
    assert [url for url in requested_urls(chromium) if not url.startswith(("file:", "data:", "blob:", "about:"))] == []


def ask(driver, text, *values):
    return driver.execute_script(text, *values)


def test_a_page_is_not_heavy(saved):
    assert saved.stat().st_size < 1.5e6


def test_axes_and_table_are_those_of_kinlib_at_a_thousand_points(scene):
    """Relative to the size of the axes, z up to 5e-3 from bad places among them."""
    chance = np.random.default_rng(5)
    x, y, choice = chance.uniform(-3, 3, 1000), chance.uniform(-2, 4, 1000), chance.integers(0, 8, 1000)
    places = [[float(x[n]), float(y[n]), int(choice[n])] for n in range(1000)]
    text = """return arguments[0].map(([x, y, n]) => {
        kinlib.set("x", x); kinlib.set("y", y); kinlib.choose("linkage", n);
        return [kinlib.axes(), kinlib.table(), kinlib.parameters] })"""
    axes, tables, parameters = zip(*ask(scene(), text, places), strict=True)
    assert [[p["x"], p["y"], p["linkage"]] for p in parameters] == places
    linkages = kl.goldberg_linkages(*(pose.astype(float) for pose in THREE_POSES), (x, y))
    wanted = np.array([linkage.axes.coeffs for linkage in linkages])[choice, np.arange(1000)]
    scale = np.abs(wanted).max(axis=(1, 2), keepdims=True)
    assert np.abs((np.array(axes) - wanted) / scale).max() < 1e-12
    rows = np.array([np.moveaxis(linkage.denavit_hartenberg(), -1, 0) for linkage in linkages])
    off = np.array(tables) - rows[choice, np.arange(1000)]
    off[..., 1] = (off[..., 1] + np.pi) % (2 * np.pi) - np.pi
    assert np.median(np.abs(off)) < 1e-14
    assert np.percentile(np.abs(off), 99) < 1e-10  # where neighbours are nearly parallel, kinlib's own digits are gone


def test_the_points_of_the_page_are_where_kinlib_moves_them(scene):
    """The frame of the coupler at each pose when that lights up, and one of the axes on the way."""
    driver = scene()
    ask(driver, "kinlib.set('x', 1.2); kinlib.set('y', 1.7)")
    lights = ask(driver, "return JSON.parse(document.getElementById('recording').textContent).cells[0].lights")
    linkage = kl.goldberg_linkages(*THREE_POSES, (1.2, 1.7))[4]
    for (_, frame, _), pose in zip(lights, THREE_POSES, strict=True):
        origin = ask(driver, "kinlib.seek(arguments[0]); return kinlib.points()", frame)[-5]
        np.testing.assert_allclose(origin, kl.act(pose.astype(float), [0, 0, 0]), atol=1e-6)
    start, end = ask(driver, "kinlib.seek(33.25); return kinlib.points().slice(8, 10)")
    length = np.linalg.norm(np.subtract(start, end))
    assert length == pytest.approx(linkage.denavit_hartenberg()[0].distance)


def test_a_bad_place_is_named_and_nothing_is_drawn(scene):
    driver = scene()
    for x, y, word in ((1.0, 1 + 2**0.5, "circumcircle"), (0.5, 0.0, "real"), (0.0, 1.5, "misses pose 2")):
        ask(driver, "kinlib.set('x', arguments[0]); kinlib.set('y', arguments[1])", x, y)
        assert word in ask(driver, "return kinlib.trouble()")
        assert ask(driver, "return [kinlib.axes(), kinlib.table()]") == [None, None]
        assert word in driver.find_element("class name", "status").text


def test_the_point_is_dragged_by_the_mouse_and_moved_by_keys(scene):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    driver = scene()
    start = ask(driver, "return kinlib.parameters")
    pad = driver.find_element("class name", "pad")
    ActionChains(driver).move_to_element(pad).click_and_hold().move_by_offset(20, 10).release().perform()
    dragged = ask(driver, "return kinlib.parameters")
    assert dragged["x"] != start["x"]
    assert dragged["y"] != start["y"]
    pad.send_keys(Keys.ARROW_RIGHT)
    moved = ask(driver, "return kinlib.parameters")
    assert moved["x"] > dragged["x"]
    assert moved["y"] == dragged["y"]
    assert f"x = {moved['x']:.3f}".replace("-", "−") in pad.get_attribute("aria-valuetext")
    pad.send_keys(Keys.HOME)
    assert ask(driver, "return kinlib.parameters") == start


def test_the_link_holds_the_state(scene, chromium):
    with screen(chromium, 390, 924):
        driver = scene("#x=1.5&y=2.25&linkage=6")
        assert ask(driver, "return kinlib.parameters") == {"x": 1.5, "y": 2.25, "linkage": 6}
        href = driver.find_element("link text", "Link to this").get_attribute("href")
        assert href.endswith("#scene=0&x=1.5&y=2.25&linkage=6")
        pad, stage, table = (driver.find_element("css selector", name).rect for name in (".pad", ".stage", "table"))
        assert pad["y"] + pad["height"] <= stage["y"]
        assert stage["y"] + stage["height"] <= table["y"] <= 924 - table["height"]


def test_a_reader_makes_a_scene_of_a_function(scene, tmp_path):
    def show(a, b, u, v, sense):
        turn = (1 + a * kl.k) * (1 + (2 * sense - 1) * b * kl.i)
        tip = kl.act(turn, [u, v, 1])
        return Seen(
            [Rod([0, 0, 0], tip), Frame(turn), Label("tip", tip)], [("height", [tip[2]])], words=[(a, "left", "right")]
        )

    controls = [Slider("a", -1, 1, 0.5), Slider("b", -1, 1, 0.25), Pad(("u", "v"), (0, 1), (0, 2), (0.5, 1))]
    sense = Choice("sense", ["back", "forth"], 1)
    made = explorable_scene(show, [*controls, sense], columns=[("z", 1, 2)], alt="A frame is turned.")
    driver = scene(path=made.save(tmp_path / "own.html"))
    ask(driver, "kinlib.set('a', -0.75); kinlib.choose('sense', 0)")
    expected = show(-0.75, 0.25, 0.5, 1.0, 0)
    np.testing.assert_allclose(ask(driver, "return kinlib.points()[1]"), expected.parts[0].end, atol=1e-14)
    np.testing.assert_allclose(ask(driver, "return kinlib.table()"), [[expected.numbers[0][1][0]]], atol=1e-14)
    assert driver.find_element("class name", "status").text == "right"
    with pytest.raises(Exception, match="there is no parameter c"):
        ask(driver, "kinlib.set('c', 1)")


def test_a_function_that_chooses_by_its_parameters_is_refused():
    def show(a):
        return [Rod([0, 0, 0], [a, 0, 0] if a > 0 else [0, a, 0])]

    with pytest.raises(ValueError, match="the comparison > changes within the ranges"):
        explorable_scene(show, [Slider("a", -1, 1, Fraction(1, 2))], alt="A rod.")


def test_a_slider_stops_where_something_was_computed(scene, tmp_path):
    """Between its stops the nearest counts, by an order, by a key and from a link; each choice has its own."""
    values, roots = [0.0, 0.5, 2.0], [[1.0, 1.25, 3.5], [-1.0, -2.0, -0.125]]
    slider = Samples("f", values, {"root": roots}, 0.5, "free")
    scene_of = explorable_scene(
        lambda root, sign: [Rod([0, 0, 0], [root, sign, 1])],
        [slider, Choice("sign", ["plus", "minus"])],
        alt="A rod follows a root.",
    )
    driver = scene(path=scene_of.save(tmp_path / "stops.html"))
    for value, sign, wanted in ((1.2, 0, 1.25), (1.3, 1, -0.125), (-7, 1, -1), (0.5, 0, 1.25)):
        ask(driver, "kinlib.set('f', arguments[0]); kinlib.choose('sign', arguments[1])", value, sign)
        assert ask(driver, "return kinlib.points()[1]") == [wanted, sign, 1]
    assert ask(driver, "return kinlib.parameters") == {"f": 0.5, "sign": 0}
    from selenium.webdriver.common.keys import Keys

    bar = driver.find_element("css selector", ".slide input")
    bar.send_keys(Keys.ARROW_RIGHT)
    assert ask(driver, "return kinlib.points()[1][0]") == 3.5
    assert bar.get_attribute("aria-valuetext") == "2.00 · 3/3"
    driver = scene("#f=0.4&sign=1", path=tmp_path / "stops.html")
    assert ask(driver, "return kinlib.parameters") == {"f": 0.5, "sign": 1}
    assert ask(driver, "return kinlib.points()[1][0]") == -2


def test_a_place_moves_with_the_slider(scene, tmp_path):
    """The ball is where the data of each value have it, and the path of the linkage's coupler runs through it."""
    home, *others = (pose.astype(float) for pose in THREE_POSES)
    path = [[kl.task.Pose(others[0]), kl.task.Pose(kl.translation([0, 0, z]) * others[1])] for z in (0.0, 0.1, 0.2)]
    ways = kl.follow(kl.bennett_linkages_for(home, path[0], starts=20)[0], home, path)
    factors = [kl.DualQuaternion.stack(same) for same in zip(*(each.factors for each in ways), strict=True)]
    batch = kl.Linkage(factors, ways[0].joints, 2, home, parameters=(np.inf,))
    places = [kl.act(data[1].pose, [0, 0, 0]) for data in path]
    families = {"one": [batch], "again": [batch]}
    shown = sampled_linkages_scene(families, [0, 1, 2], [home], start=1, label="up", targets=[places], alt="A ball.")
    driver = scene(path=shown.save(tmp_path / "moves.html"))
    for value, place in enumerate(places):
        ask(driver, "kinlib.set('f', arguments[0])", value)
        assert ask(driver, "return kinlib.points().at(-1)") == pytest.approx(place, abs=1e-6)


def test_samples_say_what_they_need():
    with pytest.raises(ValueError, match=r"two values at least, in ascending order, got \[1, 0\]"):
        Samples("f", [1, 0], {"x": [1, 2]}, 1)
    with pytest.raises(ValueError, match=r"a start among the values, got 0.5"):
        Samples("f", [0, 1], {"x": [1, 2]}, 0.5)
    with pytest.raises(ValueError, match=r"samples of shape \(..., 2\), one a value, got {'x': \(3,\)}"):
        Samples("f", [0, 1], {"x": [1, 2, 3]}, 0)


def test_one_linkage_is_followed_though_roots_change_their_order():
    values = np.linspace(-1, 1, 81).tolist()
    poses = [pose.astype(float) for pose in FOUR_POSES]
    found = kl.six_r_linkages(*poses, values)
    families = {"first": found[:9], "second": found[9:]}
    made = sampled_linkages_scene(families, values, poses, which=2, start=values[50], label="f", alt="Six bars.")
    slider, choice = made.recording()["explorer"]["controls"]
    rows = np.array(slider["samples"])
    assert rows.shape == (2, 81, 42)
    assert choice["options"] == ["first", "second"]
    assert np.abs(np.diff(rows, axis=1)).max() < 0.5  # more where another linkage is taken, see below
    alone = sampled_linkages_scene({"first": found[2:3]}, values, poses, start=values[50], label="f", alt="Six bars.")
    jumps = np.abs(np.diff(alone.recording()["explorer"]["controls"][0]["samples"][0], axis=0)).max(axis=1)
    assert (jumps > 0.5).any()


def test_buttons_lead_from_option_to_option(scene, tmp_path):
    ring = Choice("n", ["zero", "one", "two"], moves=[("next", [1, 2, 0]), ("first", [0, 0, 0])])
    made = explorable_scene(lambda n, a: [Rod([0, 0, 0], [a, n, 1])], [ring, Slider("a", 0, 1, 1)], alt="A rod.")
    driver = scene(path=made.save(tmp_path / "ring.html"))
    forward, first = driver.find_elements("css selector", ".move")
    seen = []
    for _ in range(3):
        forward.click()
        seen.append((ask(driver, "return kinlib.points()[1][1]"), driver.find_element("css selector", ".choices").text))
    assert [n for n, _ in seen] == [1, 2, 0]
    assert [text.split()[-1] for _, text in seen] == ["one", "two", "zero"]
    forward.click()
    first.click()
    assert ask(driver, "return kinlib.parameters.n") == 0
    with pytest.raises(ValueError, match="3 numbers of options for a move, one an option; not so: \\['next'\\]"):
        Choice("n", ["zero", "one", "two"], moves=[("next", [1, 2, 3])])


def test_the_scene_works_in_a_book(goldberg, chromium, tmp_path, monkeypatch):
    monkeypatch.setenv("KINLIB_SCENE", "shared")
    for name, file in static_files().items():
        target = tmp_path / "_static" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(file.read_bytes())
    root = '<!doctype html><html lang="en" data-content_root="./"><meta charset="utf-8"><title>Book</title><body>'
    (tmp_path / "page.html").write_text(root + goldberg._repr_html_(), encoding="utf-8")
    address = (tmp_path / "page.html").as_uri()
    chromium.get(address + "#scene=0&x=1.5&linkage=2")
    chromium.switch_to.frame(chromium.find_element("css selector", "iframe"))
    try:
        wait_until(lambda: chromium.execute_script("return window.kinlib && kinlib.ready && kinlib.axes()"))
        link = chromium.find_element("link text", "Link to this").get_attribute("href")
        assert link == f"{address}#scene=0&x=1.5&y=2&linkage=2"
    finally:
        chromium.switch_to.default_content()
