#!/usr/bin/python3
"""sfepy_integrator.py --scene SCENE --name NAME --connect ENDPOINT: explicit participant with the body of sfepy_body.py,
stepped by a time integrator of SfePy in its own loop.

SfePy's integrators solve M a + K u = f step by step and call back before and after each step. Letting the coupler drive
one takes the following, all of it in the call after a step:
  - the next step's size is `ts.dt`, which the loop reads before the call before a step;
  - back to the start of a window: the loop goes on from the vector [u, v, a] that is passed here, so that is overwritten;
  - matrices that are kept belong to one step size;
  - an exception ends the loop. (It counts its steps, repeated ones, too: it must be made for more than there can be.)
"""
import numpy as np, scipy.sparse as sparse, sys
from sfepy.solvers.ls import ScipyDirect
from sfepy.solvers.nls import Newton
from sfepy.solvers.ts_solvers import VelocityVerletTS
from ricochet_participant import OwnLoop, arguments
from sfepy_body import Part


class Over(Exception):
    pass


class Driven:
    """The body as SfePy's integrators see it, vec = [u, v, a] of its own degrees of freedom, and its part of the
    conversation. Between the ends of a window the link input changes evenly."""

    def __init__(self, part, loop, staggered, in_window):
        self.part, self.loop, self.staggered, self.in_window, self.step = part, loop, staggered, in_window, 0
        self.by_force, self.shared = loop.setup["driven_by"] == "force", part.shared_dofs.ravel()
        integrated = np.ones_like(part.held)
        integrated[self.shared] = self.by_force
        self.own, self.supports = integrated & ~part.held, integrated & part.held
        self.mass, self.node_mass = part.m[self.own], part.node_mass @ integrated[::2]
        unit = sparse.identity(len(part.held), format="csr")[:, self.shared]
        self.load = (unit if self.by_force else -part.k @ unit)[self.own]  # of a unit link input
        self.k, self.m = part.k[self.own][:, self.own], sparse.diags(self.mass).tocsr()
        self.link = self.end_of_step = np.zeros(len(self.shared))
        self.u = self.internal = np.zeros(len(part.held))  # of the whole body, after the last step
        self.work, self.impulse = 0.0, np.zeros(2)

    def residual(self, vec):
        u, _, a = np.split(vec, 3)
        return np.r_[self.k @ u, 0 * u, self.m @ a - self.load @ self.end_of_step]

    def matrix(self, vec):
        return sparse.block_diag([self.k, 0 * self.k, self.m], format="csr")

    def whole(self, values):
        whole = np.zeros(len(self.own))
        whole[self.own] = values
        return whole

    def steps(self):
        return self.in_window if self.loop.max_time_step() > 0 else 1

    def before(self, ts, vec):
        self.step += 1
        self.begin_of_step = self.end_of_step
        self.end_of_step = self.link + self.step / self.steps() * (self.loop.read().ravel() - self.link)

    def after(self, ts, vec):
        motion = [self.whole(x) for x in np.split(vec, 3)]
        if not self.by_force:
            motion[0][self.shared] = self.end_of_step
        u, internal = motion[0], self.part.k @ motion[0]
        mean = 0.5 * (self.internal + internal)
        on_link = 0.5 * (self.begin_of_step + self.end_of_step) if self.by_force else mean[self.shared]
        self.work += on_link @ (u - self.u)[self.shared]
        self.impulse = self.impulse + ts.dt * (mean * self.supports).reshape(-1, 2).sum(axis=0)
        self.u, self.internal = u, internal
        if self.step == self.steps():
            self.end_window(ts, vec, motion)

    def end_window(self, ts, vec, motion):
        loop, self.step, self.link = self.loop, 0, self.end_of_step
        output = [x[self.shared] for x in motion] if self.by_force else self.internal[self.shared]
        loop.write(output, self.record(*np.split(vec, 3)[1:]))
        loop.advance()
        if not loop.ongoing():
            raise Over
        if loop.must_restore():
            vec[:], self.link, self.u, self.internal, self.work, self.impulse = self.saved
            self.end_of_step = self.link
        if loop.must_save():
            self.saved = vec.copy(), self.link, self.u, self.internal, self.work, self.impulse
        dt = loop.max_time_step() / self.steps()
        if dt != ts.dt:
            ts.dt, self.solver.matrix = dt, None

    def record(self, v, a):
        lag = 0.5 * self.loop.setup["window_size_s"] / self.in_window * a if self.staggered else 0
        momentum = self.whole(self.mass * v).reshape(-1, 2).sum(axis=0)
        return [self.node_mass, 0.5 * self.mass @ (v**2 - lag**2), 0.5 * self.u @ self.internal, self.work,
                momentum[1], -momentum[0], self.impulse[1], -self.impulse[0]]


def run(make_solver, staggered, steps=None, most_trials=2):
    """`staggered`: the scheme conserves the energy of central differences, 1/2 v.Mv - dt^2/8 a.Ma. `steps`: of its own in
    each window; None: as many as the scene's substeps. `most_trials`: of a window, on the average; all but fixed_point
    need two at most."""
    options = arguments()
    part = Part(options.scene, options.name)
    limit = 0.99 * 2 / part.largest_frequency() * (steps or 1) if staggered else 0.0  # of central differences alone
    description = part.describe(solver="sfepy_integrator.py", capabilities=["repeat_window", "driven_by_force"],
                                critical_time_step_s=limit)
    with OwnLoop(description, options) as loop:
        loop.initialize(np.zeros(part.shared_dofs.shape), np.zeros(8))
        steps = steps or loop.setup["substeps"]
        driven = Driven(part, loop, staggered, steps)
        newton = Newton({"i_max": 1, "is_linear": True}, fun=driven.residual, fun_grad=driven.matrix,
                        lin_solver=ScipyDirect({}))
        turns = most_trials * loop.setup["last_window"] + 2 * part.shared_dofs.size + 10
        driven.solver = make_solver({"t0": 0.0, "t1": 1.0, "n_step": turns * steps, "is_linear": True},
                                    nls=newton)
        start = part.v[driven.own]
        try:
            driven.solver(np.r_[0 * start, start, 0 * start], init_fun=lambda ts, vec: vec, prestep_fun=driven.before,
                          poststep_fun=driven.after)
        except Over:
            return loop.finalize()


if __name__ == "__main__":
    sys.exit(run(VelocityVerletTS, staggered=True))
