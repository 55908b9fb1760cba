"""What the controller's stages must do, in dense matrices: an oracle for small quadratic problems."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation


def diagonal(weights: np.ndarray) -> np.ndarray:
    """(p_xy, p_z, attitude, velocity) on nine deviations; an attitude error is charged Q / 4 |theta|^2."""
    xy, z, attitude, velocity = weights
    return np.array([xy, xy, z, *[attitude / 4] * 3, *[velocity] * 3])


def difference(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """From a to b (p q v), attitudes as twice the vector part of conj(a) o b."""
    w, v = a[3], a[4:7]
    turn = w * b[4:7] - b[3] * v - np.cross(v, b[4:7])
    return np.concatenate([b[:3] - a[:3], 2 * turn, b[7:10] - a[7:10]])


@cache
def linearised_node_map():
    """Of `dynamics`, once a process: the expressions take longer to write than to evaluate."""
    from hotlap.dynamics import models  # noqa: PLC0415  not where nothing is linearised

    return models.linearised_node_map()


def unpack(jacobian: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """A (9, 9) and B (9, 4) of `models.node_jacobian`."""
    turn, rates, speed = jacobian[:9].reshape(3, 3), jacobian[9:18].reshape(3, 3), jacobian[18:].reshape(3, 7)
    A, B = np.eye(9), np.zeros((9, 4))
    A[3:6, 3:6], B[3:6, 1:] = turn, rates
    A[6:, 3:6], B[6:] = speed[:, :3], speed[:, 3:]
    A[:3, 6:], A[:3, 3:6], B[:3] = h * np.eye(3), h / 2 * speed[:, :3], h / 2 * speed[:, 3:]
    return A, B


class Policy(NamedTuple):
    """The best input of a stage, its feedback, and the value before it."""

    step: np.ndarray
    gains: np.ndarray
    P: np.ndarray
    p: np.ndarray


def best_input(H: np.ndarray, g: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minimiser of g u + u H u / 2 within bounds and which inputs are free: every set of active bounds is tried."""
    for active in product((-1, 0, 1), repeat=4):
        held = np.array(active)
        free = held == 0
        u = np.where(held < 0, low, high)
        u[free] = np.linalg.solve(H[np.ix_(free, free)], -(g + H[:, ~free] @ u[~free])[free])
        slope = g + H @ u
        if (u >= low - 1e-12).all() and (u <= high + 1e-12).all() and (slope[held < 0] >= 0).all() and (slope[held > 0] <= 0).all():
            return u, free
    raise AssertionError("a strictly convex problem has a minimum")


def backward(
    P: np.ndarray, p: np.ndarray, A: np.ndarray, B: np.ndarray, Q: np.ndarray, q: np.ndarray, R: np.ndarray, r: np.ndarray,
    low: np.ndarray, high: np.ndarray,
) -> Policy:  # fmt: skip
    """One stage: cost q x + x Q x / 2 + r u + u R u / 2 and the value (P, p) of A x + B u, at x = 0."""
    Quu, Qux, Qu, Qx = R + B.T @ P @ B, B.T @ P @ A, r + B.T @ p, q + A.T @ p
    step, free = best_input(Quu, Qu, low, high)
    gains = np.zeros((4, 9))
    gains[free] = -np.linalg.solve(Quu[np.ix_(free, free)], Qux[free])
    slope = Qx + gains.T @ (Qu + Quu @ step) + Qux.T @ step
    return Policy(step, gains, Q + A.T @ P @ A + Qux.T @ gains, slope)


def solve_whole(
    As: list[np.ndarray], Bs: list[np.ndarray], defects: np.ndarray, errors: np.ndarray, Q: np.ndarray, R: np.ndarray,
    wanted: np.ndarray, low: np.ndarray, high: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The whole horizon as one bounded least-squares problem, solved to the end.

    x[n + 1] = A x[n] + B du[n] + defects[n] from x[0] = 0; cost of (x - errors) under Q, and of du - wanted under R.

    Returns:
        Inputs (N, 4) and deviations (N + 1, 9).
    """
    nodes = len(As)
    rows, offsets = [np.zeros((9, 4 * nodes))], [np.zeros(9)]
    for n in range(nodes):
        step = As[n] @ rows[-1]
        step[:, 4 * n : 4 * n + 4] += Bs[n]
        rows.append(step)
        offsets.append(As[n] @ offsets[-1] + defects[n])
    states = np.sqrt(Q)[:, None]
    matrix = np.vstack([*(states * row for row in rows), np.kron(np.eye(nodes), np.diag(np.sqrt(R)))])
    target = np.concatenate([*(np.sqrt(Q) * (errors[n] - offsets[n]) for n in range(nodes + 1)), (np.sqrt(R) * wanted).ravel()])
    result = lsq_linear(matrix, target, (low.ravel(), high.ravel()), method="bvls", tol=1e-14, max_iter=500)
    assert result.status > 0
    inputs = result.x.reshape(nodes, 4)
    return inputs, np.array([row @ result.x + offset for row, offset in zip(rows, offsets, strict=True)])


def draw_state(rng: np.random.Generator) -> np.ndarray:
    """Any p q v."""
    return np.concatenate([rng.normal(size=3), Rotation.random(None, rng).as_quat(), 5 * rng.normal(size=3)])


def moved(x: np.ndarray, change: np.ndarray) -> np.ndarray:
    """x moved by (p, theta, v): q o [1, theta / 2], normalised."""
    turn = np.append(change[3:6] / 2, 1.0)
    q = np.roll((Rotation.from_quat(np.roll(x[3:7], -1)) * Rotation.from_quat(turn)).as_quat(), 1)
    q *= np.sign(q @ x[3:7])
    return np.concatenate([x[:3] + change[:3], q, x[7:10] + change[6:]])
