#!/usr/bin/python3
"""explicit_bar.py --scene SCENE --name NAME --connect ENDPOINT: explicit participant with one body of a bar scene.
Central differences with two-node bars, k = E A / h [[1, -1], [-1, 1]], lumped mass rho A h / 2 per node:
  u~ = u + dt v + dt^2/2 a,  a = -M^-1 K u~  at its own nodes;  P = K u  at the shared node, whose u is the link's.
Knows a body on an even built-in mesh, free but for the contact, and a partition by implicit_length_m.
"""
import numpy as np
from ricochet_participant import ConfigError, Description, Participant, main, read_scene

class ExplicitBar(Participant):
    def __init__(self, path, name):
        scene, own, self.sha256 = read_scene(path, name)
        body = next(b for b in scene["body"] if [b["name"]] == own["bodies"])
        known = {"name", "material", "area_m2", "mesh", "start_m", "length_m", "elements", "initial_velocity_m_s"}
        if scene["model"] != "bar" or (set(body) | set(body["mesh"])) - known:
            raise ConfigError(f"{path}: body '{body['name']}' has what explicit_bar.py does not know")
        h, modulus = body["mesh"]["length_m"] / body["mesh"]["elements"], body["material"]["youngs_modulus_pa"]
        implicit = int(scene["partition"]["implicit_length_m"].get(body["name"], 0) / h * (1 + 1e-9))
        n, at_end = body["mesh"]["elements"] - implicit, body["name"] + ".end" in scene["contact"]["surfaces"]
        self.name, self.body, self.shared = name, body["name"], n if at_end else 0  # away from the free end
        self.x = body["mesh"].get("start_m", 0) + h * (np.arange(n + 1) + (0 if at_end else implicit))
        self.own, ends = np.arange(n + 1) != self.shared, np.r_[0.5, np.ones(n - 1), 0.5]  # own: nodes it integrates
        self.k = modulus * body["area_m2"] / h * (2 * np.diag(ends) - np.eye(n + 1, k=1) - np.eye(n + 1, k=-1))
        self.m = body["material"]["density_kg_m3"] * body["area_m2"] * h * ends
        self.v = np.full(n + 1, body.get("initial_velocity_m_s", [0])[0])
        self.u, self.a, self.internal, self.work = 0 * self.v, 0 * self.v, 0 * self.v, 0.0
        self.step = np.sqrt(2 * self.m.max() / self.k.max())  # h / c

    def describe(self):
        quantities = ["mass_kg", "energy_kinetic_j", "energy_strain_j", "energy_interface_j", "momentum_n_kg_m_s"]
        return Description(self.name, "explicit", "explicit_bar.py", scene_sha256=self.sha256, bodies=[self.body],
                           interface_body=[0], interface_position_m=self.x[self.shared],
                           interface_mass_kg=self.m[self.shared], critical_time_step_s=self.step,
                           record_columns=[f"{quantity}/{self.body}" for quantity in quantities])

    def initialize(self, setup):
        self.dt = setup["window_size_s"]
        return self.internal[self.shared]

    def synchronise(self, integration, link):
        self.dt, dt = 0.0, self.dt  # a window in which no time passes
        force, _, self.dt = self.advance(0, link), self.accept(), dt
        return force

    def advance(self, window, link):
        self.trial = np.where(self.own, self.u + self.dt * self.v + 0.5 * self.dt**2 * self.a, link[0, 0])
        return (self.k @ self.trial)[self.shared]

    def accept(self):
        old, s, self.v = self.internal, self.shared, self.v + 0.5 * self.dt * self.a
        self.internal = self.k @ self.trial
        self.work += 0.5 * (old[s] + self.internal[s]) * (self.trial[s] - self.u[s])
        self.u, self.a = self.trial, np.where(self.own, -self.internal / self.m, 0.0)
        self.v += 0.5 * self.dt * self.a

    def record(self):
        m, v, a = (values[self.own] for values in (self.m, self.v, self.a))
        return [m.sum(), 0.5 * m @ (v**2 - (0.5 * self.dt * a)**2), 0.5 * self.u @ self.internal, self.work, m @ v]

main(ExplicitBar)
