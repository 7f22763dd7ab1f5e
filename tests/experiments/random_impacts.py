#!/usr/bin/env python3
"""Draws impacts by lot and looks at what every run must keep: tests/experiments/random_impacts.py [--build DIR]
[--seed N] [--count N] [--keep DIR]. Two or three blocks or cylinders, apart or not, tilted, spinning, turning as they
are told, held, on a rigid plane, rigid, yielding, refined, touching by one side or by all, apart by a gap, with and
without friction, in either order of names, by five protocols each. A line beginning with ! for each run that fails by
another code than those of a refusal or of leaving the model, makes energy, or loses momentum; then how many runs there
were. Needs Python 3.11 alone."""
import json
import math
import subprocess

from drawn_runs import draw

PROTOCOLS = ("all_explicit", "all_implicit", "hughes_liu", "local_explicit", "prakash_hjelmstad")
REFUSED, LEFT_THE_MODEL = 2, 6
MOST_ENERGY, MOST_MOMENTUM = 2e-2, 1e-7  # made, of the largest; lost, of the largest


def material(lot, yields):
    text = (f"material = {{ youngs_modulus_pa = {lot.choice([20e9, 70e9, 200e9])}, poisson_ratio = "
            f"{lot.choice([0.0, 0.3])}, density_kg_m3 = {lot.choice([2700.0, 8000.0])}")
    return text + (", plasticity = { yield_stress_pa = 2e8, hardening_pa = 1e9 } }\n" if yields else " }\n")


def down(model, of=1.0):
    """A vector downwards, as text."""
    return f"[{'0.0, ' * (2 if model == 'solid' else 1)}{-of}]"


def block(lot, model, name, low_m, top):
    """A body whose lower side is at `low_m`, its height, whether it is rigid and may touch all around, and whether it
    lies on a rigid plane: the first one may do that, be held or be told how to turn."""
    turns = model != "axisymmetric" and lot.random() < 0.5
    rigid, first = lot.random() < 0.2, low_m == 0.0
    width, height, across = lot.choice([0.006, 0.01, 0.016]), lot.choice([0.004, 0.006]), lot.choice([3, 5, 8])
    along = lot.choice([2, 4])
    text = f'[[body]]\nname = "{name}"\n' + ("rigid = true\n" if rigid else "")
    text += f"gravity_m_s2 = {down(model, 2e4)}\n" if lot.random() < 0.1 else ""
    text += ("large_rotation = true\n" if turns else "") + material(lot, not rigid and lot.random() < 0.15)
    fall, aside = -lot.choice([1.0, 5.0]) if top else 0.0, lot.choice([0.0, 0.0, 2.0, 10.0]) if top else 0.0
    floor = first and not rigid and lot.random() < 0.4
    told = first and not floor and lot.random() < 0.3 and model != "axisymmetric"
    held = first and not floor and not told and lot.random() < 0.4 and not (turns and rigid)
    tilt = lot.choice([0.0, 0.0, 0.5, 5.0]) if top and model != "axisymmetric" else 0.0
    upto = f"to_m = [{0.4 * width}, {f'{0.6 * width}, ' if model == 'solid' else ''}{0.5 * height}]"
    finer = f", refine = [{{ from_m = {[0.0] * (3 if model == 'solid' else 2)}, {upto}, ratio = {lot.choice([2, 4])}"
    finer = finer + " }]" if lot.random() < 0.3 and not rigid and model != "axisymmetric" else ""
    lift = low_m + 0.5 * width * math.sin(math.radians(tilt))
    if model == "axisymmetric":
        text += f"initial_velocity_m_s = [0.0, {fall}]\n"
        text += f"mesh = {{ start_m = {low_m}, length_m = {height}, radius_m = {width}, "
        text += f"elements = [{across}, {along}] }}\n"
    elif model == "plane_strain":
        text += f"initial_velocity_m_s = [{aside}, {fall}]\n"
        turned = f"turned_deg = {tilt}, about_m = [{0.5 * width}, 0.0], " if tilt else ""
        text += f"mesh = {{ length_m = {height}, height_m = {width}, elements = [{across}, {along}]{finer}, "
        text += f"place = {{ {turned}moved_m = [{-0.5 * width}, {lift}] }} }}\n"
    else:
        text += f"initial_velocity_m_s = [{aside}, {-aside / 3.0}, {fall}]\n"
        turned = f"turned_deg = [0.0, {tilt}, 0.0], about_m = [{0.5 * width}, {0.5 * width}, 0.0], " if tilt else ""
        text += f"mesh = {{ length_m = {height}, height_m = {width}, width_m = {width}, "
        text += f"elements = [{across}, {max(2, across - 1)}, {along}]{finer}, "
        text += f"place = {{ {turned}moved_m = [{-0.5 * width}, {-0.5 * width}, {lift}] }} }}\n"
    solid = model == "solid"
    if turns and lot.random() < 0.4 and not told and not held:
        spin = "[100.0, 200.0, 50.0]" if solid else "300.0"
        text = text.replace("large_", f"initial_angular_velocity_rad_s = {spin}\nlarge_")
    if held:
        fixed = {"axisymmetric": '"z"', "plane_strain": '"x", "y"', "solid": '"x", "y", "z"'}[model]
        text += f'[[body.support]]\nsurface = "start"\nfixed = [{fixed}]\n'
    if told:
        rate = lot.choice([20.0, 200.0]) if turns else 5.0
        turn, about = (f"[0.0, {rate}, 0.0]", "[0.003, 0.0, -0.002]") if solid else (f"{rate}", "[0.003, -0.002]")
        text += f'[[body.prescribed]]\nsurface = "start"\nturn_rad = {turn}\nabout_m = {about}\n'
        text += "amplitude = { time_s = [0.0, 1.0], factor = [0.0, 1.0] }\n"
    return text, height, rigid, turns and not (finer or held or told) and lot.random() < 0.5, floor


def scene(lot):
    model, friction = lot.choice(["plane_strain", "solid", "axisymmetric"]), lot.choice([0.0, 0.3])
    rubs = f"friction_coefficient = {friction}\n" if friction else ""
    names, text, low_m, lengths = ("low", "high", "highest")[: lot.choice([2, 2, 3])], f'model = "{model}"\n', 0.0, []
    around = {}
    on_plane = ""
    for name in names:
        body, height, rigid, around[name], floor = block(lot, model, name, low_m, name == names[-1])
        text += body
        low_m += height + lot.choice([0.0, 2e-6, 1e-5, 2e-4])
        lengths += [] if rigid else [f"{name} = {0.5 * height}"]
        if floor:
            side = "outside" if around[name] else "start"
            on_plane = f'[[contact]]\nname = "floor"\nsurfaces = ["{name}.{side}", "rigid_plane"]\n{rubs}'
            if model != "axisymmetric":
                on_plane += f"rigid_place_m = {down(model, 0.0)}\nnormal = {down(model)}\n"
    text += on_plane
    for below, above in zip(names, names[1:]):
        pair = [(below, "end", -1.0), (above, "start", 1.0)]
        lot.shuffle(pair)
        surfaces = ", ".join(f'"{name}.{"outside" if around[name] else side}"' for name, side, _ in pair)
        text += f'[[contact]]\nname = "{below}"\nsurfaces = [{surfaces}]\n{rubs}'
        if around[pair[0][0]]:
            text += f"normal = {down(model, pair[0][2])}\n"
        elif lot.random() < 0.2:
            text += lot.choice(["initial_gap_m = 5e-6\n", "nose_radius_m = 0.5\n"])
    times = lot.choice(["flight_step_s = 3e-7\n", "until_separated_plus_s = 1e-5\n"] + [""] * 8)
    return text + (f"[partition]\nimplicit_length_m = {{ {', '.join(lengths)} }}\n[time]\nstep_s = 6e-8\nend_s = 2e-4\n"
                   f'{times}[output]\nhistory_every = 20\n[coupling]\nprotocol = "all_explicit"\n')


def verdict(ricochet, path, protocol):
    """What is wrong with a run, or an empty text; none if it was refused."""
    out = path.with_suffix("." + protocol)
    changes = [f"coupling.protocol={protocol}"] + ["coupling.substeps=2"] * (protocol == "prakash_hjelmstad")
    command = [ricochet, "run", path, "--out", out]
    for change in changes:
        command += ["--set", change]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode == REFUSED:
        return None
    if run.returncode == LEFT_THE_MODEL:
        return ""
    if run.returncode != 0:
        return f"code {run.returncode}: {run.stderr.strip().splitlines()[-1]}"
    summary = json.loads((out / "summary.json").read_text())
    made, lost = summary["energy_error_highest"], summary["momentum_error_max"]
    return f"energy +{made:.1e}, momentum {lost:.1e}" if made > MOST_ENERGY or lost > MOST_MOMENTUM else ""


def verdicts(ricochet, path):
    for protocol in PROTOCOLS:
        yield protocol, True, verdict(ricochet, path, protocol)


if __name__ == "__main__":
    draw(__doc__, "impact", scene, verdicts)
