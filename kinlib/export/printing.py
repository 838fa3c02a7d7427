"""Links and pins for a 3-D printer: closed meshes in millimetres, with clearance and walls, laid flat."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from kinlib.displacement import as_matrix
from kinlib.export.bodies import Bodies
from kinlib.linkage import Linkage
from kinlib.typing import Array, ScalarLike

__all__ = ["PrintSizes", "PrintedParts", "printed_parts"]

SECTIONS = 48
"""Sides of a circle."""

NOTHING = 1e-3
"""Volumes below this many mm³ come from the sides of circles."""

FINEST = 5e-3
"""Details below this many millimetres are left out."""


@dataclass(frozen=True)
class PrintSizes:
    """Sizes of what is printed, in millimetres.

    Parameters
    ----------
    scale : float
        How many millimetres the unit of length is.
    pin : float
        The diameter of the pins.
    clearance : float
        The gap between a pin and its hole all round, and between two links on one pin.
    wall : float
        The thickness of the material around a hole.
    height : float
        The height of the ring around a hole, along the pin.

    Examples
    --------
    >>> PrintSizes(scale=20.0).outer
    10.8
    """

    scale: float
    pin: float = 5.0
    clearance: float = 0.3
    wall: float = 2.6
    height: float = 6.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"expected a positive {name} in millimetres, got {value!r}")

    @property
    def hole(self) -> float:
        """The diameter of the holes."""
        return self.pin + 2 * self.clearance

    @property
    def outer(self) -> float:
        """The diameter of the rings around the holes."""
        return self.hole + 2 * self.wall


@dataclass(frozen=True, eq=False)
class PrintedParts:
    """The parts of one linkage at home, t = ∞.

    Attributes
    ----------
    linkage : Linkage
    meshes : dict of trimesh.Trimesh
        Closed, in millimetres and in their places: ``link-0``, …, ``pin-1``, …, ``cap-1``, …
    bars : array, shape (n, 2, 3)
        The middles of the rings of each link in units of the linkage: bars that
        :meth:`Linkage.clearance <kinlib.Linkage.clearance>` takes.
    sizes : PrintSizes
    """

    linkage: Linkage
    meshes: dict[str, Any]
    bars: Array
    sizes: PrintSizes

    def needed_clearance(self) -> float:
        """How far apart bars must stay so that links that share no joint pass each other, in units of the linkage.

        All parts, heads and caps too, are nearer than half of this to the bars.
        """
        along = self.sizes.height / 2 + self.sizes.clearance + self.sizes.wall
        return float(2 * np.hypot(self.sizes.outer / 2, along) + self.sizes.clearance) / self.sizes.scale

    def placed(self, t: ScalarLike) -> dict[str, Any]:
        """The parts in their places at t, in millimetres; each pin and its cap go with the link before the joint."""
        matrices = as_matrix(self.linkage.astype(float).link_displacements(t))
        matrices[:, :3, 3] *= self.sizes.scale
        moved = {}
        for name, mesh in self.meshes.items():
            kind, number = name.split("-")
            moved[name] = mesh.copy()
            moved[name].apply_transform(matrices[int(number) - (kind != "link")])
        return moved

    def overlaps(self, t: ScalarLike) -> dict[tuple[str, str], float]:
        """Which parts run into each other at t, and the volumes that they share, in mm³."""
        from trimesh.boolean import intersection

        placed, found = self.placed(t), {}
        for (a, first), (b, second) in combinations(placed.items(), 2):
            if np.any(first.bounds[0] > second.bounds[1]) or np.any(second.bounds[0] > first.bounds[1]):
                continue
            common = intersection([first, second], engine="manifold")
            volume = 0.0 if common.is_empty else float(common.volume)
            if volume > NOTHING:
                found[a, b] = volume
        return found

    def laid_flat(self) -> dict[str, Any]:
        """The parts side by side on a plate, z = 0, each at rest on its most stable face; trimesh.Trimesh."""
        return _side_by_side({name: _at_rest(name, mesh) for name, mesh in self.meshes.items()}, 2 * self.sizes.wall)

    def save_stl(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write each part, laid flat by itself, to ``folder`` as STL in millimetres; the paths are returned."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        paths = []
        for name, mesh in self.meshes.items():
            paths.append(folder / f"{name}.stl")
            _at_rest(name, mesh).export(paths[-1])
        return paths

    def save_3mf(self, path: str | os.PathLike[str]) -> None:
        """Write all parts on one plate as 3MF in millimetres."""
        import trimesh

        scene: Any = trimesh.Scene()
        for name, mesh in self.laid_flat().items():
            scene.add_geometry(mesh, geom_name=name, node_name=name)
        Path(path).write_bytes(scene.export(file_type="3mf"))


def printed_parts(linkage: Linkage, sizes: PrintSizes) -> PrintedParts:
    """Links with rings around holes at both ends, and a pin with a cap for each joint.

    On each axis two rings sit beside each other, in the middle between the feet of the two links' common
    perpendiculars, that of the link above that leaves more upwards.  A pin goes through both and has a head; the cap
    is glued to its other end.

    Parameters
    ----------
    linkage : Linkage
        A single one.
    sizes : PrintSizes

    Raises
    ------
    ValueError
        If two holes of a link come too near to each other: then a larger scale is needed.
    ImportError
        If trimesh or manifold3d is missing: pip install "kinlib[export]".

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> parts = printed_parts(bennett_linkage(*gallery.THREE_POSES), PrintSizes(scale=40))
    >>> len(parts.meshes), all(mesh.is_watertight for mesh in parts.meshes.values())
    (12, True)
    """
    _check_libraries()
    bodies = Bodies.of(linkage, sizes.scale)
    step = (sizes.height + sizes.clearance) / 2 * _sides(bodies)[:, None] * bodies.directions
    starts, ends = bodies.anchors + step, bodies.anchors - step
    rings = np.stack([np.roll(starts, 1, axis=0), ends], axis=1)
    axes = np.stack([np.roll(bodies.directions, 1, axis=0), bodies.directions], axis=1)
    _check_room(rings, axes, sizes)
    meshes = {f"link-{n}": _link(rings[n], axes[n], sizes) for n in range(bodies.count)}
    for n in range(bodies.count):
        pin, cap = _pin_and_cap(bodies.anchors[n], bodies.directions[n], sizes)
        meshes[f"pin-{n + 1}"], meshes[f"cap-{n + 1}"] = pin, cap
    return PrintedParts(
        linkage, {name: _checked(name, mesh) for name, mesh in meshes.items()}, rings / sizes.scale, sizes
    )


def _check_libraries() -> None:
    """Refuse to begin where a library of the extra is missing."""
    for name in ("trimesh", "manifold3d", "lxml", "networkx"):
        if find_spec(name) is None:
            raise ImportError(f'printed_parts needs {name}: pip install "kinlib[export]"')


def _sides(bodies: Bodies) -> Array:
    """1 where the link behind a joint sits above, −1 where the one before does: the one that leaves more upwards."""
    ahead, back = (np.roll(bodies.anchors, -s, axis=0) - bodies.anchors for s in (1, -1))
    return np.where(((ahead - back) * bodies.directions).sum(axis=-1) < -1e-9 * bodies.size, -1.0, 1.0)


def _check_room(rings: Array, axes: Array, sizes: PrintSizes) -> None:
    """Refuse links of which one hole cuts the ring of the other."""
    needed = (sizes.hole + sizes.outer) / 2
    reach = sizes.height * np.linspace(-0.5, 0.5, 33)
    lines = rings[:, :, None] + reach[:, None] * axes[:, :, None]
    near = np.linalg.norm(lines[:, 0, :, None] - lines[:, 1, None, :], axis=-1).min(axis=(1, 2))
    if np.any(near < needed):
        link = int(near.argmin())
        raise ValueError(
            f"the holes of link {link} are {near[link]:.3g} mm apart and need {needed:.3g} mm: take a scale of "
            f"{sizes.scale * needed / max(near[link], 1e-3):.3g} mm or more, or thinner pins and walls"
        )


# ---- shapes ------------------------------------------------------------------------------------------


def _cylinder(diameter: float, start: Array, end: Array) -> Any:
    from trimesh.creation import cylinder

    return cylinder(radius=diameter / 2, segment=np.stack([start, end]), sections=SECTIONS)


def _along(middle: Array, axis: Array, height: float) -> tuple[Array, Array]:
    return middle - height / 2 * axis, middle + height / 2 * axis


def _link(rings: Array, axes: Array, sizes: PrintSizes) -> Any:
    """Two rings with a bar between them that leaves room for what else is on the pins; holes drilled through."""
    from trimesh.boolean import difference, union

    solids = [_cylinder(sizes.outer, *_along(m, a, sizes.height)) for m, a in zip(rings, axes, strict=True)]
    room = [cylinder for m, a in zip(rings, axes, strict=True) for cylinder in _room(m, a, sizes)]
    bar = difference([_cylinder(min(sizes.height, sizes.outer) * 0.9, *rings), *room], engine="manifold")
    holes = [_cylinder(sizes.hole, *_along(m, a, sizes.height * 1.02)) for m, a in zip(rings, axes, strict=True)]
    return difference([union([*solids, bar], engine="manifold"), *holes], engine="manifold")


def _room(middle: Array, axis: Array, sizes: PrintSizes) -> list[Any]:
    """Where the other ring, the head and the cap are, on both sides of a ring."""
    reach = sizes.height / 2 + sizes.height + 3 * sizes.clearance + sizes.wall
    wide = sizes.outer + 2 * sizes.clearance
    return [_cylinder(wide, middle + s * sizes.height / 2 * axis, middle + s * reach * axis) for s in (-1, 1)]


def _pin_and_cap(middle: Array, axis: Array, sizes: PrintSizes) -> tuple[Any, Any]:
    """A pin with a head at one end; the cap, with a hole of the pin's own diameter and a little more, at the other."""
    half = sizes.height + sizes.clearance * 1.5  # from the middle to the outer face of a ring, and a gap
    end, pin, outer = half + sizes.wall, sizes.pin / 2, sizes.outer / 2
    glued = pin + sizes.clearance / 4
    profile = [(0, -end), (outer, -end), (outer, -half), (pin, -half), (pin, end), (0, end)]
    ring = [(glued, half), (outer, half), (outer, end), (glued, end), (glued, half)]
    return _turned(profile, middle, axis), _turned(ring, middle, axis)


def _turned(profile: list[tuple[float, float]], middle: Array, axis: Array) -> Any:
    """The solid of revolution of a profile, pairs of radius and height along the axis."""
    from trimesh import geometry
    from trimesh.creation import revolve

    towards: Any = geometry.align_vectors
    solid = revolve(np.array(profile), sections=SECTIONS)
    solid.apply_transform(towards([0, 0, 1], axis))
    solid.apply_translation(middle)
    return solid


def _checked(name: str, mesh: Any) -> Any:
    """The part in single precision, as files keep it, without triangles too small to be told apart then; closed."""
    import manifold3d
    import trimesh

    solid = manifold3d.Manifold(manifold3d.Mesh(np.float32(mesh.vertices), np.uint32(mesh.faces))).simplify(FINEST)
    found = solid.to_mesh()
    closed = trimesh.Trimesh(found.vert_properties[:, :3], found.tri_verts, process=True)
    if not closed.is_volume:
        raise ValueError(f"the mesh of {name} is not closed: other sizes may give one that is")
    if closed.body_count != 1:
        raise ValueError(f"{name} falls apart: its bar runs along a pin; take a larger scale, or lower rings")
    closed.units = "mm"
    return closed


# ---- on the plate ------------------------------------------------------------------------------------


def _at_rest(name: str, mesh: Any) -> Any:
    """The part on its most stable face, on z = 0."""
    from trimesh.poses import compute_stable_poses

    transforms, probabilities = compute_stable_poses(mesh)
    rested = mesh.copy()
    rested.apply_transform(transforms[int(np.argmax(probabilities))])
    rested.apply_translation([0, 0, -rested.bounds[0, 2]])
    return _checked(name, rested)


def _side_by_side(meshes: dict[str, Any], gap: float) -> dict[str, Any]:
    """In rows, about as long as they are many."""
    extents = {name: mesh.extents[:2] for name, mesh in meshes.items()}
    width = 1.3 * np.sqrt(sum((x + gap) * (y + gap) for x, y in extents.values()))
    x = y = depth = 0.0
    placed = {}
    for name, mesh in sorted(meshes.items(), key=lambda item: -extents[item[0]][1]):
        if x > 0 and x + extents[name][0] > width:
            x, y, depth = 0.0, y + depth + gap, 0.0
        placed[name] = mesh.copy()
        placed[name].apply_translation([x - mesh.bounds[0, 0], y - mesh.bounds[0, 1], 0.0])
        x, depth = x + float(extents[name][0]) + gap, max(depth, float(extents[name][1]))
    return {name: placed[name] for name in meshes}
