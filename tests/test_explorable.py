"""Scenes with parameters: the page shows the linkage that kinlib makes, whatever the reader does."""

import numpy as np
import pytest

import kinlib as kl
from browser import console_messages, requested_urls, screen, wait_until
from kinlib.gallery import THREE_POSES
from kinlib.pictures import goldberg_scene, static_files
from kinlib.pictures.explorable import motion_formula

ALT = "A Goldberg linkage through three poses follows the number z."


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    return goldberg_scene(THREE_POSES, alt=ALT).save(tmp_path_factory.mktemp("scene") / "scene.html")


@pytest.fixture
def scene(chromium, saved):
    """The page of the scene, at rest; the network is not asked, and nothing is complained of."""

    def at(state=""):
        chromium.get("about:blank")
        console_messages(chromium), requested_urls(chromium)
        chromium.get(saved.as_uri() + state)
        wait_until(lambda: chromium.execute_script("return window.kinlib && kinlib.ready"))
        chromium.execute_script("kinlib.pause()")
        return chromium

    yield at
    assert console_messages(chromium) == []
    assert [url for url in requested_urls(chromium) if not url.startswith(("file:", "data:", "blob:", "about:"))] == []


def ask(driver, text, *values):
    return driver.execute_script(text, *values)


def test_the_motion_is_that_of_the_linkage():
    linkage = kl.goldberg_linkages(*THREE_POSES, (1.2, 1.7))[4]
    names = motion_formula(linkage).inputs
    for t in (0.3, -2.0):
        values = [*np.concatenate([f.coeffs for f in linkage.factors]), t, 1.0]
        found = motion_formula(linkage).evaluate(**dict(zip(names, values, strict=True)))
        for link, q in enumerate(found):
            assert kl.same_point(kl.DualQuaternion(q), linkage.link_displacements(t)[link])


def test_a_page_is_not_heavy(saved):
    assert saved.stat().st_size < 1.5e6


def test_axes_and_table_are_those_of_kinlib(scene):
    driver = scene()
    for x, y, choice in [(1.2, 1.7, 0), (-1.3, 0.8, 3), (0.4, 3.1, 4), (2.5, 2.2, 7)]:
        ask(driver, "kinlib.set('x', arguments[0]); kinlib.set('y', arguments[1])", x, y)
        ask(driver, "kinlib.choose('linkage', arguments[0])", choice)
        assert ask(driver, "return kinlib.parameters") == {"x": x, "y": y, "linkage": choice}
        linkage = kl.goldberg_linkages(*THREE_POSES, (x, y))[choice]
        np.testing.assert_allclose(ask(driver, "return kinlib.axes()"), linkage.axes.coeffs, atol=1e-11)
        table = ask(driver, "return kinlib.table()")
        np.testing.assert_allclose(table, np.array(linkage.denavit_hartenberg()), atol=1e-9)


def test_a_bad_place_is_named_and_nothing_is_drawn(scene):
    driver = scene()
    ask(driver, "kinlib.set('x', 1); kinlib.set('y', 1 + Math.SQRT2)")
    assert "circumcircle" in ask(driver, "return kinlib.trouble()")
    assert ask(driver, "return [kinlib.axes(), kinlib.table()]") == [None, None]
    assert "circumcircle" in driver.find_element("class name", "status").text


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
    assert ask(driver, "return kinlib.parameters.x") == pytest.approx(dragged["x"] + 0.02)
    assert "√−1" in pad.get_attribute("aria-valuetext")
    pad.send_keys(Keys.HOME)
    assert ask(driver, "return kinlib.parameters") == start


def test_the_link_holds_the_state(scene, chromium):
    with screen(chromium, 390, 844):
        driver = scene("#x=1.5&y=2.25&linkage=6")
        assert ask(driver, "return kinlib.parameters") == {"x": 1.5, "y": 2.25, "linkage": 6}
        assert (
            driver.find_element("link text", "Link to this").get_attribute("href").endswith("#x=1.5&y=2.25&linkage=6")
        )
        pad, stage = (driver.find_element("class name", name).rect for name in ("pad", "stage"))
        assert pad["y"] + pad["height"] <= stage["y"]


def test_the_scene_works_in_a_book(chromium, tmp_path, monkeypatch):
    monkeypatch.setenv("KINLIB_SCENE", "shared")
    for name, file in static_files().items():
        target = tmp_path / "_static" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(file.read_bytes())
    root = '<!doctype html><html lang="en" data-content_root="./"><meta charset="utf-8"><title>Book</title><body>'
    (tmp_path / "page.html").write_text(root + goldberg_scene(THREE_POSES, alt=ALT)._repr_html_(), encoding="utf-8")
    chromium.get((tmp_path / "page.html").as_uri())
    chromium.switch_to.frame(chromium.find_element("css selector", "iframe"))
    try:
        wait_until(lambda: chromium.execute_script("return window.kinlib && kinlib.ready && kinlib.axes()"))
        assert chromium.find_elements("css selector", ".choices a")[0].text == "x=1&y=2&linkage=4"
    finally:
        chromium.switch_to.default_content()
