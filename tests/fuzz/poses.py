"""Poses, screws and half-turns as plain arrays of floats: what problems are made of."""

from __future__ import annotations

import numpy as np


def quaternion_product(p, r) -> np.ndarray:
    a, u, b, v = p[..., :1], p[..., 1:], r[..., :1], r[..., 1:]
    scalar = a * b - (u * v).sum(-1, keepdims=True)
    return np.concatenate([scalar, a * v + b * u + np.cross(u, v)], axis=-1)


def compose(x, y) -> np.ndarray:
    """The product of dual quaternions, shape (..., 8)."""
    p, d, r, e = x[..., :4], x[..., 4:], y[..., :4], y[..., 4:]
    return np.concatenate([quaternion_product(p, r), quaternion_product(p, e) + quaternion_product(d, r)], axis=-1)


def pose(turn, position) -> np.ndarray:
    """The dual quaternion of a rotation quaternion followed by a translation."""
    shift = np.concatenate([np.zeros((*position.shape[:-1], 1)), position], axis=-1)
    return np.concatenate([turn, quaternion_product(shift, turn) / 2], axis=-1)


def inverse(x) -> np.ndarray:
    """The inverse of a unit pose."""
    return x * np.array([1, -1, -1, -1] * 2)


def quaternions(random, *shape) -> np.ndarray:
    p = random.normal(size=(*shape, 4))
    return p / np.linalg.norm(p, axis=-1, keepdims=True)


def directions(random, *shape) -> np.ndarray:
    v = random.normal(size=(*shape, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def small_turn(vector) -> np.ndarray:
    """The quaternion of a turn by |vector| radians about the vector."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), vector / 2 * np.sinc(angle / (2 * np.pi))], axis=-1)


def screw(point, direction, angle, pitch) -> np.ndarray:
    """A turn about the line through a point, with a translation along it."""
    turn = small_turn(direction * np.asarray(angle)[..., None])
    turned = quaternion_product(quaternion_product(turn, _pure(point)), turn * [1, -1, -1, -1])[..., 1:]
    return pose(turn, point - turned + direction * np.asarray(pitch)[..., None])


def _pure(v) -> np.ndarray:
    return np.concatenate([np.zeros((*v.shape[:-1], 1)), v], axis=-1)


def random_screw(random, n, pitch) -> np.ndarray:
    return screw(random.normal(size=(n, 3)), directions(random, n), random.uniform(0.4, 2.7, n), pitch)


def half_turns(random, n) -> np.ndarray:
    """Half-turns about random lines."""
    l = directions(random, n)
    return np.concatenate([_pure(l), _pure(np.cross(random.normal(size=(n, 3)), l))], axis=-1)


def factor(t, h) -> np.ndarray:
    """t − h for t of shape (n,), h of shape (n, 8)."""
    x = -h
    x[..., 0] += t
    return x


def of_unit_length(x) -> np.ndarray:
    return x / np.linalg.norm(x[..., :4], axis=-1, keepdims=True)


def in_any_frames(random, poses) -> np.ndarray:
    """The same problem after random changes of the fixed and of the moving frame."""
    fixed, moving = (pose(quaternions(random, poses.shape[1]), random.normal(size=(poses.shape[1], 3))) for _ in "FM")
    return of_unit_length(compose(compose(fixed, poses), moving))


def gaussian(random, count, n, length=1.0) -> np.ndarray:
    return pose(quaternions(random, count, n), length * random.normal(size=(count, n, 3)))


def study_form(x, y) -> np.ndarray:
    return (x[..., :4] * y[..., 4:] + x[..., 4:] * y[..., :4]).sum(-1)
