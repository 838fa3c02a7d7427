"""Scenes: what is recorded agrees with the mathematics, is always the same, and plays without a network."""

import io
import json
import re
import subprocess
import sys
import time
from html import unescape

import numpy as np
import pytest
from PIL import Image

import kinlib as kl
from browser import console_messages, requested_urls
from kinlib.gallery import THREE_POSES
from kinlib.pictures import (
    Ball,
    Curve,
    Frame,
    Label,
    Rod,
    Scene,
    SceneGrid,
    Surface,
    dyad_scene,
    link_colours,
    link_names,
    linkage_scene,
    linkages_side_by_side,
    static_files,
)
from kinlib.pictures.bars import Bars
from kinlib.pictures.colours import COUPLER, LIME, RASPBERRY, VIOLET
from kinlib.pictures.floats import pose_matrices
from kinlib.pictures.still import still_of
from kinlib.pictures.turn import one_turn, parameters_of
from kinlib.testing import random_poses

ALT = "A linkage of five bars moves through three poses."
IDENTITY = np.eye(4)
CIRCLE = np.linspace(0, np.pi, 12, endpoint=False)
TURNING = kl.DualQuaternion([[np.cos(x), 0, 0, np.sin(x), 0, 0, 0, 0] for x in CIRCLE])


@pytest.fixture(scope="module")
def linkages():
    return kl.goldberg_linkages(*THREE_POSES, (1, 2))


@pytest.fixture(scope="module")
def scene(linkages):
    return linkage_scene(linkages[0], THREE_POSES, alt=ALT)


@pytest.fixture(scope="module")
def recording(scene):
    return scene.recording()


@pytest.fixture(autouse=True)
def _in_a_book(monkeypatch):
    monkeypatch.setenv("KINLIB_SCENE", "shared")


def poses_of(cell: dict, body: str, home=IDENTITY) -> np.ndarray:
    """The poses of a body in a recording, in units of length, shape (frames, 4, 4)."""
    coefficients = np.reshape(cell["tracks"][body], (-1, 8)).astype(float)
    coefficients /= np.linalg.norm(coefficients[:, :4], axis=1, keepdims=True)
    matrices = kl.as_matrix(kl.DualQuaternion(coefficients))
    units = np.diag([1 / cell["unit"]] * 3 + [1.0])
    units[:3, 3] = -np.array(cell["centre"]) / cell["unit"]
    return np.linalg.inv(units) @ matrices @ units @ home


def as_floats(matrices) -> np.ndarray:
    return np.asarray(matrices, dtype=float)


# ---- what is recorded ------------------------------------------------------------------------------------


def test_every_link_but_the_base_moves(recording):
    (cell,) = recording["cells"]
    assert list(cell["tracks"]) == ["link 1", "link 2", "link 3", "link 4"]
    assert all(len(track) == 8 * recording["frames"] for track in cell["tracks"].values())
    assert {row[0].split("/")[0] for row in cell["objects"]} == {"fixed", *cell["tracks"]}


def test_tracks_are_the_motions_of_the_links(linkages, recording):
    bars = Bars.of(linkages[0])
    t, _ = one_turn(bars, recording["frames"], bars.linkage.parameters)
    expected = kl.as_matrix(bars.linkage.link_displacements(t))
    for link in range(1, 5):
        found = poses_of(recording["cells"][0], f"link {link}")
        np.testing.assert_allclose(found, expected[:, link], atol=2e-4)


def test_a_frame_hits_each_pose(linkages, recording):
    (cell,) = recording["cells"]
    home = as_floats(kl.as_matrix(linkages[0].home))
    seen = poses_of(cell, f"link {linkages[0].coupler}", home)
    assert [name for _, _, name in cell["lights"]] == ["p₀", "p₁", "p₂"]
    hits = [frame for _, frame, _ in cell["lights"]]
    np.testing.assert_allclose(seen[hits], pose_matrices(THREE_POSES), atol=1e-4)
    assert [recording["captions"][frame] for frame in hits] == ["t = ∞", "t = 0", "t = 1.00"]


def test_neighbouring_links_share_their_axis(linkages, recording):
    """A second look at the tracks: both links at a joint carry its axis to the same place."""
    points, directions = Bars.of(linkages[0]).lines
    (cell,) = recording["cells"]
    moves = [np.eye(4), *[poses_of(cell, body) for body in cell["tracks"]]]
    for joint in range(5):
        for point in (points[joint], points[joint] + directions[joint]):
            before, after = (moves[n % 5] @ np.append(point, 1) for n in (joint, joint + 1))
            np.testing.assert_allclose(before - after, np.zeros_like(before - after), atol=4e-4)


def test_all_is_seen(recording):
    """The hull contains the whole motion, and the whole motion is no smaller than the hull."""
    hull = np.array(recording["cells"][0]["hull"])
    reach = np.linalg.norm(hull, axis=1)
    assert 0.8 < reach.max() <= 1.00001


@pytest.mark.parametrize("exponent", [-10, 20])
def test_scenes_do_not_depend_on_the_unit_of_length(linkages, recording, exponent):
    def scaled(q):
        return kl.DualQuaternion(np.asarray(q.coeffs, dtype=float) * ([1.0] * 4 + [2.0**exponent] * 4))

    linkage = linkages[0]
    factors = [scaled(f) for f in linkage.factors]
    large = kl.Linkage(factors, linkage.joints, linkage.coupler, scaled(linkage.home), linkage.parameters)
    other = linkage_scene(large, [scaled(p) for p in THREE_POSES], alt=ALT).recording()["cells"][0]
    first = recording["cells"][0]
    assert other["unit"] == pytest.approx(first["unit"] * 2.0**exponent, rel=1e-4, abs=1e-5)
    for body, track in first["tracks"].items():
        np.testing.assert_allclose(other["tracks"][body], track, atol=5)


def test_scenes_are_small(scene, linkages):
    assert len(scene._repr_html_()) < 80_000
    assert len(linkages_side_by_side(linkages, THREE_POSES, alt=ALT)._repr_html_()) < 290_000


SCRIPT = """
import hashlib, kinlib as kl
from kinlib.gallery import THREE_POSES
from kinlib.pictures import linkage_scene, linkages_side_by_side
linkages = kl.goldberg_linkages(*THREE_POSES, (1, 2))
scenes = linkage_scene(linkages[0], THREE_POSES, alt="x"), linkages_side_by_side(linkages, THREE_POSES, alt="x")
print([hashlib.sha256(scene._repr_html_().encode()).hexdigest() for scene in scenes])
"""


def test_scenes_are_the_same_in_every_process(capsys):
    other = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, check=True, text=True)
    exec(SCRIPT, {})
    assert capsys.readouterr().out == other.stdout


def test_nothing_is_started_or_opened(monkeypatch, linkages, tmp_path):
    def refuse(*args, **kwargs):
        raise AssertionError("a recording needs no process and no socket")

    monkeypatch.setattr("subprocess.Popen.__init__", refuse)
    monkeypatch.setattr("socket.socket.__init__", refuse)
    monkeypatch.setattr("zmq.Context.socket", refuse)
    scene = linkage_scene(linkages[1], THREE_POSES, alt=ALT)
    scene._repr_html_()
    assert scene.save(tmp_path / "scene.html").stat().st_size > 1e5


def test_the_eight_linkages_light_up_together(linkages):
    grid = linkages_side_by_side(linkages, THREE_POSES, alt=ALT).recording()
    assert [cell["name"] for cell in grid["cells"]] == [str(n) for n in range(1, 9)]
    assert {tuple(frame for _, frame, _ in cell["lights"]) for cell in grid["cells"]} == {(0, 12, 24)}
    for cell, linkage in zip(grid["cells"], linkages, strict=True):
        home = as_floats(kl.as_matrix(linkage.home))
        seen = poses_of(cell, f"link {linkage.coupler}", home)[[0, 12, 24]]
        np.testing.assert_allclose(seen, pose_matrices(THREE_POSES), atol=2e-3)


def test_a_dyad_visits_its_poses():
    for dyad in kl.dyads_through_poses(*THREE_POSES):
        recording = dyad_scene(dyad, THREE_POSES, alt="A dyad goes through three poses.").recording()
        (cell,) = recording["cells"]
        hits = [frame for _, frame, _ in cell["lights"]]
        seen = poses_of(cell, "hand", as_floats(kl.as_matrix(dyad.home)))[hits]
        np.testing.assert_allclose(seen, pose_matrices(THREE_POSES), atol=1e-4)


def test_a_dyad_turns_about_one_axis_after_the_other():
    dyad = kl.Dyad(kl.i, kl.j - kl.eps * kl.i)
    recording = dyad_scene(dyad, alt="A dyad turns.", frames=8).recording()
    assert recording["captions"][1] == "θ₁ = 90°, θ₂ = 0°"
    assert recording["captions"][-1] == "θ₁ = 0°, θ₂ = 270°"
    quarter = poses_of(recording["cells"][0], "hand")[1]
    np.testing.assert_allclose(quarter[:3, :3], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-4)


# ---- linkages as they are drawn --------------------------------------------------------------------------


def test_bars_lie_along_common_perpendiculars(linkages):
    for linkage in linkages:
        ends, (_, directions) = Bars.of(linkage).ends, Bars.of(linkage).lines
        for link, (start, end) in enumerate(ends):
            assert abs((end - start) @ directions[link - 1]) < 1e-9
            assert abs((end - start) @ directions[link]) < 1e-9
        rows = linkage.denavit_hartenberg()
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        np.testing.assert_allclose(np.roll(lengths, -1), [row.distance for row in rows], atol=1e-9)


def test_bars_may_be_drawn_in_other_places(linkages):
    linkage = linkages[0].astype(float)
    places = linkage.bars()[:, 1] + 0.2 * linkage.chain.lines.directions
    given = np.stack([np.roll(places, 1, axis=0), places], axis=1)
    scene = linkage_scene(linkage, bars=given, alt=ALT)
    rods = [part for part in scene.parts if isinstance(part, Rod)]
    ends = np.array([[rod.start, rod.end] for rod in rods])
    apart = np.linalg.norm(ends[:, None] - given, axis=-1).max(axis=-1).min(axis=0)
    assert np.all(apart < 0.1 * Bars.of(linkage).size)
    with pytest.raises(ValueError, match="on axis 5"):
        linkage_scene(linkage, bars=given + np.array([0, 1, 0]), alt=ALT)
    with pytest.raises(ValueError, match="straight bars"):
        linkage_scene(linkage, bars=np.concatenate([given, given[:, 1:]], axis=1), alt=ALT)


def test_bars_keep_near_when_common_perpendiculars_run_away():
    linkage = kl.six_r_linkages(*random_poses(4, seed=23), 1.0)[9]
    assert max(abs(row.offset) for row in linkage.denavit_hartenberg()) > 10
    assert np.ptp(Bars.of(linkage).ends.reshape(-1, 3), axis=0).max() < 4


@pytest.mark.parametrize("centre", [[0, 0, 0], [5, -3, 2]])
def test_bars_of_a_spherical_linkage_keep_their_distance_from_the_centre(centre):
    shift = kl.translation(centre)
    h1, h2 = (shift * h * shift.conjugate() for h in (kl.i, 3 * kl.i + 4 * kl.j))
    linkage = kl.Linkage.from_chains([h1, h2], kl.bennett_flip(h1, h2))
    distances = np.linalg.norm(Bars.of(linkage).ends - centre, axis=-1)
    np.testing.assert_allclose(distances, distances[0, 0])
    assert distances[0, 0] > 0.9
    assert linkage_scene(linkage, alt="A spherical linkage.").frames == 90


def test_one_colour_a_link(linkages):
    colours, names = link_colours(linkages[0]), link_names(linkages[0])
    assert len(set(colours)) == len(set(names)) == 5
    assert names[0] == "base (fixed)"
    assert names[linkages[0].coupler] == "coupler"


@pytest.mark.parametrize("count", [*range(4, 10), 30])
def test_every_number_of_links_has_colours(count):
    """A loop may have more links than there are colours: then these come again, darker."""
    chain = [kl.i, 2 * kl.i, *(kl.i + n * kl.j for n in range(1, (count + 1) // 2 - 1))]
    linkage = kl.Linkage.from_chains(chain, chain, joints=[1] * (count - 1) + [1 + count % 2])
    colours, names = link_colours(linkage), link_names(linkage)
    assert len(set(colours)) == len(set(names)) == count
    assert all(re.fullmatch("#[0-9a-f]{6}", colour) for colour in colours)


def test_bars_of_a_scene_are_computed_once(monkeypatch, linkages):
    asked = []
    compute = kl.Chain._bars_near
    monkeypatch.setattr(kl.Chain, "_bars_near", lambda chain, near: asked.append(chain) or compute(chain, near))
    linkage_scene(linkages[0], THREE_POSES, alt=ALT)
    assert len(asked) == 1


def test_what_is_not_one_linkage_is_named(linkages):
    rows = zip(THREE_POSES, (kl.one, kl.i, kl.one + kl.i), strict=True)
    poses = [kl.DualQuaternion.stack([pose.astype(float) for pose in row]) for row in rows]
    batch = kl.bennett_linkage(*poses, degenerate="nan")  # in the second row the poses are those of one rotation
    with pytest.raises(ValueError, match=r"the linkage is a batch of shape \(2,\)"):
        linkage_scene(batch, alt=ALT)
    with pytest.raises(ValueError, match=r"the linkage is not a linkage: .* not finite"):
        linkage_scene(batch[1], alt=ALT)
    with pytest.raises(ValueError, match="linkage 2 of those given is not a linkage"):
        linkages_side_by_side([linkages[0], batch[1]], alt=ALT)
    h1, h2 = kl.DualQuaternion.stack([kl.i, kl.j]), kl.DualQuaternion.stack([kl.j - kl.eps * kl.i, kl.k])
    with pytest.raises(ValueError, match=r"the dyad is a batch of shape \(2,\)"):
        dyad_scene(kl.Dyad(h1, h2), alt=ALT)


def test_the_pace_is_even_and_stops_where_it_must(linkages):
    bars = Bars.of(linkages[0])
    t, places = one_turn(bars, 60, [1.0, np.inf, 0.0])
    assert t[0] == np.inf
    assert list(t[places]) == [1.0, np.inf, 0.0]
    ends = kl.act(linkages[0].link_displacements(t)[..., None], bars.ends).reshape(60, -1, 3)
    steps = np.linalg.norm(np.diff(ends, axis=0), axis=2).sum(axis=1)
    assert steps.max() < 1.6 * steps.min()


@pytest.mark.parametrize("places", [[0, 10, 20], [0, 20, 10], [5, 15, 25]])
def test_stops_can_be_placed(linkages, places):
    t, found = one_turn(Bars.of(linkages[0]), 30, [np.inf, 0.0, 1.0], places)
    assert list(found) == places
    assert list(t[places]) == [np.inf, 0.0, 1.0]
    assert len(np.unique(t)) == 30


def test_too_many_stops_are_refused(linkages):
    with pytest.raises(ValueError, match="at least 4 frames"):
        one_turn(Bars.of(linkages[0]), 3, [0.0, 1.0, 2.0])


def test_poses_are_found_without_being_told(linkages):
    """The search agrees with the parameters from which the linkage was made."""
    for linkage in linkages:
        plain = kl.Linkage(linkage.factors, linkage.joints, linkage.coupler, linkage.home)
        np.testing.assert_allclose(parameters_of(Bars.of(plain), THREE_POSES), as_floats(linkage.parameters), atol=1e-9)


def test_a_pose_that_is_missed_is_named(linkages):
    with pytest.raises(ValueError, match="does not pass through pose 1"):
        linkage_scene(linkages[0], [THREE_POSES[0], kl.translation([9, 9, 9])], alt=ALT)


# ---- scenes of any parts ---------------------------------------------------------------------------------


def test_parts_of_every_kind():
    grid = np.stack(np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], [0.5]), axis=-1).reshape(2, 3, 3)
    parts = [
        Rod([0, 0, 0], [1, 0, 0], body="hand"),
        Ball([1, 0, 0], body="hand"),
        Curve([[0, 0, 0], [1, 1, 0], [2, 0, 1]]),
        Surface(grid),
        Frame(kl.one, name="o"),
        Label("a", [1, 0, 0], "hand"),
    ]
    (cell,) = Scene(parts, {"hand": TURNING}, alt="All kinds of parts.").recording()["cells"]
    shapes = [shape["type"] for shape in cell["geometries"]]
    assert shapes == ["CylinderGeometry", "SphereGeometry", "TubeGeometry", "BufferGeometry", "CylinderGeometry"]
    assert [(text, body) for text, body, *_ in cell["labels"]] == [("o", ""), ("a", "hand")]
    triangles = next(shape for shape in cell["geometries"] if shape["type"] == "BufferGeometry")["data"]["index"]
    assert len(triangles["array"]) == 3 * 4


def test_a_rod_reaches_from_start_to_end():
    start, end = np.array([1.0, 2, 3]), np.array([4.0, -1, 3])
    (cell,) = Scene([Rod(start, end, radius=0.5)], alt="A rod.").recording()["cells"]
    (row,) = cell["objects"]
    matrix = np.reshape(row[3:], (3, 4))
    ends = [cell["unit"] * matrix @ [0, y, 0, 1] + cell["centre"] for y in (-0.5, 0.5)]
    np.testing.assert_allclose(ends, [start, end], atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(cell["unit"] * matrix[:, 0]), 0.5, atol=1e-4)


def test_in_plain_text_a_scene_is_one_line(scene, linkages):
    """Notebooks keep this text and compare it: it has no floats."""
    assert repr(scene) == f"<Scene of 90 frames: {ALT}>"
    grid = linkages_side_by_side(linkages[:2], THREE_POSES, alt=ALT)
    assert repr(grid) == f"<SceneGrid of 36 frames: {ALT}>"


def test_scenes_grow_by_new_scenes():
    first = Scene([Ball([0, 0, 0])], alt="A ball.")
    second = first.with_parts(Ball([1, 0, 0]))
    assert (len(first.parts), len(second.parts)) == (1, 2)
    assert first.frames == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"alt": " "}, "expected alt"),
        ({"alt": "x", "parts": [Ball([0, 0, 0], body="arm")]}, "no motion is given for arm"),
        ({"alt": "x", "motions": {"a": TURNING, "b": TURNING[:3]}}, "of one shape"),
        ({"alt": "x", "motions": {"a": kl.one}}, "of one shape"),
        ({"alt": "x", "motions": {"a": TURNING}, "captions": ["one"]}, "expected 12 captions"),
    ],
)
def test_wrong_scenes_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Scene(**arguments)


def test_grids_need_equal_times():
    still, moving = Scene(alt="x"), Scene((), {"a": TURNING}, alt="x")
    with pytest.raises(ValueError, match="same number of frames"):
        SceneGrid([still, moving], ["1", "2"], alt="x")
    with pytest.raises(ValueError, match="expected 2 names"):
        SceneGrid([still, still], ["1"], alt="x")


# ---- pages -----------------------------------------------------------------------------------------------


def inner_page(markup: str) -> str:
    return unescape(re.search(r"<iframe .* srcdoc='([^']*)'></iframe></div>$", markup, re.DOTALL)[1])


def test_the_page_holds_the_recording(scene, recording):
    data = re.search(r'<script type="application/json" id="recording">(.*?)</script>', inner_page(scene._repr_html_()))
    assert json.loads(data[1]) == json.loads(json.dumps(recording))


def test_awkward_words_stay_words():
    alt = """It's <b>"bold"</b> & </script> done."""
    page = inner_page(Scene(alt=alt)._repr_html_())
    assert page.count("</script>") == 2
    data = re.search(r'id="recording">(.*?)</script>', page)
    assert json.loads(data[1])["alt"] == alt


@pytest.mark.parametrize(
    ("environment", "inline"),
    [({}, False), ({"JPY_SESSION_NAME": "x.ipynb"}, True), ({"KINLIB_SCENE": "inline"}, True),
     ({"JPY_SESSION_NAME": "x.ipynb", "KINLIB_SCENE": "shared"}, False)],
)  # fmt: skip
def test_where_the_viewer_comes_from(monkeypatch, environment, inline):
    for name in ("KINLIB_SCENE", "JPY_SESSION_NAME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert (len(Scene(alt="Nothing.")._repr_html_()) > 500_000) == inline


def test_a_wrong_wish_is_refused(monkeypatch):
    monkeypatch.setenv("KINLIB_SCENE", "server")
    with pytest.raises(ValueError, match="'shared' or 'inline'"):
        Scene(alt="Nothing.")._repr_html_()


def test_shared_files_exist():
    assert {"kinlib/viewer.js", "kinlib/viewer.css", "meshcat/main.min.js", "meshcat/LICENSE"} <= set(static_files())
    assert all(path.is_file() for path in static_files().values())


def test_a_saved_scene_needs_nothing_else(scene, tmp_path):
    page = scene.save(tmp_path / "scene.html").read_text(encoding="utf-8")
    own = page.replace(static_files()["meshcat/main.min.js"].read_text(encoding="utf-8"), "")
    own = own.replace("picture.src = given.pictures", "")  # data that the page holds
    assert not re.findall(r"""\b(?:src|href)\s*=|url\(|https?://(?!www\.w3\.org)""", own)
    assert set(re.findall(r"https?://[\w./-]+", page)) <= {"http://www.w3.org/1999/xhtml"}


# ---- stills ----------------------------------------------------------------------------------------------

PATH = re.compile(r"<path color='(#\w{6})'[^>]* d='M(\S+) (\S+)l([^z']*)")


def painted(still: str) -> list[tuple[str, np.ndarray]]:
    """The colours and the middles of all patches of a still, in the order in which they are painted."""
    found = []
    for colour, x, y, steps in PATH.findall(still):
        moves = np.array(steps.split(), dtype=float).reshape(-1, 2)
        points = np.cumsum([[float(x), float(y)], *moves], axis=0)
        found.append((colour, points.mean(axis=0)))
    return found


def towards(view: tuple[float, float]) -> np.ndarray:
    """Sideways, upwards and to the viewer, as rows, by turning about z and then about y."""
    y_axis, z_axis = (kl.Line(axis, [0, 0, 0]) for axis in ([0, 1, 0], [0, 0, 1]))
    azimuth, elevation = np.radians(view)
    return kl.as_matrix(kl.rotation(y_axis, elevation) * kl.rotation(z_axis, -azimuth))[:3, :3][[1, 2, 0]]


def test_a_still_shows_everything_where_it_is():
    view, places = (35, 20), np.random.default_rng(4).normal(size=(6, 3))
    colours = [f"#{n}0{n}0{n}0" for n in range(1, 7)]
    balls = [Ball(place, colour, 0.05) for place, colour in zip(places, colours, strict=True)]
    still = painted(still_of(Scene(balls, view=view, alt="Six balls.").recording()))
    seen = places @ towards(view).T
    behind = np.argsort(seen[:, 2])
    assert len(still) == 12  # each ball and the light on it
    middles = np.array([middle for _, middle in still[::2]])
    flat = np.column_stack([seen[behind, 0], -seen[behind, 1]])
    size = np.ptp(middles, axis=0).max() / np.ptp(flat, axis=0).max()
    np.testing.assert_allclose(middles - middles.mean(axis=0), size * (flat - flat.mean(axis=0)), atol=0.01 * size)


def test_a_still_shows_the_first_frame_and_names_its_poses(linkages):
    for linkage in linkages[:2]:
        still = still_of(linkage_scene(linkage, THREE_POSES, alt=ALT).recording())
        assert {colour for colour, _ in painted(still)} >= {COUPLER, RASPBERRY, LIME, VIOLET}
        assert re.findall(r"<text [^>]*>([^<]*)<", still) == ["p₀", "p₁", "p₂", *link_names(linkage)]


@pytest.mark.parametrize(("start", "apart"), [(0, False), (3, True)])
def test_a_still_has_bodies_where_the_first_frame_has_them(start, apart):
    motion = kl.DualQuaternion(np.roll(TURNING.coeffs, -start, axis=0))
    scene = Scene([Ball([1, 0, 0], body="hand"), Ball([0, 0, 0])], {"hand": motion}, view=(0, 0), alt="A ball turns.")
    sideways = [middle[0] for _, middle in painted(still_of(scene.recording()))]
    assert (np.ptp(sideways) > 100) == apart


# ---- playing, in a browser -------------------------------------------------------------------------------


@pytest.fixture
def play(chromium):
    """Opens a file and waits for its scene; afterwards nothing else may have been asked for or complained of."""
    chromium.get("about:blank")
    console_messages(chromium), requested_urls(chromium)

    def open_file(path):
        chromium.get(path.as_uri())
        wait_until(lambda: chromium.execute_script("return !!(window.kinlib && kinlib.ready)"))
        return chromium.execute_script

    yield open_file
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert [url for url in requested_urls(chromium) if not url.startswith(("file:", "about:", "data:"))] == []
    assert console_messages(chromium) == []


def wait_until(condition, seconds: float = 30):
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
    return value


def test_a_saved_scene_plays(play, scene, recording, tmp_path):
    ask = play(scene.save(tmp_path / "scene.html"))
    assert ask("return kinlib.frames") == recording["frames"]
    assert ask("return kinlib.playing")
    start = ask("return kinlib.frame")
    wait_until(lambda: ask("return kinlib.frame") != start)
    ask("kinlib.pause()")
    stop = ask("return kinlib.frame")
    time.sleep(0.2)
    assert ask("return kinlib.frame") == stop
    stage = "return document.querySelector('.stage').getAttribute(arguments[0])"
    assert (ask(stage, "role"), ask(stage, "aria-label")) == ("img", ALT)


def test_the_player_moves_bodies_as_the_mathematics_does(play, scene, recording, tmp_path):
    ask = play(scene.save(tmp_path / "scene.html"))
    (cell,) = recording["cells"]
    expected = kl.as_matrix(kl.DualQuaternion(np.reshape(cell["tracks"]["link 3"], (-1, 8)).astype(float)))
    ask("kinlib.pause()")
    for frame in (0, 17, 89):
        found = ask("kinlib.seek(arguments[0]); return kinlib.matrix('link 3')", frame)
        np.testing.assert_allclose(np.reshape(found, (4, 4)).T, expected[frame], atol=1e-4)
    between = np.reshape(ask("kinlib.seek(17.5); return kinlib.matrix('link 3')"), (4, 4)).T
    np.testing.assert_allclose(between[:3, :3] @ between[:3, :3].T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(between, (expected[17] + expected[18]) / 2, atol=0.01)


def test_poses_light_up_when_they_are_reached(play, scene, recording, tmp_path):
    ask = play(scene.save(tmp_path / "scene.html"))
    lit = "return [...document.querySelectorAll('.label.lit')].map((label) => label.textContent)"
    ask("kinlib.pause()")
    for _, frame, name in recording["cells"][0]["lights"]:
        ask("kinlib.seek(arguments[0])", frame)
        assert ask(lit) == [name]
        assert name in ask("return document.querySelector('output').textContent")
    ask("kinlib.seek(8)")
    assert ask(lit) == []


def test_readers_who_want_calm_get_it(chromium, play, scene, tmp_path):
    wish = {"features": [{"name": "prefers-reduced-motion", "value": "reduce"}]}
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", wish)
    ask = play(scene.save(tmp_path / "scene.html"))
    assert not ask("return kinlib.playing")
    assert ask("return kinlib.frame") == 0
    ask("document.querySelector('button').click()")
    assert ask("return kinlib.playing")


def test_the_keyboard_is_enough(chromium, play, scene, tmp_path):
    ask = play(scene.save(tmp_path / "scene.html"))
    ask("kinlib.pause(); kinlib.seek(5)")
    chromium.find_element("css selector", "input[type=range]").send_keys("\ue014")  # the right arrow
    assert ask("return kinlib.frame") == 6
    before = ask("return kinlib.view()")
    chromium.find_element("css selector", ".stage").send_keys("\ue014")
    assert ask("return kinlib.view()") != before
    chromium.find_element("css selector", "[aria-label='Reset the view']").click()
    np.testing.assert_allclose(ask("return kinlib.view()"), before)
    chromium.find_element("css selector", "[aria-label='Play']").send_keys(" ")
    assert ask("return kinlib.playing")


def test_many_scenes_on_one_page_take_turns(chromium, play, tmp_path):
    """A browser has 16 WebGL contexts: a scene holds one only while it is seen, and has the theme of its page."""
    for name, file in static_files().items():
        target = tmp_path / "_static" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(file.read_bytes())
    small = Scene([Ball(np.ones(3), body="ball")], {"ball": TURNING}, alt="A ball.")  # there are many, and all move
    scenes = f"<p>Some text.</p>{small._repr_html_()}" * 18
    root = '<html lang="en" data-content_root="./" data-theme="dark"><meta charset="utf-8"><title>Many</title>'
    (tmp_path / "page.html").write_text(f"<!doctype html>{root}<body>{scenes}</body></html>", encoding="utf-8")
    chromium.get((tmp_path / "page.html").as_uri())
    frames = chromium.find_elements("css selector", "iframe")

    def inside(frame, script):
        chromium.switch_to.frame(frame)
        value = chromium.execute_script(script)
        chromium.switch_to.default_content()
        return value

    for frame in (*frames, frames[0]):
        chromium.execute_script("arguments[0].scrollIntoView({behavior: 'instant'})", frame)
        wait_until(lambda frame=frame: inside(frame, "return !!(window.kinlib && kinlib.ready)"))
    assert inside(frames[0], "return document.documentElement.dataset.theme") == "dark"
    chromium.execute_script("document.documentElement.dataset.theme = 'light'")
    wait_until(lambda: inside(frames[0], "return document.documentElement.dataset.theme") == "light")
    wait_until(lambda: sum(inside(f, "return document.querySelectorAll('canvas').length") for f in frames) <= 3)


def test_linkages_side_by_side_without_poses(linkages):
    grid = linkages_side_by_side(linkages[:2], alt=ALT)
    assert [len(cell["lights"]) for cell in grid.recording()["cells"]] == [0, 0]


NO_WEBGL = "HTMLCanvasElement.prototype.getContext = () => null;"


def colours_near(driver, colour: str) -> int:
    """How many pixels on the screen have a colour, nearly."""
    seen = np.asarray(Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB"), dtype=int)
    wanted = [int(colour[n : n + 2], 16) for n in (1, 3, 5)]
    return int((np.abs(seen - wanted).max(axis=-1) < 28).sum())


@pytest.mark.parametrize("webgl", [True, False])
def test_a_scene_on_a_page_has_the_colours_of_its_legend_also_without_webgl(
    chromium, scene, tmp_path, monkeypatch, webgl
):
    monkeypatch.setenv("KINLIB_SCENE", "inline")
    path = tmp_path / "page.html"
    path.write_text(
        f"<!doctype html><meta charset='utf-8'><title>A scene</title>{scene._repr_html_()}", encoding="utf-8"
    )
    added = chromium.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": "" if webgl else NO_WEBGL})
    try:
        chromium.get(path.as_uri())
    finally:
        chromium.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)
    chromium.switch_to.frame(chromium.find_element("css selector", "iframe"))
    drawn = "return document.body.classList.contains('drawn')"
    told = "return [...document.querySelectorAll('.message')].map((message) => message.textContent).join()"
    wait_until(lambda: chromium.execute_script(drawn) or chromium.execute_script(told))
    assert chromium.execute_script(drawn) == webgl
    assert ("needs WebGL" in chromium.execute_script(told)) != webgl
    chromium.switch_to.default_content()
    assert all(colours_near(chromium, colour) > 250 for _, colour in scene.legend[1:])
