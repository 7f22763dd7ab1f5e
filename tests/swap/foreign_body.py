#!/usr/bin/python3
"""foreign_body.py --scene SCENE --name NAME --connect ENDPOINT: explicit participant whose body the scene does not know.
Its mesh and material stand in NAME.toml beside this program, or beside the link by which it is started; of the scene it
reads nothing:
  body, model, material, section (area or thickness), start, size and elements per coordinate, velocity, and of the low
  and high side of the last coordinate which is `shared` and which is `held`.
  K: boxes with 2 Gauss points per coordinate, those of solids with twelve strain modes that are condensed; M: row sums
  u_n+1 = u + dt v + dt^2/2 a,   M a_n+1 = lambda_n+1 - K u_n+1,   v_n+1 = v + dt/2 (a + a_n+1)
"""
import os, sys, tomllib
from itertools import product
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../common/participant/python"))
from ricochet_participant import Description, Participant, main


def element(own, low, size):
    """K with the degrees of freedom d i + c, and the row sums of M, of a box."""
    d, axisymmetric = len(size), own["model"] == "axisymmetric"
    corners = np.array(list(product([-1, 1], repeat=d)))
    e, nu = own["material"]["youngs_modulus_pa"], own["material"].get("poisson_ratio", 0.0)
    lame, mu = (e, 0.0) if d == 1 else (e * nu / (1 + nu) / (1 - 2 * nu), e / 2 / (1 + nu))
    count = len(corners) * d
    k, mass = np.zeros((count + 12 * (d == 3),) * 2), np.zeros(len(corners))
    for p in product([-3**-0.5, 3**-0.5], repeat=d):
        factors = (1 + corners * p) / 2
        shape, r = factors.prod(axis=1), low[0] + size[0] * (1 + p[0]) / 2
        weight = np.prod(size) / 2**d * (2 * np.pi * r if axisymmetric else own.get("section", 1.0))
        gradients = []  # of the displacement, per degree of freedom and mode
        for i, c in product(range(len(corners)), range(d)):
            h = np.zeros((3, 3))
            for x in range(d):
                h[c, x] = corners[i, x] / size[x] * np.delete(factors[i], x).prod()
            h[2, 2] += shape[i] / r if axisymmetric and c == 0 else 0.0
            gradients.append(h)
        if d == 3:
            gradients += [np.outer(np.eye(3)[c], np.eye(3)[x]) * p[x] / size[x] for c, x in product(range(3), range(3))]
            gradients += [np.eye(3) * p[x] * p[(x + 1) % 3] for x in range(3)]
        h = np.array(gradients)
        trace = np.trace(h, axis1=1, axis2=2)
        symmetric = np.einsum("aij,bij->ab", h, h) + np.einsum("aij,bji->ab", h, h)
        k += weight * (lame * np.outer(trace, trace) + mu * symmetric)
        mass += weight * own["material"]["density_kg_m3"] * shape
    modes = slice(count, None)
    if d == 3:
        k = k[:count, :count] - k[:count, modes] @ np.linalg.solve(k[modes, modes], k[modes, :count])
    return k, mass


class ForeignBody(Participant):
    def __init__(self, scene, name):
        with open(os.path.join(os.path.dirname(__file__), name + ".toml"), "rb") as file:
            self.own = own = tomllib.load(file)
        self.name, counts = name, own["elements"]
        self.d = d = len(counts)
        size = np.array(own["size"]) / counts
        number = np.arange(np.prod(np.add(counts, 1))).reshape(np.add(counts, 1))
        self.x = np.array(list(np.ndindex(*number.shape))) * size + own["start"]
        self.k, self.node_mass = np.zeros((d * len(self.x),) * 2), np.zeros(len(self.x))
        for cell in np.ndindex(*counts):
            nodes = np.array([number[tuple(np.add(cell, corner))] for corner in product([0, 1], repeat=d)])
            k, mass = element(own, self.x[nodes[0]], size)
            dofs = (d * nodes[:, None] + range(d)).ravel()
            self.k[np.ix_(dofs, dofs)] += k
            self.node_mass[nodes] += mass
        side = {"low": number[..., 0].ravel(), "high": number[..., -1].ravel()}
        self.shared, held = side[own["shared"]], np.zeros((len(self.x), d), bool)
        held[side[own["held"]] if "held" in own else []] = True
        if own["model"] == "axisymmetric":
            held[self.x[:, 0] == 0, 0] = True
        self.held, self.m, self.dofs = held.ravel(), np.repeat(self.node_mass, d), d * self.shared[:, None] + range(d)
        v = np.where(held, 0, own.get("velocity", [0] * d)).ravel()
        self.state = {"u": 0 * v, "v": v, "a": 0 * v, "internal": 0 * v, "link": 0.0 * self.dofs, "work": 0.0,
                      "impulse": np.zeros((len(self.x), d)), "turned": 0.0}

    def describe(self):
        root = np.where(self.held, 0, self.m**-0.5)
        critical = 1.999 / np.sqrt(np.linalg.eigvalsh(root[:, None] * self.k * root)[-1])
        quantities = ["mass_kg", "energy_kinetic_j", "energy_strain_j", "energy_interface_j"]
        for of in ["momentum_{}_kg_m_s", "impulse_{}_kg_m_s"]:
            quantities += [of.format(axis) for axis in "ntb"[:self.d]]
        if self.own["model"] == "plane_strain":
            quantities += ["angular_momentum_z_kg_m2_s", "angular_impulse_z_kg_m2_s"]
        return Description(self.name, "explicit", "foreign_body.py", components=self.d, bodies=[self.own["body"]],
                           interface_body=np.zeros(len(self.shared)), interface_position_m=self.x[self.shared],
                           interface_mass_kg=self.node_mass[self.shared],
                           critical_time_step_s=self.own.get("critical", critical),
                           capabilities=["repeat_window", "driven_by_force", "load_state"],
                           record_columns=[f"{quantity}/{self.own['body']}" for quantity in quantities])

    def initialize(self, setup):
        self.by_force, self.steps = setup["driven_by"] == "force", setup["substeps"]
        self.window, self.dt = setup["window_size_s"], setup["window_size_s"] / self.steps
        self.integrated = np.ones_like(self.held)
        self.integrated[self.dofs] = self.by_force
        self.state["v"] = np.where(self.integrated, self.state["v"], 0)
        self.free = self.integrated & ~self.held
        return self.answer(self.state)

    def answer(self, s):
        return [s[x][self.dofs] for x in "uva"] if self.by_force else s["internal"][self.dofs]

    def advance(self, window, link, dt=None, steps=None):
        s, dt, steps = dict(self.state), self.dt if dt is None else dt, steps or self.steps
        for j in range(1, steps + 1):
            old = dict(s)
            s["link"] = self.state["link"] + j / steps * (link - self.state["link"])
            s["u"] = s["u"] + dt * s["v"] + 0.5 * dt**2 * s["a"]
            if not self.by_force:
                s["u"][self.dofs] = link
            s["internal"] = self.k @ s["u"]
            force = -s["internal"]
            if self.by_force:
                force[self.dofs] += s["link"]
            s["a"] = np.where(self.free, force / self.m, 0)
            s["v"] = s["v"] + 0.5 * dt * (old["a"] + s["a"])
            mean = 0.5 * (old["internal"] + s["internal"])
            on_link = 0.5 * (old["link"] + s["link"]) if self.by_force else mean[self.dofs]
            s["work"] += np.sum(on_link * (s["u"] - old["u"])[self.dofs])
            given = dt * (mean * (self.integrated & self.held)).reshape(-1, self.d)
            s["impulse"] = s["impulse"] + given
            s["turned"] += self.moment(0.5 * (old["u"] + s["u"]), given)
        self.trial = s
        return self.answer(s)

    def moment(self, u, given):  # about z, where the nodes are
        at = self.x + u.reshape(-1, self.d)
        return np.sum(at[:, 0] * given[:, 1] - at[:, 1] * given[:, 0]) if self.d == 2 else 0.0

    def synchronise(self, integration, link):
        answer = self.advance(0, link, 0.0, 1)
        self.accept()
        return answer

    def accept(self):
        self.state = self.trial

    def record(self):
        m, s = self.m * self.integrated, self.state
        kinetic = 0.5 * m @ (s["v"]**2 - (0.5 * self.dt * s["a"])**2)
        row = [m[::self.d].sum(), kinetic, 0.5 * s["u"] @ s["internal"], s["work"]]
        both = [(m * s["v"]).reshape(-1, self.d), s["impulse"]]
        for x in (values.sum(axis=0) for values in both):  # n: the last coordinate
            row += {1: [x[0]], 2: [x[-1], -x[0]], 3: [x[-1], x[0], x[1 % self.d]]}[self.d]
        if self.own["model"] == "plane_strain":
            row += [self.moment(s["u"], both[0]), s["turned"]]
        return row

    def load_state(self, state, frozen_contact):
        for name, values in zip("uv", np.split(state, 2)):
            self.state[name] = np.zeros_like(self.m)
            self.state[name][self.free] = values

    def read_state(self):
        root = np.sqrt(self.m[self.free])
        return np.r_[self.state["u"][self.free], self.state["v"][self.free]], np.r_[root / self.window, root]


main(ForeignBody)
