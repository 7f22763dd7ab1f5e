#!/usr/bin/python3
"""generalised_alpha.py: does an integrator that damps the shortest waves cure the overshoot of the contact force?

A bar (E = rho = A = L = 1, so c = Z = 1) of N elements hits a rigid plane with v = 1; the exact force is Z v = 1 for
0 <= t <= 2L/c. The contact node has no mass: its displacement is max(0, u_1), so the plane acts on node 1, which has
taken that mass, with r = k max(0, -u_1), k = 1/h. By
  generalised alpha (Chung, Hulbert 1993), rho_inf = 1 is the trapezoidal rule:
    (1 - am) M a_n+1 + am M a_n = (1 - af) q(u_n+1) + af q(u_n),   q(u) = -K u + r e_1,   u_n+1, v_n+1 by Newmark
  rho_inf-Bathe (Noh, Bathe 2019): the trapezoidal rule to t + g dt, then three points; two solves a window
and by the reset law (lumped contact node, trapezoidal rule, v_0 = a_0 = 0 after every closed window).
What r does over a window in which u_1 changes sign, 1/2 (r_n + r_n+1) (u_0,n+1 - u_0,n), goes back into v_1.
A force is the change of the bar's momentum over a window, by its size.
"""
import numpy as np

ELEMENTS, END = 100, 2.6


class Bar:
    """Nodes 1..N for a massless contact node, 0..N for a lumped one; `contact` stiffness of the plane at the first."""

    def __init__(self, lumped):
        h = 1.0 / ELEMENTS
        nodes = ELEMENTS + lumped
        self.k = (2 * np.eye(nodes) - np.eye(nodes, k=1) - np.eye(nodes, k=-1)) / h
        self.k[0, 0] = self.k[-1, -1] = 1 / h
        self.m = np.full(nodes, h)
        self.m[-1] = h / 2
        self.m[0] = h / 2 if lumped else 1.5 * h
        self.spring = np.zeros((nodes, nodes))
        self.spring[0, 0] = 1 / h
        self.u, self.v, self.a = np.zeros(nodes), -np.ones(nodes), np.zeros(nodes)

    def contact(self, u):
        return self.spring[0, 0] * max(0.0, -u[0])

    def force(self, u):
        q = -self.k @ u
        q[0] += self.contact(u)
        return q

    def energy(self):
        strain = self.u @ self.k @ self.u + self.spring[0, 0] * min(0.0, self.u[0])**2
        return 0.5 * (strain + self.m @ self.v**2)

    def solver(self, factor):
        """Solves M u + factor K u = b + factor r(u) e_1: without contact if that leaves u_1 >= 0."""
        matrix = np.diag(self.m) + factor * self.k
        free, closed = np.linalg.inv(matrix), np.linalg.inv(matrix + factor * self.spring)

        def solve(b):
            u = free @ b
            return u if u[0] >= 0 else closed @ b
        return solve

    def give_back(self, before):
        """The energy that r has made goes back into v_1, as far as it has that much."""
        moved = max(0.0, self.u[0]) - max(0.0, before[0])
        self.debt += 0.5 * (self.contact(before) + self.contact(self.u)) * moved
        square = self.v[0]**2 - 2 * self.debt / self.m[0]
        if self.debt and square > 0:
            self.v[0] = np.copysign(np.sqrt(square), self.v[0])
            self.debt = 0.0

    debt = 0.0


def generalised_alpha(rho, dt):
    bar = Bar(lumped=0)
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma, beta = 0.5 - am + af, 0.25 * (1 - am + af)**2
    scale = (1 - am) / (beta * dt**2)
    solve = bar.solver((1 - af) / scale)

    def window():
        before = bar.u
        predictor = bar.u + dt * bar.v + (0.5 - beta) * dt**2 * bar.a
        known = af * bar.force(bar.u) - am * bar.m * bar.a
        bar.u = solve(bar.m * predictor + known / scale)
        a = (bar.u - predictor) / (beta * dt**2)
        bar.v = bar.v + dt * ((1 - gamma) * bar.a + gamma * a)
        bar.a = a
        bar.give_back(before)
    return bar, window


def bathe(rho, dt):
    bar = Bar(lumped=0)
    g = 0.5 if rho == 1 else (2 - np.sqrt(2 + 2 * rho)) / (1 - rho)
    q1 = (rho + 1) / (2 * g * (rho - 1) + 4)
    q0, q2 = (g - 1) * q1 + 0.5, 0.5 - g * q1
    first, second = bar.solver((0.5 * g * dt)**2), bar.solver((q2 * dt)**2)

    def window():
        u, v, a, half = bar.u, bar.v, bar.a, 0.5 * g * dt
        ug = first(bar.m * (u + half * (2 * v + half * a)))
        vg = (ug - u) / half - v
        ag = (vg - v) / half - a
        middle = v + dt * (q0 * a + q1 * ag)
        bar.u = second(bar.m * (u + dt * (q0 * v + q1 * vg + q2 * middle)))
        bar.v = (bar.u - u) / (q2 * dt) - (q0 * v + q1 * vg) / q2
        bar.a = (bar.v - middle) / (q2 * dt)
        bar.give_back(u)
    return bar, window


def reset(dt):
    bar = Bar(lumped=1)
    bar.spring[0, 0] = 0.0  # the plane is a constraint here
    matrix = np.diag(bar.m) + dt**2 / 4 * bar.k
    inverse = np.linalg.inv(matrix)

    def window():
        rhs = bar.m * (dt * bar.v + dt**2 / 4 * bar.a) - dt**2 / 4 * bar.k @ bar.u
        du = inverse @ rhs
        closed = bar.u[0] + du[0] < 0
        if closed:
            du = du - inverse[:, 0] * (bar.u[0] + du[0]) / inverse[0, 0]
        a = 4 / dt**2 * (du - dt * bar.v) - bar.a
        bar.v, bar.u, bar.a = bar.v + dt / 2 * (bar.a + a), bar.u + du, a
        if closed:
            bar.v[0], bar.a[0] = 0.0, max(0.0, -(bar.k @ bar.u)[0] / bar.m[0])
    return bar, window


def measure(bar, window, dt):
    """Overshoot of the first peak, RMS from the exact force, deviation and mean on the plateau, part of energy lost."""
    force, energy = [], bar.energy()
    for _ in range(int(round(END / dt))):
        before = bar.m @ bar.v
        window()
        force.append((bar.m @ bar.v - before) / dt)
    force, middle = np.array(force), dt * (np.arange(len(force)) + 0.5)
    plateau = force[(middle > 0.3) & (middle < 1.3)]
    return (force[middle < 0.5].max() - 1, np.sqrt(np.mean((force - 1)[middle < 2]**2)), plateau.std(), plateau.mean(),
            1 - bar.energy() / energy)


RHO = (1, 0.9, 0.8, 0.5, 0)


def row(name, law, dt):
    peak, rms, deviation, mean, lost = measure(*law, dt)
    lost = round(lost, 5) + 0.0  # no -0.00000
    print(f"{name:<34}{peak:>10.3f}{rms:>8.4f}{deviation:>9.4f}{mean:>8.4f}{lost:>13.5f}")


def main():
    for courant in (0.1, 0.5, 1.0):
        dt = courant / ELEMENTS
        print(f"{ELEMENTS} elements, window {courant} h/c")
        print(f"{'law':<34}{'overshoot':>10}{'RMS':>8}{'plateau':>9}{'mean':>8}{'energy lost':>13}")
        for rho in RHO if courant > 0.1 else RHO[:1]:
            row(f"massless, generalised alpha {rho}", generalised_alpha(rho, dt), dt)
        for rho in RHO if courant > 0.1 else ():
            row(f"massless, rho_inf-Bathe {rho}", bathe(rho, dt), dt)
        row("reset, trapezoidal rule", reset(dt), dt)
        print()


if __name__ == "__main__":
    main()
