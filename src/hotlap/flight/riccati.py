"""Box-constrained Riccati stages of the controller, as straight-line programs.

The quadratic problem around the plan (Eq. 3 of the paper, linearised) is solved by control-limited sweeps (Tassa, Mansard, Todorov,
"Control-limited differential dynamic programming", ICRA 2014): backward, each stage finds the best input within its bounds and the
feedback of the free inputs; forward, the inputs follow. Deviations are (p, theta, v), inputs (thrust, rates); `dynamics.node_jacobian`
has the structure of the Jacobian [A B] that the formulas use:

    theta+ = Ct [theta, w],   v+ = v + Cv [theta, T, w],   p+ = p + h v + h / 2 Cv [theta, T, w]

Weights Q are (p_xy, p_z, attitude, velocity); an attitude error is charged Q |q - q_ref|^2 = Q / 4 |theta|^2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hotlap.dynamics.parameter_layout import NODE_JACOBIAN
from hotlap.flight.program import Number, Program, Tape, dot

P_SIZE, GAIN_SIZE, SCRATCH_SIZE = 45, 36, 192  # lower triangle of 9 x 9; 4 x 9
INNER_STEPS = 2  # projected Newton steps of a stage's input
ROW_GROUPS = ((6, 0), (7, 1), (8, 2), (3, 4), (5,))  # rows of P C that share loads of C, in the order in which they are needed

Matrix = Mapping[tuple[int, int], Number]


def triangle(i: int, j: int) -> int:
    """Place of (i, j) in a symmetric matrix stored as its lower triangle, row by row."""
    return i * (i + 1) // 2 + j if i >= j else j * (j + 1) // 2 + i


def terminal_stage() -> Program:
    """(x, deviation, reference, Q) -> P, p of the last node."""
    tape = Tape()
    x, deviation, reference, weights = (tape.array(k, size) for k, size in enumerate((10, 9, 14, 4)))
    diagonal = _diagonal(weights)
    for i in range(9):
        tape.store(4, [0.0] * i + [diagonal[i]], triangle(i, 0))
    tape.store(5, state_gradient(diagonal, x, deviation, reference))
    return tape.program


def backward_stage() -> Program:
    """(P+, p+, C, x, deviation, u, reference, Q, R, h, low, high) -> P, p, gains K, feed-forward k, scratch.

    P+ and p+ are of the next node and may not be P and p. The policy is u + k + K e, e the change of the deviation.
    """
    return StructuredBackward().build()


def follow_structured(c: Sequence[Number], e: Sequence[Number], changes: Sequence[Number], h: Number) -> list[Number]:
    """The change of the next deviation by that of this one and of the input: [A B] (e, change)."""
    speed = [dot(c[18 + 7 * i : 25 + 7 * i], [*e[3:6], *changes]) for i in range(3)]
    return [
        *(e[i] + h * (e[6 + i] + 0.5 * speed[i]) for i in range(3)),
        *(dot([*c[3 * i : 3 * i + 3], *c[9 + 3 * i : 12 + 3 * i]], [*e[3:6], *changes[1:]]) for i in range(3)),
        *(e[6 + i] + speed[i] for i in range(3)),
    ]


def forward_stage(follow: Callable[..., list[Number]] = follow_structured, jacobian_size: int = NODE_JACOBIAN) -> Program:
    """(C, K, k, e, u, deviation+, h, low, high, needs_sweep, convergence) -> u, e+, deviation+, convergence.

    Lanes that need no sweep keep their input and deviation bit for bit. `convergence` is of the nodes so far: the largest change of an
    input, and 1 if one of them is at a bound.
    """
    tape = Tape()
    sizes = (jacobian_size, GAIN_SIZE, 4, 9, 4, 9, 1, 4, 4, 1, 2)
    c, gains, feed, e, u, deviation, (h,), low, high, (needs_sweep,), (moved, bound) = (tape.array(k, size) for k, size in enumerate(sizes))
    moves = needs_sweep > 0.5
    inputs, changes = [], []
    for a in range(4):
        k = gains[9 * a : 9 * a + 9]
        wanted = (u[a] + feed[a] + dot(k[:3], e[:3])) + (dot(k[3:6], e[3:6]) + dot(k[6:], e[6:]))
        bounded = wanted.maximum(low[a]).minimum(high[a])
        inputs.append(moves.where(bounded, u[a]))
        changes.append(inputs[a] - u[a])
        moved = moved.maximum(changes[a].maximum(-changes[a]))
        bound = ((bounded <= low[a]) | (bounded >= high[a])).where(1.0, bound)
    following = follow(c, e, changes, h)
    tape.store(11, inputs)
    tape.store(12, following)
    tape.store(13, [deviation[i] + following[i] for i in range(9)])
    tape.store(14, [moved, bound])
    return tape.program


def _diagonal(weights: Sequence[Number]) -> list[Number]:
    """Weights of the nine deviations."""
    xy, z, attitude, velocity = weights
    return [xy, xy, z, *[0.25 * attitude] * 3, *[velocity] * 3]


def state_gradient(diagonal: Sequence[Number], x: Sequence[Number], deviation: Sequence[Number], r: Sequence[Number]) -> list[Number]:
    """Q (x + deviation - reference) in tangent coordinates."""
    error = attitude_error(x[3:7], r[3:7])
    return [
        *(diagonal[i] * (x[i] + deviation[i] - r[i]) for i in range(3)),
        *(diagonal[3 + i] * (deviation[3 + i] - 2.0 * error[i]) for i in range(3)),
        *(diagonal[6 + i] * (x[7 + i] + deviation[6 + i] - r[7 + i]) for i in range(3)),
    ]


def attitude_error(a: Sequence[Number], b: Sequence[Number]) -> list[Number]:
    """From attitude a to b (body): the vector part of conj(a) o b."""
    return [
        a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ]


class Backward:
    """Writes the backward stage in sections; each one ends by storing in `scratch` what later ones need."""

    jacobian_size, scratch_size = NODE_JACOBIAN, SCRATCH_SIZE
    Quu: dict[tuple[int, int], Number]
    Qu: list[Number]
    Qx: list[Number]
    Y: list[list[Number]]  # Q_ux
    inverse: list[Number]
    gradient: list[Number]
    step: list[Number]

    def __init__(self) -> None:
        self.tape = tape = Tape()
        sizes = (P_SIZE, 9, self.jacobian_size, 10, 9, 4, 14, 4, 4, 1, 4, 4)
        self.P, self.p, self.jacobian, self.x, self.deviation, self.u, self.r, weights, self.R, (self.h,), self.low, self.high = (
            tape.array(k, size) for k, size in enumerate(sizes)
        )
        self.Q = _diagonal(weights)
        self.half = 0.5 * self.h
        self.used = 0

    def build(self) -> Program:
        """All sections in turn."""
        self._propagate()
        self._collect()
        self._minimise()
        self._close_gains()
        self._close_value()
        return self.tape.program

    def _keep(self, values: Sequence[Number]) -> list[Number]:
        """Put values into the scratch memory."""
        kept = self.tape.store(16, values, self.used)
        self.used += len(values)
        assert self.used <= self.scratch_size  # noqa: S101  our own mistake
        return kept

    def _value(self, i: int, j: int) -> Number:
        """P+(i, j)."""
        return self.P[triangle(i, j)]

    def _propagate(self) -> None:
        """The products of P+ and [A B] that the other sections use."""
        raise NotImplementedError

    def _collect(self) -> None:
        """Q_uu and the gradients."""
        raise NotImplementedError

    def _minimise(self) -> None:
        """The best input within its bounds: step, gradient there, inverse over the free inputs; and Q_ux."""
        raise NotImplementedError

    def _state_curvature(self, i: int, j: int) -> Number:
        """Q_xx(i, j), i >= j: the state's own weight and A' P+ A."""
        raise NotImplementedError

    def _newton(
        self, room: Sequence[tuple[Number, Number]], step: list[Number] | None, gradient: Sequence[Number]
    ) -> tuple[dict[tuple[int, int], Any], list[Number], list[Number]]:
        """Inverse of Q_uu over the free inputs, step projected on the box, gradient there."""
        now = step or [self.tape.lift(0.0)] * 4
        held = [((now[a] <= low) & (gradient[a] > 0.0)) | ((now[a] >= high) & (gradient[a] < 0.0)) for a, (low, high) in enumerate(room)]
        masked = {
            (a, b): held[a].where(1.0, entry) if a == b else (held[a] | held[b]).where(0.0, entry) for (a, b), entry in self.Quu.items()
        }
        inverse = invert(masked)
        for a in range(4):
            inverse[a, a] = held[a].where(0.0, inverse[a, a])
        moves = [dot([inverse[max(a, b), min(a, b)] for b in range(4)], gradient) for a in range(4)]
        projected = []
        for a, (low, high) in enumerate(room):
            target = now[a] - moves[a] if step else -moves[a]
            projected.append(target.maximum(low).minimum(high))
        after = [self.Qu[a] + dot([self.Quu[max(a, b), min(a, b)] for b in range(4)], projected) for a in range(4)]
        return inverse, projected, after

    def _close_gains(self) -> None:
        """K = -(inverse over the free inputs) Q_ux."""
        negative = [[-self.inverse[triangle(a, b)] for b in range(4)] for a in range(4)]
        gains: list[list[Number]] = [[] for _ in range(4)]
        for j in range(9):
            for a in range(4):
                gains[a].append(dot(negative[a], [self.Y[b][j] for b in range(4)]))
        kept = self.tape.store(14, [entry for row in gains for entry in row])
        self.K = [kept[9 * a : 9 * a + 9] for a in range(4)]
        self.tape.section()

    def _close_value(self) -> None:
        """P = Q_xx + Q_ux' K and p = Q_x + K' gradient + Q_ux' step."""
        for i in range(9):
            row, slope = [self._state_curvature(i, j) for j in range(i + 1)], self.Qx[i]
            for a in range(4):
                for j in range(i + 1):
                    row[j] = row[j] + self.Y[a][i] * self.K[a][j]
                slope = slope + self.K[a][i] * self.gradient[a] + self.Y[a][i] * self.step[a]
            self.tape.store(12, row, triangle(i, 0))
            self.tape.store(13, [slope], i)
            if i in (3, 5, 6, 7):
                self.tape.section()


class StructuredBackward(Backward):
    """The backward stage for the Jacobian of the paper's model, of which `dynamics.node_jacobian` keeps what is neither 0 nor 1."""

    def __init__(self) -> None:
        super().__init__()
        c = self.jacobian
        self.Cv = [c[18 + 7 * i : 25 + 7 * i] for i in range(3)]
        self.Ct = [[*c[3 * i : 3 * i + 3], None, *c[9 + 3 * i : 12 + 3 * i]] for i in range(3)]  # the thrust turns nothing

    def _times_jacobian(
        self, speed: Sequence[Sequence[Number]], turn: Sequence[Sequence[Number]], columns: Sequence[int]
    ) -> list[list[Any]]:
        """speed Cv + turn Ct for several rows and some columns of (theta, T, w), product by product: a load of C serves all rows."""
        sums: list[list[Any]] = [[speed[r][0] * self.Cv[0][j] for j in columns] for r in range(len(speed))]
        for k in (1, 2):
            for m, j in enumerate(columns):
                for r, row in enumerate(speed):
                    sums[r][m] = sums[r][m] + row[k] * self.Cv[k][j]
        for k in range(3):
            for m, j in enumerate(columns):
                entry = self.Ct[k][j]
                for r, row in enumerate(turn):
                    if entry is not None:
                        sums[r][m] = sums[r][m] + row[k] * entry
        return sums

    def _propagate(self) -> None:
        """W = P+ [A B] in the columns of (theta, T, w), and the rows of C' W in v: Wh = W_v + h / 2 W_p."""
        self.W: dict[int, list[Number]] = {}
        for rows in ROW_GROUPS:
            speed = [[self._value(i, 6 + k) + self.half * self._value(i, k) for k in range(3)] for i in rows]
            turn = [[self._value(i, 3 + k) for k in range(3)] for i in rows]
            for i, row in zip(rows, self._times_jacobian(speed, turn, range(7)), strict=True):
                self.W[i] = self._keep(row)
            self.tape.section()
        self.Wh = [self._keep([self.W[6 + i][j] + self.half * self.W[i][j] for j in range(7)]) for i in range(3)]
        self.pv = self._keep([self.p[6 + k] + self.half * self.p[k] for k in range(3)])
        self.tape.section()

    def _congruence(self, rows: Sequence[int], columns: Sequence[int]) -> dict[tuple[int, int], Number]:
        """(C' P C)(i, j) for i in columns, j in rows, both of (theta, T, w)."""
        speed = [[self.Wh[k][j] for k in range(3)] for j in rows]
        turn = [[self.W[3 + k][j] for k in range(3)] for j in rows]
        product = self._times_jacobian(speed, turn, columns)
        return {(i, j): product[m][n] for m, j in enumerate(rows) for n, i in enumerate(columns)}

    def _collect(self) -> None:
        """Q_uu and the gradients."""
        entries = {**self._congruence((3, 4), (3, 4, 5, 6)), **self._congruence((5, 6), (5, 6))}
        self.Cp = self._times_jacobian([self.pv], [self.p[3:6]], range(7))[0]
        self.Quu = {}
        for a in range(4):
            for b in range(a + 1):
                entry = entries[3 + a, 3 + b]
                self.Quu[a, b] = entry + self.R[a] if a == b else entry
        self.Qu = [self.Cp[3 + a] + self.R[a] * (self.u[a] - self.r[10 + a]) for a in range(4)]
        self.tape.section()

    def _minimise(self) -> None:
        """The input's box problem by projected Newton steps, with independent products written in between.

        A Newton step waits for its divisions: the processor computes the products meanwhile.
        """
        room = [(self.low[a] - self.u[a], self.high[a] - self.u[a]) for a in range(4)]
        inverse, step, gradient = self._newton(room, None, self.Qu)
        mixed = {**self._congruence((0, 1), (3, 4, 5, 6)), **self._congruence((2,), (3, 4, 5, 6))}
        Y_theta = [self._keep([mixed[3 + a, j] for j in range(3)]) for a in range(4)]
        for _ in range(INNER_STEPS - 1):
            inverse, step, gradient = self._newton(room, step, gradient)
        turn = {**self._congruence((0,), (0, 1, 2)), **self._congruence((1,), (1, 2)), **self._congruence((2,), (2,))}
        turn_entries = [turn[i, j] + self.Q[3] if i == j else turn[i, j] for i in range(3) for j in range(i + 1)]
        self.Q_theta = self._keep(turn_entries)
        gradient_x = state_gradient(self.Q, self.x, self.deviation, self.r)
        ahead = [*self.p[:3], *self.Cp[:3], *(self.p[6 + i] + self.h * self.p[i] for i in range(3))]
        self.Qx = self._keep([ahead[i] + gradient_x[i] for i in range(9)])
        Y_v = [self._keep([self.Wh[j][3 + a] + self.half * self.W[j][3 + a] for j in range(3)]) for a in range(4)]
        self.tape.store(15, step)
        self.inverse = self._keep([inverse[a, b] for a in range(4) for b in range(a + 1)])
        self.gradient, self.step = self._keep(gradient), self._keep(step)
        self.tape.section()
        self.Y = [[*(self.W[j][3 + a] for j in range(3)), *Y_theta[a], *Y_v[a]] for a in range(4)]  # Q_ux

    def _state_curvature(self, i: int, j: int) -> Number:
        """Q_xx(i, j), i >= j: the state's own weight and A' P+ A."""
        (kind_i, i3), (kind_j, j3) = divmod(i, 3), divmod(j, 3)
        if kind_i == 0:
            entry = self._value(i, j)
        elif kind_i == 1:  # its weight is within Q_theta already
            return self.W[j3][i3] if kind_j == 0 else self.Q_theta[triangle(i3, j3)]
        elif kind_j == 0:
            return self._value(i, j) + self.h * self._value(i3, j)
        elif kind_j == 1:
            return self.Wh[i3][j3] + self.half * self.W[i3][j3]
        else:
            entry = self._value(i, j) + self.h * (self._value(j, i3) + (self._value(i, j3) + self.h * self._value(i3, j3)))
        return entry + self.Q[i] if i == j else entry


def invert(m: Matrix) -> dict[tuple[int, int], Any]:
    """Inverse of a symmetric 4 x 4 matrix, both as lower triangles, by blocks of 2 x 2: two divisions."""
    scale = 1.0 / (m[0, 0] * m[1, 1] - m[1, 0] * m[1, 0])
    A = [[m[1, 1] * scale, -(m[1, 0] * scale)], [-(m[1, 0] * scale), m[0, 0] * scale]]
    W = [[m[2 + i, 0] * A[0][j] + m[2 + i, 1] * A[1][j] for j in range(2)] for i in range(2)]
    schur = {(i, j): m[2 + i, 2 + j] - W[i][0] * m[2 + j, 0] - W[i][1] * m[2 + j, 1] for i, j in ((0, 0), (1, 0), (1, 1))}
    scale = 1.0 / (schur[0, 0] * schur[1, 1] - schur[1, 0] * schur[1, 0])
    S = [[schur[1, 1] * scale, -(schur[1, 0] * scale)], [-(schur[1, 0] * scale), schur[0, 0] * scale]]
    V = [[S[i][0] * W[0][j] + S[i][1] * W[1][j] for j in range(2)] for i in range(2)]
    inverse: dict[tuple[int, int], Any] = {(2, 2): S[0][0], (3, 2): S[1][0], (3, 3): S[1][1]}
    inverse |= {(2 + i, j): -V[i][j] for i in range(2) for j in range(2)}
    inverse |= {(i, j): A[i][j] + W[0][i] * V[0][j] + W[1][i] * V[1][j] for i, j in ((0, 0), (1, 0), (1, 1))}
    return inverse
