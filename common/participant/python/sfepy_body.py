#!/usr/bin/python3
"""sfepy_body.py --scene SCENE --name NAME --connect ENDPOINT: explicit participant with one axisymmetric body of a Gmsh
mesh, on finite elements by SfePy (Debian's python3-sfepy).

  K: bilinear quadrilaterals, 2 x 2 Gauss points, weighted by 2 pi r;  M: row sums;  u_r = 0 on the axis
  u_n+1 = u + dt v + dt^2/2 a,   M a_n+1 = lambda_n+1 - K u_n+1,   v_n+1 = v + dt/2 (a + a_n+1)
Driven by displacement its shared nodes are where the link says, lambda is none, and P = K u there is the answer. Driven
by force they are nodes like the others, and lambda is linear over the steps of a window. Knows a partition by groups and
supports; the contact's first surface faces up.
"""
import meshio, numpy as np, scipy.sparse as sparse
from scipy.sparse.linalg import eigsh
from sfepy.base.base import output
from sfepy.discrete import Equation, Equations, FieldVariable, Integral, Material, Problem
from sfepy.discrete.fem import FEDomain, Field, Mesh
from sfepy.terms import Term
from ricochet_participant import ConfigError, Description, Participant, main, pack_state, read_scene, unpack_state

KNOWN = {"name", "material", "mesh", "initial_velocity_m_s", "support"}
QUANTITIES = ["mass_kg", "energy_kinetic_j", "energy_strain_j", "energy_interface_j", "momentum_n_kg_m_s",
              "momentum_t_kg_m_s", "impulse_n_kg_m_s", "impulse_t_kg_m_s"]
output.set_output(quiet=True)


def assemble(position, cells, material):
    """K, sparse, with the degrees of freedom 2 i, 2 i + 1 = u_r, u_z of node i, and the row sums of M per node."""
    e, nu = material["youngs_modulus_pa"], material["poisson_ratio"]
    lame, mu = e * nu / (1 + nu) / (1 - 2 * nu), e / 2 / (1 + nu)
    mesh = Mesh.from_data("part", position, None, [cells], [np.zeros(len(cells), np.int32)], ["2_4"])
    omega = FEDomain("part", mesh).create_region("Omega", "all")
    field = Field.from_args("scalar", np.float64, "scalar", omega, approx_order=1)
    p, q = FieldVariable("p", "unknown", field), FieldVariable("q", "test", field, primary_var_name="p")

    def form(term, value, power):
        """The matrix of a bilinear form of scalars, its coefficient 2 pi r^power value."""
        def at(ts, x, mode=None, **_):
            return {"c": 2 * np.pi * x[:, :1, None]**power * np.array(value, float)} if mode == "qp" else None
        # Order 3, not 2: only that rule has 2 x 2 points.
        term = Term.new(f"{term}(m.c, q, p)", Integral("i", order=3), omega, m=Material("m", function=at), p=p, q=q)
        problem = Problem("form", equations=Equations([Equation("form", term)]))
        problem.time_update()
        problem.update_materials()
        problem.equations.evaluate(mode="weak", dw_mode="matrix", asm_obj=problem.mtx_a)
        return problem.mtx_a.copy()

    hoop = form("dw_s_dot_mgrad_s", [[lame], [0]], 0)  # lambda v_r/r du_r/dr, r being in the weight
    rr = (form("dw_diffusion", [[lame + 2 * mu, 0], [0, mu]], 1) + form("dw_dot", [[lame + 2 * mu]], -1)
          + hoop + hoop.T)
    rz = form("dw_diffusion", [[0, lame], [mu, 0]], 1) + form("dw_s_dot_mgrad_s", [[0], [lame]], 0)
    zz = form("dw_diffusion", [[mu, 0], [0, lame + 2 * mu]], 1)
    blocks = [(rr, 0, 0), (rz, 0, 1), (rz.T, 1, 0), (zz, 1, 1)]
    k = sum(sparse.kron(block, np.outer(np.eye(2)[i], np.eye(2)[j])) for block, i, j in blocks)
    return k.tocsr(), np.asarray(form("dw_dot", [[material["density_kg_m3"]]], 1).sum(axis=1)).ravel()


class Part:
    """The explicit elements of a body: `position`, nodes `shared` with implicit elements, and per degree of freedom k, m,
    the initial velocity v, and whether it is `held`."""

    def __init__(self, path, name):
        scene, own, self.sha256 = read_scene(path, name)
        body = next(b for b in scene["body"] if [b["name"]] == own["bodies"])
        groups = scene["partition"].get("implicit_groups", {}).get(body["name"])
        if scene["model"] != "axisymmetric" or not groups or set(body) - KNOWN or set(body["mesh"]) != {"gmsh"}:
            raise ConfigError(f"{path}: body '{body['name']}' has what sfepy_body.py does not know")
        mesh = meshio.read(body["mesh"]["gmsh"])

        def cells(kind, group):
            blocks = [b.data[chosen] for b, chosen in zip(mesh.cells, mesh.cell_sets[group]) if b.type == kind]
            return np.concatenate(blocks).astype(int)

        implicit = np.concatenate([cells("quad", group) for group in groups])
        known = set(map(tuple, implicit))
        explicit = np.array([cell for cell in cells("quad", body["name"]) if tuple(cell) not in known])
        nodes, local = np.unique(explicit, return_inverse=True)
        self.name, self.body, self.position = name, body["name"], mesh.points[nodes, :2]
        self.k, self.node_mass = assemble(self.position, local.reshape(-1, 4), body["material"])
        self.shared = np.flatnonzero(np.isin(nodes, implicit))
        held = np.zeros((len(nodes), 2), bool)
        held[:, 0] = self.position[:, 0] < 1e-9 * self.position[:, 0].max()
        for support in body.get("support", []):
            on_it = np.isin(nodes, cells("line", support["surface"]))
            held[on_it] |= [axis in support["fixed"] for axis in "rz"]
        self.held, self.m = held.ravel(), np.repeat(self.node_mass, 2)
        self.v = np.where(held, 0, body.get("initial_velocity_m_s", [0.0, 0.0])).ravel()
        self.shared_dofs = (2 * self.shared[:, None] + [0, 1])  # one row per node

    def largest_frequency(self):
        root = sparse.diags(np.where(self.held, 0, self.m**-0.5))
        return np.sqrt(eigsh(root @ self.k @ root, 1, return_eigenvectors=False, v0=np.ones(len(self.m)))[0])

    def describe(self, **own):
        return Description(self.name, "explicit", scene_sha256=self.sha256, components=2, bodies=[self.body],
                           interface_body=np.zeros(len(self.shared)), interface_position_m=self.position[self.shared],
                           interface_mass_kg=self.node_mass[self.shared],
                           record_columns=[f"{quantity}/{self.body}" for quantity in QUANTITIES], **own)


class SfepyBody(Participant):
    def __init__(self, path, name):
        self.part = part = Part(path, name)
        zero = np.zeros_like(part.v)
        self.state = {"u": zero, "v": part.v, "a": zero, "internal": zero, "link": np.zeros_like(part.shared_dofs, float),
                      "work": 0.0, "impulse": 0.0}

    def describe(self):
        able = ["repeat_window", "driven_by_force", "single_substep", "save_state", "load_state"]
        return self.part.describe(solver="sfepy_body.py", capabilities=able,
                                  critical_time_step_s=0.99 * 2 / self.part.largest_frequency())

    def initialize(self, setup):
        self.by_force, self.steps = setup["driven_by"] == "force", setup["substeps"]
        self.window, self.dt = setup["window_size_s"], setup["window_size_s"] / self.steps
        self.integrated = np.ones_like(self.part.held)
        if not self.by_force:
            self.integrated[self.part.shared_dofs] = False
            self.state["v"] = np.where(self.integrated, self.state["v"], 0)
        self.free = self.integrated & ~self.part.held
        return self.answer(self.state)

    def answer(self, state):
        motion = [state[x][self.part.shared_dofs] for x in "uva"]
        return motion if self.by_force else state["internal"][self.part.shared_dofs]

    def compute(self, dt, steps, link):
        """The state after so many steps from the accepted one on, the last one at this link input."""
        shared, s = self.part.shared_dofs, dict(self.state)
        for j in range(1, steps + 1):
            old = dict(s)
            s["link"] = self.state["link"] + j / steps * (link - self.state["link"])
            s["u"] = s["u"] + dt * s["v"] + 0.5 * dt**2 * s["a"]
            if not self.by_force:
                s["u"][shared] = link
            s["internal"] = self.part.k @ s["u"]
            force = -s["internal"]
            if self.by_force:
                force[shared] += s["link"]
            s["a"] = np.where(self.free, force / self.part.m, 0)
            s["v"] = s["v"] + 0.5 * dt * (old["a"] + s["a"])
            mean = 0.5 * (old["internal"] + s["internal"])
            on_link = 0.5 * (old["link"] + s["link"]) if self.by_force else mean[shared]
            s["work"] += np.sum(on_link * (s["u"] - old["u"])[shared])
            s["impulse"] = s["impulse"] + dt * (mean * (self.integrated & self.part.held)).reshape(-1, 2).sum(axis=0)
        self.trial = s
        return self.answer(s)

    def synchronise(self, integration, link):
        answer = self.compute(0.0, 1, link)
        self.accept()
        return answer

    def advance(self, window, link):
        return self.compute(self.dt, self.steps, link)

    def advance_substep(self, window, substep, link):
        return self.compute(self.dt, 1, link)

    def accept(self):
        self.state = self.trial

    def record(self):
        m, s = self.part.m * self.integrated, self.state
        kinetic = 0.5 * m @ (s["v"]**2 - (0.5 * self.dt * s["a"])**2)
        momentum, impulse = (m * s["v"]).reshape(-1, 2).sum(axis=0), s["impulse"] * np.ones(2)
        return [m[1::2].sum(), kinetic, 0.5 * s["u"] @ s["internal"], s["work"], momentum[1], -momentum[0], impulse[1],
                -impulse[0]]  # n = z, t = -r

    def save_state(self):
        return pack_state(**self.state)

    def restore_state(self, saved):
        self.state = unpack_state(saved)

    def load_state(self, state, frozen_contact):
        for name, values in zip("uv", np.split(state, 2)):
            self.state[name] = np.zeros_like(self.part.v)
            self.state[name][self.free] = values

    def read_state(self):
        root = np.sqrt(self.part.m[self.free])
        return np.r_[self.state["u"][self.free], self.state["v"][self.free]], np.r_[root / self.window, root]


if __name__ == "__main__":
    main(SfepyBody)
