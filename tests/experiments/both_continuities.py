#!/usr/bin/env python3
"""Would equal displacements besides equal velocities (Kwon, Prakash 2025) serve a dual interface? tests/experiments/
both_continuities.py. A bar of stiffness and density 1 is cut in two. One half takes the trapezoidal rule in windows
m dt, the other central differences in m steps dt, 0.1 to 0.97 of its critical step. A multiplier between them is a
function of the time in a window. Prints by how much the spectral radius of a window exceeds 1, the worst over the
steps, for prakash_hjelmstad (linear multiplier, equal velocities at the end) and for what also closes the gap of the
displacements there:
  quadratic   the multiplier has a free value in the middle; both gaps are 0 at the end of the window
  broken      so does a multiplier that is linear in each half
  Baumgarte   velocities differ by -0.1 of the displacement's gap over the window
  moved       the shared nodes are moved together after each window, in inverse proportion to their masses
then the drift of prakash_hjelmstad, the largest gap of the displacements of a standing wave of amplitude 1, after 100
and 10 000 windows. Needs numpy."""
import numpy as np

COURANT = (0.1, 0.3, 0.5, 0.7, 0.9, 0.97)
BARS = (("implicit side four times finer", [0.25] * 8, [1.0] * 8), ("one length of element", [1.0] * 6, [1.0] * 6),
        ("implicit side four times coarser", [4.0] * 4, [1.0] * 10))
SHAPES = {"linear": lambda s: (1 - s, s),
          "quadratic": lambda s: ((1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)),
          "broken": lambda s: (np.maximum(0, 1 - 2 * s), np.maximum(0, 2 * s - 1), 1 - abs(1 - 2 * s))}


def bar(lengths):
    n = len(lengths) + 1
    mass, stiffness = np.zeros(n), np.zeros((n, n))
    for e, length in enumerate(lengths):
        mass[e:e + 2] += length / 2
        stiffness[e:e + 2, e:e + 2] += np.array([[1, -1], [-1, 1]]) / length
    return mass, stiffness


class Pair:
    """State of a window: displacements and velocities of both sides, multiplier at its start."""

    def __init__(self, implicit, explicit, substeps, courant):
        (self.mi, self.ki), (self.me, self.ke) = bar(implicit), bar(explicit)
        highest = np.linalg.eigvalsh(self.ke / np.sqrt(np.outer(self.me, self.me))).max() ** 0.5
        self.ni, self.ne, self.m, self.dt = len(self.mi), len(self.me), substeps, courant * 2 / highest
        self.window = substeps * self.dt
        self.solve = np.linalg.inv(np.diag(self.mi) + self.window**2 / 4 * self.ki)

    def implicit(self, u, v, impulse, moment):
        """The trapezoidal rule; the multiplier moves the shared node by its moment as it would move a free mass."""
        moved = np.zeros(self.ni)
        moved[-1] = (moment - self.window * impulse / 2) / self.mi[-1]
        # (M + T^2/4 K) v' = M v - T K (u + T/4 v + moved/2) + impulse, u' = u + T/2 (v + v') + moved
        right = self.mi * v - self.window * self.ki @ (u + self.window / 4 * v + moved / 2)
        right[-1] += impulse
        end = self.solve @ right
        return u + self.window / 2 * (v + end) + moved, end

    def explicit(self, u, v, force):
        for step in range(self.m):
            a = -self.ke @ u / self.me
            a[0] -= force(step / self.m) / self.me[0]
            u = u + self.dt * v + self.dt**2 / 2 * a
            b = -self.ke @ u / self.me
            b[0] -= force((step + 1) / self.m) / self.me[0]
            v = v + self.dt / 2 * (a + b)
        return u, v

    def step(self, state, shape, baumgarte=0.0, moved=False):
        ui, vi, ue, ve = np.split(state[:-1], np.cumsum([self.ni, self.ni, self.ne]))
        points, weights = np.polynomial.legendre.leggauss(4)
        points, weights = np.concatenate([points + 1, points + 3]) / 4, np.concatenate([weights, weights]) / 4
        basis = np.array(SHAPES[shape](points))
        free = len(basis) - 1

        def run(values):
            values = np.concatenate([state[-1:], values])
            impulse, moment = self.window * basis @ weights, self.window**2 * basis @ (weights * (1 - points))
            if free == 1:  # Newmark's: the mean of both ends
                moment = self.window * impulse / 2
            return (*self.implicit(ui, vi, impulse @ values, moment @ values),
                    *self.explicit(ue, ve, lambda s: np.dot(SHAPES[shape](s), values)))

        def gaps(values):
            a, b, c, d = run(values)
            both = np.array([b[-1] - d[0] + baumgarte / self.window * (ui[-1] - ue[0]), a[-1] - c[0]])
            return both[:free]

        first = gaps(np.zeros(free))
        response = np.array([gaps(unit) - first for unit in np.eye(free)]).T
        values = np.linalg.solve(response, -first)
        a, b, c, d = run(values)
        if moved:
            share, gap = self.me[0] / (self.mi[-1] + self.me[0]), a[-1] - c[0]
            a[-1] -= share * gap
            c[0] += (1 - share) * gap
        return np.concatenate([a, b, c, d, values[:1]])

    def matrix(self, *options):
        return np.array([self.step(unit, *options) for unit in np.eye(2 * (self.ni + self.ne) + 1)]).T


def drift(substeps):
    pair = Pair([0.25] * 32, [1.0] * 8, substeps, 0.9)
    places = np.concatenate([np.arange(33) * 0.25, 8.0 + np.arange(9)])
    wave = np.cos(np.pi * places / 16.0 + 0.5)
    ui, ue = wave[:33], wave[33:]
    pull = (-(pair.ke @ ue)[0] / pair.me[0] + (pair.ki @ ui)[-1] / pair.mi[-1]) / (1 / pair.mi[-1] + 1 / pair.me[0])
    state = np.concatenate([ui, 0 * ui, ue, 0 * ue, [pull]])
    matrix, largest, seen = pair.matrix("linear"), 0.0, []
    for window in range(1, 10001):
        state = matrix @ state
        largest = max(largest, abs(state[pair.ni - 1] - state[2 * pair.ni]))
        if window in (100, 10000):
            seen.append(largest)
    return seen


def main():
    methods = {"prakash_hjelmstad": ("linear",), "quadratic": ("quadratic",), "broken": ("broken",),
               "Baumgarte": ("linear", 0.1), "moved": ("linear", 0.0, True)}
    print(f"{'':>36}" + "".join(f"{name:>19}" for name in methods))
    for name, implicit, explicit in BARS:
        for substeps in (1, 2, 4, 8):
            cells = ""
            for options in methods.values():
                if substeps == 1 and options[0] != "linear":  # one step has one answer to a force
                    cells += f"{'-':>19}"
                    continue
                radius = max(abs(np.linalg.eigvals(Pair(implicit, explicit, substeps, c).matrix(*options))).max()
                             for c in COURANT)
                cells += f"{max(radius - 1, 0.0):19.1e}"
            print(f"{name + ', m=' + str(substeps):<36}" + cells)
    for substeps in (1, 2, 4, 8):
        print(f"drift, m={substeps}: " + ", ".join(f"{value:.1e}" for value in drift(substeps)))


if __name__ == "__main__":
    main()
