"""Files for other programs, each read back by the program that they are for."""

from __future__ import annotations

import json
import math
import sys

import mujoco
import numpy as np
import pytest
import trimesh
import yourdfpy

from kinlib import (
    DualQuaternion,
    act,
    bennett_linkage,
    from_matrix,
    goldberg_linkages,
    same_point,
    six_r_linkages,
)
from kinlib.export import (
    PrintSizes,
    as_mjcf,
    as_rational_linkages,
    as_urdf,
    closing_constraint,
    from_rational_linkages,
    printed_parts,
    save_urdf,
)
from kinlib.gallery import THREE_POSES
from kinlib.testing import random_poses

THREE = random_poses(3, seed=1)
BENNETT, FIVE = bennett_linkage(*THREE_POSES), goldberg_linkages(*THREE, 0.4 + 0.9j)[0]
SIX = six_r_linkages(*random_poses(4, seed=5))[-1]
NASTY = 'it\'s "../../etc"\n<&>\x00'
BATCH = bennett_linkage(*random_poses(3, seed=1, shape=(2,)))


# ---- MuJoCo ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("linkage", "off"), [(BENNETT, 1e-4), (FIVE, 1e-3), (SIX, 1e-2)], ids=repr)
def test_a_linkage_moves_in_mujoco_as_it_does_here(linkage, off):
    driven = next(n for n in range(linkage.joint_count) if linkage.turns()[n] == 1)
    model = mujoco.MjModel.from_xml_string(as_mjcf(linkage, drive=driven))
    data = mujoco.MjData(model)
    data.ctrl[0] = 2.0
    floats, far = linkage.astype(float), 0.0
    while data.time < math.pi:
        mujoco.mj_step(model, data, nstep=100)
        mujoco.mj_kinematics(model, data)
        (t,) = floats.parameter_of(data.qpos[driven], driven)
        far = max(far, np.abs(np.sin((floats.joint_angles(t)[:-1] - data.qpos) / 2)).max())
        link = int(model.body("link 2").id)
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = data.xmat[link].reshape(3, 3), data.xpos[link]
        assert np.all(same_point(from_matrix(place, rtol=1e-6), floats.link_displacements(t)[2], rtol=off, length=10))
    assert far < off
    assert data.qpos[driven] > 0.8 * 2 * math.pi  # once round, nearly


def test_without_its_constraints_the_chain_would_fall_open():
    text = as_mjcf(BENNETT)
    start, end = text.index("<equality>"), text.index("</equality>")
    model = mujoco.MjModel.from_xml_string(text[:start] + "<equality>" + text[end:])
    data = mujoco.MjData(model)
    data.ctrl[0] = 2.0
    mujoco.mj_step(model, data, nstep=2000)
    (t,) = BENNETT.parameter_of(data.qpos[0], 0)
    assert np.abs(np.sin((BENNETT.joint_angles(t)[:-1] - data.qpos) / 2)).max() > 0.1


def test_models_of_mujoco_have_the_scale_and_the_name_that_they_are_given():
    model = mujoco.MjModel.from_xml_string(as_mjcf(FIVE, name=NASTY.replace("\x00", ""), scale=0.01, drive=None))
    assert model.nu == 0
    assert model.opt.gravity.tolist() == [0, 0, 0]
    ends = model.body_pos[1:] + model.jnt_pos[0]
    assert np.abs(ends).max() < 0.2
    assert mujoco.MjModel.from_xml_string(as_mjcf(FIVE, name=NASTY, gravity=True)).opt.gravity[2] == -9.81


# ---- URDF --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("linkage", [BENNETT, FIVE, SIX], ids=repr)
def test_a_urdf_tree_is_closed_by_its_constraint(linkage, tmp_path):
    save_urdf(linkage, tmp_path / "it.urdf", name=NASTY, scale=0.1)
    robot = yourdfpy.URDF.load(str(tmp_path / "it.urdf"))
    hinge = json.loads((tmp_path / "it.loop.json").read_text())["loop"]
    assert hinge == closing_constraint(linkage, scale=0.1)
    assert robot.num_actuated_joints == linkage.joint_count - 1
    for t in (0.3, -2.0, math.inf):
        robot.update_cfg(linkage.joint_angles(t)[:-1])
        matrix = robot.get_transform(hinge["parent"]["link"], hinge["child"]["link"])
        assert np.allclose(matrix @ [*hinge["parent"]["point"], 1], [*hinge["child"]["point"], 1], atol=1e-12)
        assert np.allclose(matrix[:3, :3] @ hinge["parent"]["axis"], hinge["child"]["axis"], atol=1e-12)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["it.loop.json", "it.urdf"]


def test_mujoco_reads_the_urdf_too_and_agrees_on_the_inertia():
    model = mujoco.MjModel.from_xml_string(as_urdf(FIVE))
    bars = FIVE.bars()
    lengths = np.linalg.norm(bars[:, 1] - bars[:, 0], axis=-1)
    radius = np.linalg.norm(bars - bars.mean(axis=(0, 1)), axis=-1).max() / 30
    assert np.allclose(model.body_mass[1:], 1000 * math.pi * radius**2 * lengths[1:])
    across = model.body_mass[1:] * (3 * radius**2 + lengths[1:] ** 2) / 12
    assert np.allclose(model.body_inertia[1:].max(axis=-1), across)


# ---- rational-linkages -------------------------------------------------------------------------------


def test_chains_of_rational_linkages_come_back():
    first, second = as_rational_linkages(FIVE)
    again = from_rational_linkages(first, second, home=FIVE.home)
    assert all(np.all(f == g) for f, g in zip(again.factors, FIVE.factors, strict=True))
    f, g = (DualQuaternion(chain[0]) for chain in (first, second))
    assert np.all(f.coeffs[:4] == FIVE.factors[0].coeffs[:4])
    assert np.all(f.coeffs[4:] == -FIVE.factors[0].coeffs[4:])
    assert np.all(g == FIVE.factors[-1].conjugate().eps_conjugate())


# ---- parts for a printer -----------------------------------------------------------------------------

SIZES = PrintSizes(scale=60.0, pin=5.0, clearance=0.3, wall=2.6, height=6.0)


@pytest.fixture(scope="module")
def parts():
    return printed_parts(FIVE, SIZES)


def test_parts_are_closed_and_stay_so_in_files(parts, tmp_path):
    assert list(parts.meshes) == [f"link-{n}" for n in range(5)] + [
        f"{x}-{n}" for n in range(1, 6) for x in ("pin", "cap")
    ]
    assert all(mesh.is_volume and mesh.body_count == 1 for mesh in parts.meshes.values())
    paths = parts.save_stl(tmp_path / "stl")
    assert [path.name for path in paths] == [f"{name}.stl" for name in parts.meshes]
    for path, mesh in zip(paths, parts.meshes.values(), strict=True):
        read = trimesh.load(path)
        assert read.is_watertight
        assert math.isclose(read.volume, mesh.volume, rel_tol=1e-3)
        assert abs(read.bounds[0, 2]) < 1e-3
    parts.save_3mf(tmp_path / "plate.3mf")
    plate = trimesh.load(tmp_path / "plate.3mf")
    assert plate.units == "millimeter"
    assert set(plate.geometry) == set(parts.meshes)
    assert all(mesh.is_watertight for mesh in plate.geometry.values())


def test_parts_on_the_plate_lie_on_it_and_apart(parts):
    boxes = [mesh.bounds for mesh in parts.laid_flat().values()]
    assert max(abs(low[2]) for low, _ in boxes) < 1e-3
    for n, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:n]:
            assert np.any(low[:2] > other_high[:2] + SIZES.wall) or np.any(other_low[:2] > high[:2] + SIZES.wall)


def test_pins_turn_in_their_holes_with_the_clearance_and_walls_are_as_thick_as_asked(parts):
    """Rays across the axis of a joint meet the pin, then the hole, then the outside of the ring."""
    for n in range(5):
        axis = FIVE.chain.lines.directions[n]
        across = np.cross(axis, [0.3, -0.5, 0.8])
        across /= np.linalg.norm(across)
        for link, end in ((n, 1), ((n + 1) % 5, 0)):
            middle = parts.bars[link, end] * SIZES.scale
            assert not parts.meshes[f"link-{link}"].contains([middle])[0]
            assert parts.meshes[f"pin-{n + 1}"].contains([middle])[0]
            radii = np.linspace(0, SIZES.outer, 400)
            around = [across, -across, np.cross(axis, across), np.cross(across, axis)]
            inside = np.array([parts.meshes[f"link-{link}"].contains(middle + radii[:, None] * u) for u in around])
            first = radii[inside.argmax(axis=1)]
            assert np.abs(first - SIZES.hole / 2).max() < 0.05
            pin = parts.meshes[f"pin-{n + 1}"].contains(middle + radii[:, None] * across)
            assert abs(radii[~pin][0] - SIZES.pin / 2) < 0.05
            walls = [radii[row & (radii > r)].max() - r for row, r in zip(inside, first, strict=True)]
            assert min(walls) > SIZES.wall - 0.05
    ends = parts.bars[[0, 1], [1, 0]] * SIZES.scale  # the two rings on the first pin
    for part in (parts.meshes["pin-1"], parts.meshes["cap-1"]):
        away = np.min([np.linalg.norm(part.vertices - end, axis=-1) for end in ends], axis=0)
        assert away.max() < parts.needed_clearance() * SIZES.scale / 2


def test_parts_of_one_joint_do_not_overlap(parts):
    assert not any(abs(int(a[-1]) - int(b[-1])) < 2 and "pin" in a for a, b in parts.overlaps(0.3))
    for n in range(5):
        joined = [parts.meshes[name] for name in (f"link-{n}", f"link-{(n + 1) % 5}", f"pin-{n + 1}", f"cap-{n + 1}")]
        for a in range(4):
            for b in range(a):
                if {a, b} != {0, 1}:  # bars of two links may run close by each other
                    common = trimesh.boolean.intersection([joined[a], joined[b]], engine="manifold")
                    assert common.is_empty or common.volume < 1e-6


def test_parts_move_with_their_links(parts):
    placed = parts.placed(0.7)
    moved = FIVE.link_displacements(0.7)
    for name, link in (("link-3", 3), ("pin-3", 2), ("cap-1", 0)):
        expected = act(moved[link], parts.meshes[name].vertices / SIZES.scale) * SIZES.scale
        assert np.allclose(placed[name].vertices, expected, atol=1e-6)


def test_a_linkage_with_enough_clearance_goes_round_and_one_with_too_little_does_not():
    free = goldberg_linkages(*THREE_POSES, -1.6755 - 1.3164j)[3]
    parts = printed_parts(free, PrintSizes(scale=90.0))
    assert free.clearance(parts.bars) > parts.needed_clearance()
    assert [parts.overlaps(t) for t in (-2.0, -0.3, 0.4, 3.0)] == [{}] * 4
    folding = printed_parts(BENNETT, PrintSizes(scale=40.0))
    assert BENNETT.clearance(folding.bars) < folding.needed_clearance()
    assert ("link-0", "link-2") in folding.overlaps(0.0)  # where its straight bars meet


# ---- what is refused ---------------------------------------------------------------------------------


def test_what_can_not_be_written_is_refused_with_words():
    for write in (as_mjcf, as_urdf, lambda x: printed_parts(x, SIZES)):
        with pytest.raises(ValueError, match="expected a single linkage: index the batch"):
            write(BATCH)
    with pytest.raises(ValueError, match="expected a positive scale"):
        as_urdf(FIVE, scale=0.0)
    with pytest.raises(ValueError, match="expected a joint to drive among 0, …, 3, got 4"):
        as_mjcf(FIVE, drive=4)
    with pytest.raises(ValueError, match="expected a positive wall in millimetres, got -1"):
        PrintSizes(scale=10, wall=-1)
    with pytest.raises(ValueError, match=r"the holes of link \d are .* mm apart and need .* mm: take a scale of"):
        printed_parts(FIVE, PrintSizes(scale=5))


def test_a_library_that_is_missing_is_named_with_what_brings_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    with pytest.raises(ImportError, match=r'printed_parts needs manifold3d: pip install "kinlib\[export\]"'):
        printed_parts(bennett_linkage(*THREE_POSES), PrintSizes(scale=40))
