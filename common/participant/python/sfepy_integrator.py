#!/usr/bin/python3
"""sfepy_integrator.py --scene SCENE --name NAME --connect ENDPOINT: explicit participant with the body of sfepy_body.py,
stepped by a time integrator of SfePy in its own loop, and driven by force.

SfePy's integrators solve M a + K u = f step by step and call back before and after each step. What it takes to let the
coupler drive one, all of it in the call after a step:
  - the next step's size is `ts.dt`, which the loop reads before the call before a step;
  - back to the start of a window: the loop goes on from the vector [u, v, a] that is passed here, so that is overwritten;
  - matrices that are kept belong to one step size;
  - an exception ends the loop. (It counts its steps, repeated ones, too: it must be made for more than there can be.)
"""
import numpy as np, scipy.sparse as sparse, sys
from sfepy.solvers.ls import ScipyDirect
from sfepy.solvers.nls import Newton
from sfepy.solvers.ts_solvers import VelocityVerletTS
from ricochet_participant import ConfigError, OwnLoop, arguments
from sfepy_body import Part


class Over(Exception):
    pass


class Driven:
    """The body as SfePy's integrators see it, vec = [u, v, a] of what is not held, and its part of the conversation."""

    def __init__(self, part, loop, staggered, in_window):
        self.part, self.loop, self.staggered, self.step, self.in_window = part, loop, staggered, 0, in_window
        self.free = ~part.held
        self.k, self.m = part.k[self.free][:, self.free], sparse.diags(part.m[self.free]).tocsr()
        n, shared = len(part.held), part.shared_dofs.ravel()
        self.to_free = sparse.identity(n, format="csr")[self.free][:, shared]  # shared -> not held
        self.link = self.force = np.zeros(len(shared))
        self.on_supports = sparse.identity(n, format="csr")[:, part.held] @ part.k[part.held][:, self.free]  # P there
        self.work, self.impulse, self.old_u = 0.0, np.zeros(2), np.zeros(self.m.shape[0])
        self.at_link = lambda x: self.to_free.T @ x

    def residual(self, vec):
        u, _, a = np.split(vec, 3)
        return np.r_[self.k @ u, 0 * u, self.m @ a - self.to_free @ self.force]

    def matrix(self, vec):
        return sparse.block_diag([self.k, 0 * self.k, self.m], format="csr")

    def steps(self):
        return self.in_window if self.loop.max_time_step() > 0 else 1

    def before(self, ts, vec):
        self.step += 1
        self.old_force, self.force = self.force, self.link + self.step / self.steps() * (self.end() - self.link)

    def end(self):
        return self.loop.read().ravel()

    def after(self, ts, vec):
        u = vec[:len(self.old_u)]
        self.work += 0.5 * (self.old_force + self.force) @ self.at_link(u - self.old_u)
        self.impulse = self.impulse + 0.5 * ts.dt * (self.on_supports @ (u + self.old_u)).reshape(-1, 2).sum(axis=0)
        self.old_u = u.copy()
        if self.step < self.steps():
            return
        self.step, self.link = 0, self.force
        self.loop.write([self.at_link(x) for x in np.split(vec, 3)], self.record(vec))
        self.loop.advance()
        if not self.loop.ongoing():
            raise Over
        if self.loop.must_restore():
            vec[:], self.link, self.work, self.impulse, self.old_u = self.saved
            self.force = self.link
        if self.loop.must_save():
            self.saved = vec.copy(), self.link, self.work, self.impulse, self.old_u
        dt = self.loop.max_time_step() / self.steps()
        if dt != ts.dt:
            ts.dt, self.solver.matrix = dt, None

    def record(self, vec):
        u, v, a = np.split(vec, 3)
        lag = 0.5 * self.loop.setup["window_size_s"] / self.in_window * a if self.staggered else 0
        everywhere = np.zeros_like(self.part.v)
        everywhere[self.free] = self.part.m[self.free] * v
        momentum = everywhere.reshape(-1, 2).sum(axis=0)
        return [self.part.node_mass.sum(), 0.5 * self.part.m[self.free] @ (v**2 - lag**2), 0.5 * u @ (self.k @ u), self.work,
                momentum[1], -momentum[0], self.impulse[1], -self.impulse[0]]


def run(make_solver, staggered, steps=None):
    """`staggered`: the scheme conserves the energy of central differences, 1/2 v.Mv - dt^2/8 a.Ma. `steps`: of its own in
    each window; None: as many as the scene's substeps."""
    options = arguments()
    part = Part(options.scene, options.name)
    able = ["repeat_window", "driven_by_force"]
    with OwnLoop(part.describe(solver="sfepy_integrator.py", capabilities=able), options) as loop:
        loop.initialize(np.zeros(part.shared_dofs.shape), np.zeros(8))
        if loop.setup["driven_by"] != "force":
            raise ConfigError("sfepy_integrator.py can be driven by force only; use the protocol prakash_hjelmstad")
        steps = steps or loop.setup["substeps"]
        driven = Driven(part, loop, staggered, steps)
        newton = Newton({"i_max": 1, "is_linear": True}, fun=driven.residual, fun_grad=driven.matrix,
                        lin_solver=ScipyDirect({}))
        turns = 2 * loop.setup["last_window"] + 2 * part.shared_dofs.size + 10  # as many as a dual protocol can ask for
        driven.solver = make_solver({"t0": 0.0, "t1": 1.0, "n_step": turns * steps, "is_linear": True},
                                    nls=newton)
        start = part.v[driven.free]
        try:
            driven.solver(np.r_[0 * start, start, 0 * start], init_fun=lambda ts, vec: vec, prestep_fun=driven.before,
                          poststep_fun=driven.after)
        except Over:
            return loop.finalize()


if __name__ == "__main__":
    sys.exit(run(VelocityVerletTS, staggered=True))
