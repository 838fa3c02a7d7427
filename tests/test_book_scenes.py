"""Scenes of the book that a reader changes: on the built pages they show what kinlib finds in another way."""

from math import prod

import numpy as np
import pytest

import kinlib as kl
from browser import screen, wait_until
from kinlib import eps, i, j, k
from kinlib.gallery import FOUR_POSES
from kinlib.pictures import on_hyperboloid
from pages import SCENES

PAGE_OF = {figure: page for page, figures in SCENES.items() for figure in figures}


@pytest.fixture
def scene(page):
    """Opens the scene of a figure on its page; what it returns asks the scene."""
    drivers = []

    def opened(figure: str):
        driver = page(PAGE_OF[figure])
        drivers.append(driver)
        frame = driver.find_element("css selector", f"#{figure} iframe")
        driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", frame)
        driver.switch_to.frame(frame)
        wait_until(lambda: driver.execute_script("return !!(window.kinlib && kinlib.ready && kinlib.points)"))
        driver.execute_script("kinlib.pause()")
        return lambda text, *values: driver.execute_script(text, *values)

    yield opened
    for driver in drivers:
        driver.switch_to.default_content()


SET = """
for (const [name, value] of Object.entries(arguments[0])) kinlib.set(name, value);
if (arguments[1] !== null) kinlib.seek(arguments[1]);
"""


def points(ask, frame=None, **parameters) -> np.ndarray:
    """The points of the parts where the parameters are set so, at a frame."""
    ask(SET, parameters, frame)
    return np.array(ask("return kinlib.points()"))


def frame_of(t: float) -> float:
    """Where t is in a turn of 120 frames with t = cot(½ angle)."""
    return 120 * float(np.arctan2(1, t)) / np.pi


def as_poses(corners: np.ndarray) -> np.ndarray:
    """The matrices of frames that are drawn, from their origins and the tips of their axes, shape (..., 4, 3)."""
    matrices = np.zeros((*corners.shape[:-2], 4, 4))
    matrices[..., :3, 3] = corners[..., 0, :]
    matrices[..., :3, :3] = np.swapaxes(corners[..., 1:, :] - corners[..., :1, :], -1, -2)
    matrices[..., 3, 3] = 1
    return matrices


def on_one_line(a, b, c) -> float:
    """How far c is from the line of a and b."""
    a, b, c = map(np.asarray, (a, b, c))
    return float(np.linalg.norm(np.cross(b - a, c - a)) / np.linalg.norm(b - a))


def test_the_double_root(scene):
    """The loop on the page is the one that Theorem 2 finds through the drawn poses; the root itself is named."""
    ask = scene("fig-double-root-drag")
    for x, y in np.random.default_rng(0).uniform([-0.9, 0.3], [0.9, 1.9], (5, 2)):
        drawn = points(ask, x=x, y=y)
        first, second = (as_poses(drawn[n : n + 4]) for n in (-10, -5))
        axes = kl.bennett_linkage(kl.one, first, second).axes
        found = kl.DualQuaternion(np.array(ask("return kinlib.axes()"))[:, None])
        assert np.array_equal(np.sort(np.argwhere(kl.same_point(found, axes))[:, 1]), range(4))
        rows = np.array(ask("return kinlib.table()"))
        np.testing.assert_allclose(rows[:, 0], [1, rows[1, 0], 1, rows[1, 0]], atol=1e-9)
    assert np.isfinite(points(ask, x=0.0, y=1.01)).all()
    assert ask("return kinlib.table()[1][0]") < 0.02
    ask(SET, {"y": 1.0}, None)
    assert "two dyads are one" in ask("return kinlib.trouble()")
    assert ask("return kinlib.axes()") is None


def test_the_free_number(scene):
    """At each value the loop is one of those that kinlib finds, and its coupler is in all poses on the way."""
    ask = scene("fig-free-number-drag")
    poses = [pose.astype(float) for pose in FOUR_POSES]
    for n, value in enumerate(np.random.default_rng(0).uniform(-1, 1, 8)):
        family = n % 2
        ask("kinlib.choose('family', arguments[0])", family)
        ask(SET, {"f": value}, None)
        stop = ask("return kinlib.parameters.f")
        assert abs(stop - value) <= 0.0125 + 1e-12
        axes = np.array(ask("return kinlib.axes()"))
        linkages = kl.six_r_linkages(*poses, stop)[9 * family : 9 * family + 9]
        loops = np.array([linkage.axes.coeffs for linkage in linkages])
        loops = np.concatenate([loops, loops[:, ::-1]])
        loops /= np.linalg.norm(loops[..., 1:4], axis=-1, keepdims=True)
        off = np.minimum(np.abs(loops - axes).max(-1), np.abs(loops + axes).max(-1)).max(-1)
        assert off.min() < 1e-8
        given = ask("return JSON.parse(document.getElementById('recording').textContent).explorer")
        turns = given["turns"][given["turnOf"][family]]
        for t, pose in zip(linkages[0].parameters, poses, strict=True):
            angle = 0 if np.isinf(t) else 2 * np.arctan2(1, t)
            drawn = points(ask, float(np.interp(angle, turns, range(120))))
            np.testing.assert_allclose(as_poses(drawn[-5:-1]), kl.as_matrix(pose), atol=1e-7)


def test_the_sleeve(scene):
    ask = scene("fig-sleeve-drag")
    for x, y in np.random.default_rng(0).uniform(-1.3, 1.3, (5, 2)):
        drawn = points(ask, x=x, y=y)
        cosine, sine = np.cos(2 * np.arctan(x)), np.sin(2 * np.arctan(x))
        wanted = [[cosine, -sine, 0, 0], [sine, cosine, 0, 0], [0, 0, 1, 2 * y], [0, 0, 0, 1]]
        np.testing.assert_allclose(as_poses(drawn[2:6]), wanted, atol=1e-12)
        point, lines = drawn[-1] - [4, 0, 0], drawn[6:10] - [4, 0, 0]
        pose = kl.DualQuaternion([1, 0, 0, point[0], point[2], 0, 0, point[1]])
        assert abs(float(kl.study_form(pose, pose))) < 1e-14
        assert max(on_one_line(*lines[n : n + 2], point) for n in (0, 2)) < 1e-12
        for end in lines:
            there = kl.DualQuaternion([1, 0, 0, end[0], end[2], 0, 0, end[1]])
            assert abs(float(kl.study_form(pose, there))) < 1e-14


def test_the_conic(scene):
    ask = scene("fig-conic-drag")
    for a, b, t in np.random.default_rng(0).uniform([0.5, -1, -2], [2.4, 1, 2], (5, 3)):
        drawn = points(ask, frame_of(t), a=a, b=b)
        point, lines = drawn[-1] - [4, 0, 0], drawn[8:12] - [4, 0, 0]
        np.testing.assert_allclose(point, on_hyperboloid(np.arctan2(1, t), np.arctan2(1, a * t + b)), atol=1e-6)
        assert max(on_one_line(*lines[n : n + 2], point) for n in (0, 2)) < 1e-6
        np.testing.assert_allclose((lines**2) @ [1, 1, -1], 1, atol=1e-6)
        h1, h2 = k, (3 * j + 4 * k - 4 * eps * j + 3 * eps * k) / 5
        pose = kl.as_matrix((t - h1.astype(float)) * (a * t + b - h2.astype(float)))
        np.testing.assert_allclose(as_poses(drawn[4:8]), pose, atol=1e-6)


def test_the_cubics(scene):
    """The point stays on the torus and passes the dots; the doubled joint turns as often as the page says."""
    ask = scene("fig-cubics-drag")
    for n, (q1, q0) in enumerate(np.random.default_rng(0).uniform(-3, 3, (6, 2))):
        kind = n % 2
        ask("kinlib.choose('kind', arguments[0])", kind)
        once = (0.0, 1.0) if kind else (0.0, 2.0)
        dots = points(ask, 0, q1=q1, q0=q0)[[-1]]
        dots = np.concatenate([dots, [points(ask, frame_of(t))[-1] for t in once]])
        np.testing.assert_allclose(dots, [[3, 0, 0], THROUGH_HALF, THROUGH_LAST], atol=1e-6)
        path = np.array([points(ask, frame)[-1] for frame in np.arange(0, 120, 12.5)])
        np.testing.assert_allclose((np.hypot(path[:, 0], path[:, 1]) - 2) ** 2 + path[:, 2] ** 2, 1, atol=1e-9)
        text = ask("return document.querySelector('.status').textContent")
        assert ("twice" in text) == (abs(winding(q1, q0, kind)) == 2)


def torus(first: float, second: float) -> np.ndarray:
    """The point of the torus for two joint angles."""
    away = 2 + np.cos(second)
    return np.array([away * np.cos(first), away * np.sin(first), -np.sin(second)])


# t = cot(−½ angle): both joints turn by −2 arccot t.
THROUGH_HALF = torus(np.pi, np.pi)
THROUGH_LAST = torus(-2 * np.arctan2(1, 1), -2 * np.arctan2(1, 2))


def winding(q1: float, q0: float, kind: int) -> int:
    """How often p − q √−1 winds, in half-turns: twice a full half-turn is two turns of the joint."""
    t = 1 / np.tan(np.linspace(0, np.pi, 200001)[1:-1])
    p1 = 2 * q1 + 2 * q0 - 1 if kind else q1 + q0 / 2 - 2
    return round(float(np.ptp(np.unwrap(np.angle(t * t + p1 * t - 1j * (q1 * t + q0)))[[0, -1]])) / np.pi)


def test_the_dilatations(scene):
    ask = scene("fig-dilatations-drag")
    for u, v, ratio in np.random.default_rng(0).uniform([-3, -3, 1], [3, 3, 3], (5, 3)):
        ask(SET, {"u": u, "v": v, "ratio": ratio}, None)
        whole = np.eye(3)
        centres = [((2, 0), 0.5), ((0.9, 0.9), 1.5), ((-1.8, 0), 2 / 3), ((u, v), ratio)]
        for (x, y), r in centres:
            whole = np.array([[-r, 0, (1 + r) * x], [0, -r, (1 + r) * y], [0, 0, 1]]) @ whole
        gaps = [(whole @ [*start, 1] - [*start, 1])[:2] for start in ((3, 1), (2, 2))]
        np.testing.assert_allclose(ask("return kinlib.table()"), gaps, atol=1e-12)
    ask(SET, {"u": -1, "v": -1, "ratio": 2}, None)
    np.testing.assert_allclose(ask("return kinlib.table()"), np.zeros((2, 2)), atol=1e-12)


def test_the_exchange(scene):
    """Six exchanges lead back, on the way are six chains, and all carry the frame as the product does."""
    ask = scene("fig-exchange-drag")
    h = i, 2 * (j - eps * i), 3 * (k - 2 * eps * j)
    t = 0.7
    wanted = kl.as_matrix(prod(t - f.astype(float) for f in h))
    seen = []
    for n in range(6):
        drawn = points(ask, frame_of(t))
        np.testing.assert_allclose(as_poses(drawn[-5:-1]), wanted, atol=1e-6)
        seen.append(ask("return kinlib.parameters.order"))
        ask("document.querySelectorAll('.move')[arguments[0]].click()", n % 2)
    assert sorted(seen) == list(range(6))
    assert ask("return kinlib.parameters.order") == seen[0]


def stroke(driver, start, end, steps: int = 12) -> None:
    """One finger goes from a place on the screen to another."""

    def touch(kind, *places):
        fingers = [{"x": x, "y": y, "id": 1} for x, y in places]
        driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    touch("touchStart", start)
    for way in np.linspace(0, 1, steps + 1)[1:]:
        touch("touchMove", tuple(float((1 - way) * a + way * b) for a, b in zip(start, end, strict=True)))
    touch("touchEnd")


def test_a_finger_drags_the_point_turns_the_view_and_scrolls_the_page(page):
    driver = page(PAGE_OF["fig-double-root-drag"])
    ask = driver.execute_script
    with screen(driver, 390, 1100):
        frame = driver.find_element("css selector", "#fig-double-root-drag iframe")
        ask("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", frame)
        left, top = ask("const box = arguments[0].getBoundingClientRect(); return [box.left, box.top]", frame)

        def inside(text, *values):
            driver.switch_to.frame(frame)
            try:
                return ask(text, *values)
            finally:
                driver.switch_to.default_content()

        def middle(css):
            box = inside("return document.querySelector(arguments[0]).getBoundingClientRect().toJSON()", css)
            return left + box["x"] + box["width"] / 2, top + box["y"] + box["height"] / 2

        wait_until(lambda: inside("return !!(window.kinlib && kinlib.ready && kinlib.points)"))
        inside("kinlib.pause()")
        x, y = middle(".pad")
        stroke(driver, (x, y), (x + 40, y - 30))
        dragged = wait_until(lambda: (now := inside("return kinlib.parameters"))["x"] > 0 and now["x"] != 0.5 and now)
        assert dragged["y"] > 1.1
        x, y = middle(".stage")
        azimuth, elevation = inside("return kinlib.view()")
        stroke(driver, (x - 40, y), (x + 60, y))
        turned = wait_until(lambda: (now := inside("return kinlib.view()"))[0] < azimuth - 20 and now)
        assert turned[1] == pytest.approx(elevation, abs=1)
        place = ask("return scrollY")
        stroke(driver, (x, y), (x, y - 120))
        wait_until(lambda: ask("return scrollY") > place + 60)
        assert inside("return kinlib.view()") == pytest.approx(turned, abs=1e-6)
        assert inside("return kinlib.parameters") == dragged
