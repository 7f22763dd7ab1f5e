#!/usr/bin/python3
"""plastic_bar.py --scene SCENE --name NAME --connect ENDPOINT: explicit participant with the explicit elements of one bar
that yields, written from the law alone: central differences with two-node bars, whose stress is
  s = E (e - p);  where |s| > Y(q, 0):  |s| - E g = Y(q + g, g/dt),  p += g sign(s),  q += g
with the yield stress of material.plasticity after Johnson and Cook,
  Y(q, q') = (A + B q^n) (1 + C ln max(1, q'/rate)) (1 - ((T - T0)/(melting - T0))^m),
the plastic work's share heating the element. Knows one body on an even mesh whose end is a contact, with a free start.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../common/participant/python"))
import numpy as np
from ricochet_participant import Description, Participant, main, read_scene


class PlasticBar(Participant):
    def __init__(self, path, name):
        scene, own, self.sha256 = read_scene(path, name)
        body = next(b for b in scene["body"] if [b["name"]] == own["bodies"])
        material, law = body["material"], body["material"]["plasticity"]
        self.E, self.law, self.heat = material["youngs_modulus_pa"], law, law.get("heat")
        self.T0 = self.heat.get("reference_k", 293.15) if self.heat else 0.0
        self.capacity = material["density_kg_m3"] * self.heat["specific_heat_j_kg_k"] if self.heat else 1.0
        self.h, self.area = body["mesh"]["length_m"] / body["mesh"]["elements"], body["area_m2"]
        implicit = int(scene["partition"]["implicit_length_m"][body["name"]] / self.h * (1 + 1e-9))
        n = body["mesh"]["elements"] - implicit
        self.name, self.body = name, body["name"]
        self.x = body["mesh"].get("start_m", 0) + self.h * np.arange(n + 1)
        ends = np.r_[0.5, np.ones(n - 1), 0.5]
        self.m = material["density_kg_m3"] * self.area * self.h * ends
        self.own = np.arange(n + 1) < n  # the last node is shared
        self.v = np.full(n + 1, body["initial_velocity_m_s"][0])
        self.u, self.a, self.internal, self.work = 0 * self.v, 0 * self.v, 0 * self.v, 0.0
        self.p, self.q, self.s, self.plastic = np.zeros(n), np.zeros(n), np.zeros(n), 0.0
        self.T = np.full(n, self.T0)
        self.step = self.h / np.sqrt(self.E / material["density_kg_m3"])

    def describe(self):
        quantities = ["mass_kg", "energy_kinetic_j", "energy_strain_j", "energy_interface_j", "momentum_n_kg_m_s",
                      "plastic_work_j", "equivalent_plastic_strain_max"] + ["temperature_max_k"] * bool(self.heat)
        return Description(self.name, "explicit", "plastic_bar.py", scene_sha256=self.sha256, bodies=[self.body],
                           interface_body=[0], interface_position_m=self.x[-1:], interface_mass_kg=self.m[-1:],
                           critical_time_step_s=self.step,
                           record_columns=[f"{quantity}/{self.body}" for quantity in quantities])

    def initialize(self, setup):
        self.dt = setup["window_size_s"]
        return self.internal[-1:]

    def synchronise(self, integration, link):
        self.dt, dt = 0.0, self.dt  # a window in which no time passes
        force, _, self.dt = self.advance(0, link), self.accept(), dt
        return force

    def advance(self, window, link):
        self.trial = np.where(self.own, self.u + self.dt * self.v + 0.5 * self.dt**2 * self.a, link[0, 0])
        s = self.E * (np.diff(self.trial) / self.h - self.p)
        self.flow = np.sign(s) * self.growth(np.abs(s))
        self.s_trial = s - self.E * self.flow
        force = self.area * self.s_trial
        self.force = np.r_[0, force] - np.r_[force, 0]
        return self.force[-1:]

    def yield_stress(self, g):
        law = self.law
        y = law["yield_stress_pa"] + law["hardening_pa"] * (self.q + g)**law.get("hardening_exponent", 1.0)
        if "rate_factor" in law and self.dt > 0:
            y *= 1 + law["rate_factor"] * np.log(np.maximum(1, g / self.dt / law["reference_rate_per_s"]))
        if self.heat and "melting_k" in self.heat:
            molten = np.clip((self.T - self.T0) / (self.heat["melting_k"] - self.T0), 0, 1)
            y *= 1 - molten**self.heat.get("softening_exponent", 1.0)
        return y

    def growth(self, s):
        low, high = 0 * s, np.maximum(s - self.yield_stress(0 * s), 0) / self.E
        for _ in range(80):
            middle = 0.5 * (low + high)
            flows = s - self.E * middle > self.yield_stress(middle)
            low, high = np.where(flows, middle, low), np.where(flows, high, middle)
        return high

    def accept(self):
        old, self.v = self.internal, self.v + 0.5 * self.dt * self.a
        self.internal = self.force
        self.work += 0.5 * (old[-1] + self.internal[-1]) * (self.trial[-1] - self.u[-1])
        work = 0.5 * (self.s + self.s_trial) * self.flow
        self.plastic += self.area * self.h * work.sum()
        if self.heat:
            self.T = self.T + self.heat.get("work_fraction", 0.9) * work / self.capacity
        self.p, self.q, self.s = self.p + self.flow, self.q + np.abs(self.flow), self.s_trial
        self.u, self.a = self.trial, np.where(self.own, -self.internal / self.m, 0.0)
        self.v += 0.5 * self.dt * self.a

    def record(self):
        m, v, a = (values[self.own] for values in (self.m, self.v, self.a))
        return [m.sum(), 0.5 * m @ (v**2 - (0.5 * self.dt * a)**2), 0.5 * self.area * self.h / self.E * self.s @ self.s,
                self.work, m @ v, self.plastic, self.q.max()] + [self.T.max()] * bool(self.heat)


main(PlasticBar)
