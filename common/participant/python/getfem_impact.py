#!/usr/bin/python3
"""getfem_impact.py --scene SCENE --name NAME --connect ENDPOINT: the implicit participant of an axisymmetric impact of
two cylinders without friction, on finite elements by GetFEM (Debian's python3-getfem).

  K: bilinear quadrilaterals, 2 x 2 Gauss points, weighted by 2 pi r;  M: row sums;  u_r = 0 on the axis
  (M + dt^2/4 K) du = M (dt v + dt^2/4 a) + dt^2/4 (q_n - (L_n+1 - L_n) + G^T r),   q = -K u - L
  0 <= r, 0 <= g, r g = 0 for the gap g = g0 + u_z(second) - u_z(first) of each pair of contact nodes
Then a = 4/dt^2 (du - dt v) - a_n, v = v_n + dt/2 (a_n + a), and both sides of a closed pair take their mean v_z and
a_z, weighted by mass; a force that a_z would remember is never a pull. A contact force in the history is an impulse
over dt: dt/2 (M a_n - q_n + G^T r) and that of the mean velocity. Knows even built-in meshes and multiplier contact;
stays implicit after separation.
"""
import getfem, numpy as np
from ricochet_participant import ConfigError, ContactStatus, Description, main, pack_state, Participant, read_scene, unpack_state

KNOWN = {"name", "material", "mesh", "initial_velocity_m_s", "start_m", "length_m", "radius_m", "elements"}
QUANTITIES = ["mass_kg", "energy_kinetic_j", "energy_strain_j", "energy_interface_j", "momentum_n_kg_m_s"]
STATE = "u v a q link closed impulse work total_impulse first_staggered".split()
STIFFNESS = ("2*pi*X(1)*(lambda*(Trace(Grad_u) + u(1)/X(1))*(Trace(Grad_Test_u) + Test_u(1)/X(1))"
             " + 2*mu*(Sym(Grad_u):Grad_Test_u + u(1)*Test_u(1)/(X(1)*X(1))))")


class Cylinder:
    """The implicit part of a body: dofs 2 i, 2 i + 1 are u_r, u_z of node i in GetFEM's order."""

    def __init__(self, body, surface, implicit_length):
        mesh, material = body["mesh"], body["material"]
        across, along = mesh["elements"]
        h = mesh["length_m"] / along
        count = min(along, int(implicit_length / h * (1 + 1e-9)))
        first = along - count if surface == "end" else 0
        z = mesh.get("start_m", 0.0) + h * np.arange(first, first + count + 1)
        elements = getfem.Mesh("cartesian", np.linspace(0, mesh["radius_m"], across + 1), z)
        space, points = getfem.MeshFem(elements, 2), getfem.MeshIm(elements, getfem.Integ(
            "IM_GAUSS_PARALLELEPIPED(2, 3)"))
        space.set_fem(getfem.Fem("FEM_QK(2, 1)"))
        model = getfem.Model("real")
        model.add_fem_variable("u", space)
        e, nu = material["youngs_modulus_pa"], material["poisson_ratio"]
        for name, value in (("lambda", e * nu / (1 + nu) / (1 - 2 * nu)), ("mu", e / 2 / (1 + nu)),
                            ("rho", material["density_kg_m3"])):
            model.add_initialized_data(name, value)
        self.stiffness = getfem.asm_generic(points, 2, STIFFNESS, -1, model).full()
        self.mass = getfem.asm_generic(points, 1, "2*pi*X(1)*rho*(Test_u(1) + Test_u(2))", -1, model)
        self.position = space.basic_dof_nodes()[:, ::2].T
        self.name, self.velocity = body["name"], body.get("initial_velocity_m_s", [0.0, 0.0])
        self.contact = self.nodes_at(z[-1] if surface == "end" else z[0])
        self.shared = self.nodes_at(z[0] if surface == "end" else z[-1])
        self.axis = np.flatnonzero(self.position[:, 0] < 1e-9 * mesh["radius_m"])

    def nodes_at(self, z):
        nodes = np.flatnonzero(abs(self.position[:, 1] - z) < 1e-9 * np.ptp(self.position[:, 1]))
        return nodes[np.argsort(self.position[nodes, 0])]


class Impact(Participant):
    def __init__(self, path, name):
        scene, _, self.sha256 = read_scene(path, name)
        contact = scene["contact"]
        if scene["model"] != "axisymmetric" or set(contact) != {"surfaces"}:
            raise ConfigError(f"{path}: getfem_impact.py knows contact of two surfaces without friction, axisymmetric")
        self.name, self.bodies = name, []
        for surface in contact["surfaces"]:
            body, end = surface.split(".")
            spec = next(b for b in scene["body"] if b["name"] == body)
            if unknown := (set(spec) | set(spec["mesh"])) - KNOWN:
                raise ConfigError(f"{path}: body '{body}' has what getfem_impact.py does not know: {sorted(unknown)}")
            self.bodies.append(Cylinder(spec, end, scene["partition"]["implicit_length_m"][body]))
        sizes = [2 * len(b.position) for b in self.bodies]
        self.parts = [slice(0, sizes[0]), slice(sizes[0], sum(sizes))]
        self.k = np.zeros((sum(sizes), sum(sizes)))
        for part, b in zip(self.parts, self.bodies):
            self.k[part, part] = b.stiffness
        starts = [0, sizes[0]]
        self.pairs = np.array([start + 2 * b.contact + 1 for start, b in zip(starts, self.bodies)])  # [side, pair]
        self.shared = np.concatenate([start + 2 * np.repeat(b.shared, 2) + np.tile([0, 1], len(b.shared))
                                      for start, b in zip(starts, self.bodies)])
        self.free = np.ones(sum(sizes), bool)
        self.free[np.concatenate([start + 2 * b.axis for start, b in zip(starts, self.bodies)])] = False
        self.m = np.concatenate([b.mass for b in self.bodies])
        self.v = np.concatenate([np.tile(b.velocity, len(b.position)) for b in self.bodies]) * self.free
        self.u, self.a, self.q, self.link = (np.zeros(sum(sizes)) for _ in range(4))
        self.gap0 = np.subtract(*[b.position[b.contact, 1] for b in self.bodies[::-1]])
        self.closed, self.impulse, self.work = self.gap0 < 0, 0 * self.gap0, np.zeros(2)
        self.total_impulse = 0.0
        self.radius = self.bodies[0].position[:, 0].max()

    def describe(self):
        columns = [f"{quantity}/{b.name}" for b in self.bodies for quantity in QUANTITIES]
        return Description(
            self.name, "implicit", "getfem_impact.py", scene_sha256=self.sha256, components=2, contact_owner=True,
            capabilities=["repeat_window", "save_state"],
            bodies=[b.name for b in self.bodies],
            interface_body=np.repeat([0, 1], [len(b.shared) for b in self.bodies]),
            interface_position_m=np.concatenate([b.position[b.shared] for b in self.bodies]),
            interface_mass_kg=self.m[self.shared[::2]],
            record_columns=columns + ["gap_min_m", "contact_force_n", "contact_pressure_mean_pa",
                                      "contact_impulse_n_s", "pairs_slip", "pairs_open"])

    def initialize(self, setup):
        self.dt = setup["window_size_s"]
        self.m[self.shared] = np.repeat(setup["interface_mass_kg"], 2)
        self.inverse = np.zeros_like(self.k)
        free = np.ix_(self.free, self.free)
        self.inverse[free] = np.linalg.inv((np.diag(self.m) + self.dt**2 / 4 * self.k)[free])
        a, b = self.pairs
        i = self.inverse
        self.compliance = self.dt**2 / 4 * (i[np.ix_(a, a)] + i[np.ix_(b, b)] - i[np.ix_(a, b)] - i[np.ix_(b, a)])
        return self.motion(self.u, self.v, self.a)

    def motion(self, *values):
        return tuple(x[self.shared] for x in values)

    def staggered(self):
        """The explicit elements' share in the metric of central differences at the shared nodes, per body."""
        return self.dt**2 / 8 * np.array([self.a[part] @ self.link[part] for part in self.parts])

    def synchronise(self, integration, link):
        self.link[self.shared] = link.ravel()
        self.q = -self.k @ self.u - self.link
        self.a = self.q / self.m * self.free
        self.q[~self.free] = 0.0
        self.first_staggered = self.staggered()
        return self.motion(self.u, self.v, self.a)

    def gap(self, u):
        return self.gap0 + u[self.pairs[1]] - u[self.pairs[0]]

    def on_second(self, forces):
        """Forces on both sides of the pairs: those on the second, the mean of them and the opposite on the first."""
        first, second = self.pairs
        return 0.5 * (forces[second] - forces[first])

    def take_mean(self, closed, x):
        """Both sides of closed pairs get the mean, weighted by mass; returns the change of M x on the second."""
        before = self.on_second(self.m * x)
        sides = self.pairs[:, closed]
        x[sides] = np.sum(self.m[sides] * x[sides], axis=0) / self.m[sides].sum(axis=0)
        return self.on_second(self.m * x) - before

    def contact_force(self, gap):
        """Complementarity by an active set that starts from the last one."""
        closed = self.closed.copy()
        for _ in range(30):
            force = np.zeros(len(gap))
            force[closed] = np.linalg.solve(self.compliance[np.ix_(closed, closed)], -gap[closed])
            opens = closed & (force < -1e-12 * abs(force).max(initial=0.0))
            closes = ~closed & (gap + self.compliance @ force < -1e-12 * abs(gap).max())
            if not np.any(opens | closes):
                return closed, force
            closed = (closed & ~opens) | closes
        raise ArithmeticError("the contact states do not settle")

    def advance(self, window, link):
        dt, new_link = self.dt, np.zeros_like(self.link)
        new_link[self.shared] = link.ravel()
        rhs = self.m * (dt * self.v + dt**2 / 4 * self.a) + dt**2 / 4 * (self.q - new_link + self.link)
        du = self.inverse @ rhs
        closed, force = self.contact_force(self.gap(self.u + du))
        applied = np.zeros_like(du)
        applied[self.pairs] = [-force, force]
        du += dt**2 / 4 * self.inverse @ applied
        a = (4 / dt**2 * (du - dt * self.v) - self.a) * self.free
        v = self.v + dt / 2 * (self.a + a)
        q = self.m * a - applied
        impulse = dt / 2 * (self.on_second(self.m * self.a - self.q) + force) + self.take_mean(closed, v)
        pull = np.minimum(force + self.take_mean(closed, a), 0.0)
        a[self.pairs] += [pull, -pull] / self.m[self.pairs]
        self.trial = du, v, a, q, new_link, closed, impulse
        return self.motion(self.u + du, v, a)

    def accept(self):
        du, self.v, self.a, self.q, link, self.closed, self.impulse = self.trial
        self.total_impulse += self.impulse.sum()
        self.work -= [0.5 * (self.link[part] + link[part]) @ du[part] for part in self.parts]
        self.u, self.link = self.u + du, link

    def save_state(self):
        return pack_state(**{name: getattr(self, name) for name in STATE})

    def restore_state(self, saved):
        vars(self).update(unpack_state(saved))
        self.closed = self.closed.astype(bool)

    def contact_status(self):
        rate = self.v[self.pairs[1]] - self.v[self.pairs[0]]
        return ContactStatus(int(self.closed.sum()), float(self.gap(self.u).min()), float(rate.min()))

    def record(self):
        row, share = [], self.staggered()
        for i, part in enumerate(self.parts):
            m, v = self.m[part], self.v[part]
            strain = 0.5 * self.u[part] @ self.k[part, part] @ self.u[part]
            row += [m[1::2].sum(), 0.5 * m @ v**2 + share[i], strain, self.work[i] + share[i] - self.first_staggered[i],
                    m[1::2] @ v[1::2]]
        total, closed = self.impulse.sum() / self.dt, self.closed.sum()
        pressure = total / (np.pi * self.radius**2)
        return row + [self.gap(self.u).min(), total, pressure, self.total_impulse, closed, len(self.closed) - closed]


if __name__ == "__main__":
    getfem.util_trace_level(0)
    main(Impact)
