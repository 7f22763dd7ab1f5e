#!/usr/bin/env python3
"""Draws process sets by lot and looks at what every run must keep: tests/experiments/random_process_sets.py [--build DIR]
[--seed N] [--count N] [--keep DIR]. One or two bodies of pieces with meshes of their own, refined, graded, yielding, held,
loaded, driven, with absorbing ends, under every protocol, with substeps and modes. A line beginning with ! for each run
that `check` and `run` judge differently, that fails, makes energy, loses momentum, differs from all other protocols, or
writes other bytes when it is resumed in its middle; then how many runs there were. Needs Python 3.11 alone."""
import csv
import json
import subprocess

from drawn_runs import draw

PROTOCOLS = ("all_explicit", "all_implicit", "local_explicit", "hughes_liu", "kim", "belytschko_mullen",
             "prakash_hjelmstad", "gravouil_combescure", "fixed_point")
KNOWN = ("fixed_point has not converged", "does not keep it", "gravouil_combescure: its interface made",
         "modes leave its shared nodes no flexibility")
DRIFTING = ("kim", "gravouil_combescure")  # whose momentum is known to drift
REFUSED, NOT_CONVERGED, LEFT_THE_MODEL = 2, 3, 6
MOST_ENERGY, MOST_MOMENTUM, MOST_DIFFERENCE = 5e-2, 1e-6, 0.2


def vector(model, along, across=0.0):
    return {"bar": [along], "plane_strain": [across, along], "axisymmetric": [0.0, along],
            "solid": [across, -0.5 * across, along]}[model]


def block(lot, model, low_m, high_m, divisions, refined):
    """Keys of a mesh between two heights."""
    along, across = lot.choice([4, 6, 9]) * divisions, lot.choice([2, 3])
    keys = f"start_m = {low_m}, length_m = {high_m - low_m}, "
    if model == "bar":
        keys += f"elements = {along}"
    elif model == "plane_strain":
        keys += f"height_m = 0.004, elements = [{across}, {along}]"
    elif model == "axisymmetric":
        keys += f"radius_m = 0.004, elements = [{across}, {along}]"
    else:
        keys += f"height_m = 0.004, width_m = 0.004, elements = [{across}, {lot.choice([2, 3])}, {along}]"
    if model == "bar" and lot.random() < 0.3:
        keys += f", grading = {lot.choice([0.5, 2.0])}"
    if refined and model != "bar" and lot.random() < 0.4:
        box = {"plane_strain": ("[-1.0, {}]", "[1.0, {}]"), "axisymmetric": ("[-1.0, {}]", "[0.0021, {}]"),
               "solid": ("[-1.0, -1.0, {}]", "[1.0, 1.0, {}]")}[model]
        end = high_m - 0.3 * (high_m - low_m)
        keys += (f", refine = [{{ from_m = {box[0].format(end)}, to_m = {box[1].format(high_m + 1.0)}, "
                 f"ratio = {lot.choice([2, 3])} }}]")
    return keys


def body(lot, model, name, low_m, loaded, velocity_m_s, wanted):
    """Text of a body that stands on `low_m`, height of its upper end, names of both, and whether it is in pieces."""
    modulus, density = lot.choice([70e9, 200e9]), lot.choice([2700.0, 8000.0])
    poisson = 0.0 if model == "bar" else lot.choice([0.0, 0.3])
    steel = f"youngs_modulus_pa = {modulus}, poisson_ratio = {poisson}, density_kg_m3 = {density}"
    yields = lot.random() < 0.2
    rate = ", rate_factor = 0.02" if lot.random() < 0.3 else ""
    heat = ", heat = { specific_heat_j_kg_k = 460.0, melting_k = 1700.0 }" if lot.random() < 0.3 else ""
    plastic = f", plasticity = {{ yield_stress_pa = 4e7, hardening_pa = 2e9{rate}{heat} }}" if yields else ""
    text, high_m = f'[[body]]\nname = "{name}"\nmaterial = {{ {steel}{plastic} }}\n', low_m + lot.choice([0.01, 0.02])
    text += "area_m2 = 1e-5\n" if model == "bar" else ""
    if model in ("plane_strain", "solid") and lot.random() < 0.2:
        text += "large_rotation = true\n"
        if velocity_m_s:
            text += f"initial_angular_velocity_rad_s = {'100.0' if model == 'plane_strain' else '[50.0, 0.0, 100.0]'}\n"
    text += f"initial_velocity_m_s = {vector(model, velocity_m_s, lot.choice([0.0, 0.5]))}\n" if velocity_m_s else ""
    in_pieces = model != "bar" and lot.random() < 0.5
    middle_m = 0.5 * (low_m + high_m)
    if in_pieces:
        soft = f"material = {{ youngs_modulus_pa = {0.5 * modulus}, poisson_ratio = 0.3, density_kg_m3 = {density} }}, "
        text += "[body.mesh]\n"
        text += 'tie = [{ surfaces = ["a.end", "b.start"] }]\npiece = [\n'
        text += f'{{ name = "a", {block(lot, model, low_m, middle_m, 1, False)} }},\n'
        text += (f'{{ name = "b", {soft if lot.random() < 0.3 else ""}'
                 f'{block(lot, model, middle_m, high_m, lot.choice([1, 2]), False)} }}]\n')
    else:
        text += f"mesh = {{ {block(lot, model, low_m, high_m, 2, wanted)} }}\n"
    low, high = ("a.start", "b.end") if in_pieces else ("start", "end")
    z = {"bar": "x", "plane_strain": "y", "axisymmetric": "z", "solid": "z"}[model]
    foot = lot.choice(["free", "held", "driven", "absorbing", "free"])
    if name != "low":
        foot = "free"
    if foot == "held":
        text += f'[[body.support]]\nsurface = "{low}"\nfixed = ["{z}"]\n'
    elif foot == "driven":
        text += (f'[[body.prescribed]]\nsurface = "{low}"\ncomponent = "{z}"\ndisplacement_m = 1e-6\n'
                 "amplitude = { time_s = [0.0, 4e-6, 2e-5], factor = [0.0, 1.0, 0.5] }\n")
    elif foot == "absorbing":
        text += f'[[body.absorbing]]\nsurface = "{low}"\n' + ('' if model == "bar" else 'wave = "bar"\n')
    if loaded:
        text += (f'[[body.traction]]\nsurface = "{high}"\ntraction_pa = {vector(model, -5e7, lot.choice([0.0, 1e7]))}\n'
                 "amplitude = { time_s = [0.0, 2e-6, 6e-6, 8e-6], factor = [0.0, 1.0, 1.0, 0.0] }\n")
        if lot.random() < 0.3:
            text = text.replace("[body.mesh]", f"gravity_m_s2 = {vector(model, -1e4)}\n[body.mesh]")
    return text, high_m, low, high, in_pieces


def scene(lot):
    model = lot.choice(["bar", "plane_strain", "axisymmetric", "solid"])
    impact = lot.random() < 0.5
    text = f'model = "{model}"\n'
    lower, high_m, _, upper_end, in_pieces = body(lot, model, "low", 0.0, not impact, 0.0, True)
    text += lower
    probe_m = 0.5 * high_m
    if impact:
        upper, _, lower_end, _, _ = body(lot, model, "high", high_m + lot.choice([0.0, 5e-6]), False,
                                         -lot.choice([2.0, 5.0]), True)
        text += upper + f'[contact]\nsurfaces = ["low.{upper_end}", "high.{lower_end}"]\n'
        if model != "bar" and lot.random() < 0.4:
            text += "friction_coefficient = 0.3\n"
        law = lot.random()
        if law < 0.2:
            text += f'multiplier_update = "{lot.choice(["fully_implicit", "massless"])}"\n'
        elif law < 0.35:
            text += 'enforcement = "penalty"\npenalty_pa_m = 1e14\n'
        if model != "bar" and lot.random() < 0.2:
            text += "nose_radius_m = 0.5\n"
    rule = lot.choice(["auto", "length", "length", "modes"]) if impact else "groups" if in_pieces else "auto"
    text += "[partition]\n"
    if rule == "length":
        lengths = [f"low = {lot.choice([0.002, 0.004])}", f"high = {lot.choice([0.0, 0.003, 1.0])}"]
        text += f"implicit_length_m = {{ {', '.join(lengths)} }}\n"
    elif rule == "groups":
        text += f'implicit_groups = {{ low = ["{lot.choice("ab")}"] }}\n'
    else:
        text += 'rule = "auto"\n'
        if rule == "modes":
            text += f"reduced_modes = {{ low = {lot.choice([20, 60])} }}\n"
    step = lot.choice([3e-8, 6e-8, 1e-7])
    text += f"[time]\nstep_s = {step}\nend_s = 2.4e-5\n"
    if impact and lot.random() < 0.1:
        text += "until_separated_plus_s = 2e-6\n"
    if lot.random() < 0.2:
        text += f"changes = [{{ from_s = 9e-6, step_s = {0.5 * step} }}]\n"
    text += "[output]\nhistory_every = 4\n"
    at = {"bar": [probe_m], "plane_strain": [0.002, probe_m], "axisymmetric": [0.0, probe_m],
          "solid": [0.002, 0.002, probe_m]}[model]
    text += f'probe = [{{ name = "middle", body = "low", at_m = {at} }}]\n'
    if lot.random() < 0.3:
        text += f'gauge = [{{ name = "strain", body = "low", section_m = {probe_m}, rise_time_s = 1e-6 }}]\n'
    if rule != "modes" and lot.random() < 0.3:
        names = [["low"], ["high"]] if impact and lot.random() < 0.5 else [["low", "high"] if impact else ["low"]]
        for number, bodies in enumerate(names):
            listed = ", ".join(f'"{name}"' for name in bodies)
            text += f'[[participant]]\nname = "side_{number}"\nrole = "explicit"\nbodies = [{listed}]\n'
            text += lot.choice(["ranks = 2\n", "threads = 2\n", ""])
        text += '[[participant]]\nname = "centre"\nrole = "implicit"\n' + lot.choice(["threads = 2\n", ""])
    return text + '[coupling]\nprotocol = "hughes_liu"\n'


def probe(out):
    """Displacements of the probe along the body, and their times."""
    with open(out / "probes.csv") as file:
        rows = list(csv.DictReader(file))
    name = [key for key in rows[0] if "displacement" in key][-1]
    return [float(row["time_s"]) for row in rows], [float(row[name]) for row in rows]


class Trial:
    def __init__(self, ricochet, path):
        self.ricochet, self.path = ricochet, path

    def call(self, verb, protocol, *more, out=None, subject=None):
        command = [self.ricochet, verb, subject or self.path, *more]
        if subject is None:
            for change in [f"coupling.protocol={protocol}"] + ["coupling.substeps=2"] * (protocol in PROTOCOLS[6:8]):
                command += ["--set", change]
        command += ["--out", out] if out else []
        return subprocess.run(command, capture_output=True, text=True)

    def verdict(self, protocol):
        """What is wrong with a run, and its probe."""
        out = self.path.with_suffix("." + protocol)
        checked, run = self.call("check", protocol), self.call("run", protocol, out=out)
        if (checked.returncode == 0) != (run.returncode != REFUSED):
            return f"check {checked.returncode}, run {run.returncode}: {run.stderr.strip()[:300]}", None
        if run.returncode == REFUSED:
            return None, None
        known = run.returncode == NOT_CONVERGED and any(words in run.stderr for words in KNOWN)
        if run.returncode == LEFT_THE_MODEL or known:
            return "", None
        if run.returncode != 0:
            return f"code {run.returncode}: {run.stderr.strip().splitlines()[-1]}", None
        summary = json.loads((out / "summary.json").read_text())
        made, lost = summary["energy_error_highest"], summary["momentum_error_max"]
        if made > MOST_ENERGY or (lost > MOST_MOMENTUM and "of the momentum came" not in run.stderr
                                   and not (protocol in DRIFTING and lost < 1e-2)):
            return f"energy +{made:.1e}, momentum {lost:.1e}", probe(out)
        return self.resumed(protocol, out), probe(out)

    def resumed(self, protocol, out):
        half = out.with_suffix(".half_" + protocol)
        first = self.call("run", protocol, "--set", "time.end_s=1.2e-5", "--set",
                          "checkpoint.every_windows=70", out=half)
        second = self.call("resume", protocol, "--until", "2.4e-5", subject=half)
        if first.returncode or second.returncode:
            return f"half {first.returncode}, resumed {second.returncode}: {second.stderr.strip()[:300]}"
        same = (out / "probes.csv").read_bytes() == (half / "probes.csv").read_bytes()
        return "" if same else "other bytes when it is resumed"


def differences(probes):
    """Which runs differ from the run in the middle of all."""
    if len(probes) < 3:
        return
    names = list(probes)
    times = probes[names[0]][0]
    largest = max(max(map(abs, values)) for _, values in probes.values()) or 1.0
    far = {}
    for name in names:
        if probes[name][0] != times:
            continue
        apart = sorted(max(abs(a - b) for a, b in zip(probes[name][1], probes[other][1])) / largest for other in names)
        far[name] = apart[len(apart) // 2]
    for name, apart in far.items():
        if apart > MOST_DIFFERENCE:
            yield name, apart


def verdicts(ricochet, path):
    trial, probes = Trial(ricochet, path), {}
    for protocol in PROTOCOLS:
        said, seen = trial.verdict(protocol)
        if seen:
            probes[protocol] = seen
        yield protocol, True, said
    for protocol, apart in differences(probes):
        yield protocol, False, f"{apart:.2f} from the others"


if __name__ == "__main__":
    draw(__doc__, "set", scene, verdicts)
