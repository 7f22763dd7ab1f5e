#!/usr/bin/env python3
"""Draws impacts of curved bodies by lot and looks at what every run must keep: tests/experiments/random_curves.py
[--build DIR] [--seed N] [--count N] [--keep DIR]. Balls and discs against each other, blocks, rigid planes, rigid
spheres and rigid cylinders, apart or not, straight, oblique, spinning, with and without friction, by five protocols
each; under the first one also with the names in the other order and with the whole scene turned in space. A line
beginning with ! for each run that fails by another code than those of a refusal or of leaving the model, makes energy,
loses momentum, has another impulse than the first one, or writes other bytes when it is resumed in its middle or
computed with ranks or threads; then how many runs there were. Needs Python 3.11 alone."""
import itertools
import json
import math
import subprocess

from drawn_runs import draw

PROTOCOLS = ("all_explicit", "all_implicit", "hughes_liu", "local_explicit", "prakash_hjelmstad")
REFUSED, LEFT_THE_MODEL = 2, 6
MOST_ENERGY, MOST_MOMENTUM = 2e-2, 1e-7  # made, of the largest; lost, of the largest
# Differences of impulses, of the largest. Few nodes touch, and the order of names may choose whose they are.
MOST_BY_PROTOCOL, MOST_BY_ORDER, MOST_BY_TURN = 0.05, 0.1, 1e-3
CORE = 0.55  # half the edge of the block in the middle of a ball, of its radius


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def ball_mesh(model, radius_m, across, layers, triangles):
    """An .inp file of a ball of which `across` elements, an even number, lie across the block in its middle and
    `layers` around that; in a plane they may be cut into triangles. Surfaces "low" and "high", within 50 degrees of the
    vertical, the last axis, and "outside"."""
    solid = model == "solid"
    dimensions = 3 if solid else 2
    nodes, elements, surfaces = {}, [], {"low": [], "high": [], "outside": []}

    def node(place, layer):
        key = (place, layer)
        if key not in nodes:
            cube = [2.0 * p / across - 1.0 for p in place]
            share = layer / layers
            length = math.sqrt(dot(cube, cube)) or 1.0
            bulge = 1.0 - 0.125 * (length * length - 1.0) * max(map(abs, cube)) ** 2
            rounded = [CORE * bulge * c for c in cube]
            nodes[key] = (len(nodes) + 1, [radius_m * ((1.0 - share) * r + share * c / length)
                                           for r, c in zip(rounded, cube)])
        return nodes[key][0]

    def add(corners):
        places = {number: x for number, x in nodes.values()}
        x = [places[c] for c in corners]
        if solid:
            a, b, c = ([x[i][k] - x[0][k] for k in range(3)] for i in (1, 3, 4))
            positive = dot(cross(a, b), c) > 0.0
        else:
            a, b = ([x[i][k] - x[0][k] for k in range(2)] for i in (1, 3))
            positive = a[0] * b[1] - a[1] * b[0] > 0.0
        if not positive and solid:
            corners = [corners[i] for i in (0, 3, 2, 1, 4, 7, 6, 5)]
        elif not positive:
            corners = corners[:1] + corners[:0:-1]
        elements.extend([corners[:3], [corners[0], *corners[2:]]] if triangles else [corners])
        return positive

    def face(side, axis, cell):
        """Corners of a cell of the block's side, in order around."""
        square = [(0, 0), (1, 0), (1, 1), (0, 1)] if solid else [(0,), (1,)]
        for offsets in square:
            place = [c + o for c, o in zip(cell, offsets)]
            yield tuple(place[:axis] + [side] + place[axis:])

    start = across // 2 if model == "axisymmetric" else 0
    ranges = [range(start, across)] + [range(across)] * (dimensions - 1)
    for cell in itertools.product(*ranges):
        around = [(0, 0), (1, 0), (1, 1), (0, 1)]
        corners = [tuple(c + o for c, o in zip(cell, (*pair, up)[:dimensions]))
                   for up in range(2 if solid else 1) for pair in around]
        numbers = [node(corner, 0) for corner in corners]
        add(numbers)
    for axis, side in itertools.product(range(dimensions), (0, across)):
        if model == "axisymmetric" and axis == 0 and side == 0:
            continue
        for cell in itertools.product(*(ranges[:axis] + ranges[axis + 1:])):
            corners = list(face(side, axis, cell))
            for layer in range(layers):
                inner, outer = [node(c, layer) for c in corners], [node(c, layer + 1) for c in corners]
                positive = add(inner + outer if solid else [inner[0], inner[1], outer[1], outer[0]])
            middle = [sum(nodes[(c, layers)][1][k] for c in corners) / len(corners) for k in range(dimensions)]
            last = (len(elements), "S2" if solid or not positive else "S3")
            if triangles:  # the first of two has the quadrilateral's side S2, the second its S3, as its S2
                last = (len(elements) - (not positive), "S2")
            surfaces["outside"].append(last)
            up = middle[-1] / math.sqrt(dot(middle, middle))
            if abs(up) > math.cos(math.radians(50.0)):
                surfaces["high" if up > 0.0 else "low"].append(last)
    text = "*NODE, NSET=ALL\n"
    text += "".join(f"{number}, {', '.join(f'{c:.15g}' for c in x)}\n" for number, x in nodes.values())
    kind = {"solid": "C3D", "plane_strain": "CPE", "axisymmetric": "CAX"}[model] + str(len(elements[0]))
    text += f"*ELEMENT, TYPE={kind}, ELSET=BALL\n"
    text += "".join(f"{i + 1}, {', '.join(map(str, corners))}\n" for i, corners in enumerate(elements))
    for name, faces in surfaces.items():
        text += f"*SURFACE, NAME={name}\n" + "".join(f"{element}, {label}\n" for element, label in faces)
    return text


class Space:
    """Vectors of a scene that is turned about an axis as a whole."""

    def __init__(self, model, turned_deg):
        self.model, self.turned_deg = model, turned_deg
        length = math.sqrt(dot(turned_deg, turned_deg))
        self.angle, self.axis = math.radians(length), [t / length for t in turned_deg] if length else [0.0, 0.0, 1.0]

    def numbers(self, vector):
        """Of [across, up] in a plane and [x, y, z] in space, as the scene has it."""
        full = list(vector) + [0.0] * (3 - len(vector))
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        along = dot(self.axis, full) * (1.0 - cos)
        turned = [cos * f + sin * c + along * a for f, c, a in zip(full, cross(self.axis, full), self.axis)]
        return turned[:len(vector)]

    def vector(self, vector):
        return "[" + ", ".join(f"{c:.15g}" for c in self.numbers(vector)) + "]"

    def place(self, moved_m):
        if self.model == "axisymmetric":
            return ""
        turned = ""
        if self.angle:
            degrees = f"{self.turned_deg[2]}" if self.model == "plane_strain" else str(list(self.turned_deg))
            turned = f"turned_deg = {degrees}, "
        return f", place = {{ {turned}moved_m = {self.vector(moved_m)} }}"


def vertical(model, aside, up):
    """[across, up] or [x, y, z]."""
    return [aside, -0.4 * aside, up] if model == "solid" else [aside, up]


def drawn(lot):
    """What is drawn, as a dictionary that a scene and its variants are written from."""
    model = lot.choice(["plane_strain", "solid", "axisymmetric"])
    round_one = {"plane_strain": "rigid_cylinder", "solid": lot.choice(["rigid_sphere", "rigid_cylinder"]),
                 "axisymmetric": "rigid_sphere"}[model]
    below = lot.choice(["ball", "ball", "block", "rigid_plane", round_one])
    above = "block" if below == round_one or (below == "ball" and lot.random() < 0.3) else "ball"
    aside = 0.0 if model == "axisymmetric" or below == round_one else lot.choice([0.0, 0.0, 0.5, 4.0])
    off_m = 0.0 if model == "axisymmetric" or below in ("block", "rigid_plane") else lot.choice([0.0, 0.0, 0.001])
    spin = lot.choice([0.0, 300.0]) if model != "axisymmetric" and above == "ball" else 0.0
    gap_m = lot.choice([0.0, 3e-6, 5e-5, 2e-4])
    across = lot.choice([4, 6] if model == "solid" else [8, 12])
    layers = lot.choice([2, 3] if model == "solid" else [4, 6])
    degrees = [0.0, 0.0, lot.uniform(-170.0, 170.0)] if model == "plane_strain" else \
        [lot.uniform(-90.0, 90.0) * (below != "rigid_cylinder" or k == 1) for k in range(3)]
    triangles = model != "solid" and lot.random() < 0.3
    return {"triangles": triangles, "model": model, "below": below, "above": above, "aside": aside, "off_m": off_m,
            "spin": spin, "gap_m": gap_m, "by_key": lot.random() < 0.3, "fall": lot.choice([1.0, 4.0]),
            "friction": lot.choice([0.0, 0.3]), "across": across, "layers": layers,
            "coarser": lot.choice([0, 2]), "radius_m": lot.choice([0.005, 0.008]),
            "radius_below_m": lot.choice([0.005, 0.01]), "modulus": lot.choice([20e9, 70e9]),
            "modulus_below": lot.choice([70e9, 200e9]), "yields": lot.random() < 0.1, "rigid": lot.random() < 0.1,
            "turns": spin != 0.0 or (model != "axisymmetric" and lot.random() < 0.2),
            "outside": lot.random() < 0.3, "turned_deg": degrees, "deep": lot.choice([0.3, 0.7, 0.0]),
            "resumed": lot.choice(PROTOCOLS[:3]), "hands": lot.choice(["", "", "ranks = 2", "threads = 2"])}


def body(name, d, space, mesh, moved_m, velocity, modulus, flags):
    text = f'[[body]]\nname = "{name}"\n'
    text += "rigid = true\n" if flags.get("rigid") else ""
    text += "large_rotation = true\n" if flags.get("turns") else ""
    text += f"material = {{ youngs_modulus_pa = {modulus}, poisson_ratio = 0.3, density_kg_m3 = 7800.0"
    text += ", plasticity = { yield_stress_pa = 3e8, hardening_pa = 1e9 }" if flags.get("yields") else ""
    text += f" }}\ninitial_velocity_m_s = {space.vector(velocity)}\n"
    if flags.get("spin"):
        rates = [0.0, flags["spin"], 0.5 * flags["spin"]]
        text += "initial_angular_velocity_rad_s = "
        text += (space.vector(rates) if d["model"] == "solid" else str(flags["spin"])) + "\n"
    return text + f"mesh = {{ {mesh}{space.place(moved_m)} }}\n"


def write(d, path, turned, swapped, hands=""):
    """The scene and its meshes; `hands`: how many compute the explicit side."""
    model, dimensions = d["model"], 3 if d["model"] == "solid" else 2
    space = Space(model, d["turned_deg"] if turned else [0.0, 0.0, 0.0])
    around = d["outside"] and d["turns"] and d["above"] == "ball"

    def ball(name, radius_m, coarser):
        mesh = path.with_name(f"{path.stem}_{name}.inp")
        across, layers = max(4, d["across"] - coarser), d["layers"]
        text = ball_mesh(model, radius_m, across, layers, d["triangles"])
        if model == "axisymmetric":  # stands on its axis where it is
            text = raised(text, radius_m + lift if name == "above" else -radius_m)
        mesh.write_text(text.replace("BALL", name))
        return f'inp = "{mesh.name}"'

    def block(width_m, low_m):
        n, m, height_m = d["across"] + 2, max(3, d["layers"]), 0.006
        if model == "axisymmetric":
            return f"start_m = {low_m}, length_m = {height_m}, radius_m = {width_m / 2}, elements = [{n}, {m}]"
        if model == "plane_strain":
            return f"length_m = {height_m}, height_m = {width_m}, elements = [{2 * n}, {m}]"
        return f"length_m = {height_m}, height_m = {width_m}, width_m = {width_m}, elements = [{n}, {n}, {m}]"

    def corner(width_m, low_m, off_m):
        """Where the block's low corner goes."""
        return [off_m - 0.5 * width_m, *[-0.5 * width_m] * (dimensions - 2), low_m]

    lift = d["gap_m"]
    by_key = d["by_key"] and model != "axisymmetric" and not d["turns"] and not d["aside"]
    bodies = []
    stands = 0.0 if by_key else lift
    fall = vertical(model, d["aside"], -d["fall"])
    above_is_ball = d["above"] == "ball"
    radius_m, below_m = d["radius_m"], d["radius_below_m"]
    high = math.sqrt((below_m + radius_m) ** 2 - d["off_m"] ** 2) - below_m if d["below"] == "ball" and above_is_ball \
        else radius_m
    flags = {"yields": d["yields"], "spin": d["spin"], "turns": d["turns"],
             "rigid": d["rigid"] and d["below"] in ("ball", "block")}
    if above_is_ball:
        moved = vertical(model, 0.0, high + stands)
        moved[0] += d["off_m"]
        bodies.append(body("above", d, space, ball("above", radius_m, 0), moved, fall, d["modulus"], flags))
    else:
        bodies.append(body("above", d, space, block(0.012, stands), corner(0.012, stands, d["off_m"]), fall,
                           d["modulus"], flags))
    if d["below"] == "ball":
        bodies.append(body("below", d, space, ball("below", below_m, d["coarser"]), vertical(model, 0.0, -below_m),
                           vertical(model, 0.0, 0.0), d["modulus_below"], {}))
    elif d["below"] == "block":
        bodies.append(body("below", d, space, block(0.016, -0.006), corner(0.016, -0.006, 0.0),
                           vertical(model, 0.0, 0.0), d["modulus_below"], {}))
    sides = {"above": "outside" if around else "low" if above_is_ball else "start",
             "below": {"ball": "high", "block": "end"}.get(d["below"])}
    names = ["above", "below"] if d["below"] in ("ball", "block") else ["above"]
    if swapped:
        names.reverse()
        bodies.reverse()
    surfaces = [f"{name}.{sides[name]}" for name in names] + ([] if len(names) == 2 else [d["below"]])
    text = f'model = "{model}"\n' + "".join(bodies)
    text += "[contact]\nsurfaces = [" + ", ".join(f'"{s}"' for s in surfaces) + "]\n"
    text += f"friction_coefficient = {d['friction']}\n" if d["friction"] else ""
    if around and names[0] == "above":
        text += f"normal = {space.vector(vertical(model, 0.0, -1.0))}\n"
    if d["below"].startswith("rigid"):
        plane = d["below"] == "rigid_plane"
        text += "" if plane else f"rigid_radius_m = {below_m}\n"
        text += 'rigid_axis = "y"\n' if d["below"] == "rigid_cylinder" and model == "solid" else ""
        if model != "axisymmetric" and not by_key:
            text += f"rigid_place_m = {space.vector(vertical(model, 0.0, 0.0))}\n"
            text += f"normal = {space.vector(vertical(model, 0.0, -1.0))}\n" if plane and not around else ""
    if by_key or (model == "axisymmetric" and d["below"].startswith("rigid")):
        text += f"initial_gap_m = {lift}\n" if lift else ""
    parts = [f"{name} = {d['deep'] * radius_m}" for name in names if not (flags["rigid"] and name == "above")]
    partition = f'implicit_length_m = {{ {", ".join(parts)} }}' if d["deep"] else 'rule = "auto"'
    text += f"[partition]\n{partition}\n[time]\nstep_s = {4e-8 if dimensions == 2 else 5e-8}\n"
    text += "end_s = 1.5e-4\n[output]\nhistory_every = 20\n[coupling]\nprotocol = \"all_explicit\"\n"
    if hands:
        named = ", ".join(f'"{name}"' for name in names)
        text += f'[[participant]]\nname = "explicit"\nrole = "explicit"\nbodies = [{named}]\n{hands}\n'
        text += '[[participant]]\nname = "implicit"\nrole = "implicit"\n'
    path.write_text(text)


def raised(text, up_m):
    """The same .inp with its nodes moved along the second axis."""
    lines, in_nodes = [], False
    for line in text.splitlines():
        if line.startswith("*"):
            in_nodes = line.startswith("*NODE")
        elif in_nodes:
            number, r, z = line.split(",")
            line = f"{number}, {r}, {float(z) + up_m:.15g}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def impulse(summary):
    """Of the contact [N s]."""
    return summary["contact_impulse_n_s"]


def differs(first, other, most):
    a, b = impulse(first), impulse(other)
    return f"impulse {b:.5g} where {a:.5g}" if abs(a - b) > most * max(abs(a), abs(b)) else ""


def scene(lot):
    return json.dumps(drawn(lot))


def call(*command):
    return subprocess.run(command, capture_output=True, text=True)


def with_keys(changes):
    return itertools.chain.from_iterable(("--set", change) for change in changes)


def resumed(ricochet, path, protocol):
    """What is wrong with a run that is resumed in its middle, beside the whole one."""
    whole, half = path.with_suffix("." + protocol), path.with_suffix(".half")
    keys = with_keys([f"coupling.protocol={protocol}", "time.end_s=7.5e-5", "checkpoint.every_windows=700"])
    first = call(ricochet, "run", path, "--out", half, *keys)
    second = call(ricochet, "resume", half, "--until", "1.5e-4")
    if first.returncode or second.returncode:
        return f"half {first.returncode}, resumed {second.returncode}: {second.stderr.strip()[:300]}"
    return "" if same_history(whole, half) else "other bytes when it is resumed"


def same_history(one, other):
    return (one / "history.csv").read_bytes() == (other / "history.csv").read_bytes()


def by_many_hands(ricochet, path, d, protocol):
    """What is wrong with a run by ranks or threads, beside that of one."""
    many = path.with_name(f"{path.stem}_hands.toml")
    write(d, many, False, False, d["hands"])
    said, summary = run(ricochet, many, protocol)
    if summary is None:
        return said or ""
    same = same_history(path.with_suffix("." + protocol), many.with_suffix("." + protocol))
    return said if same else f"other bytes with {d['hands']}"


def run(ricochet, path, protocol):
    """What is wrong, or an empty text, None if it was refused; and the summary of a run that came to its end."""
    out = path.with_suffix("." + protocol)
    changes = [f"coupling.protocol={protocol}"] + ["coupling.substeps=2"] * (protocol == "prakash_hjelmstad")
    done = call(ricochet, "run", path, "--out", out, *with_keys(changes))
    if done.returncode == REFUSED:
        return None, None
    if done.returncode == LEFT_THE_MODEL:
        return "", None
    if done.returncode != 0:
        return f"code {done.returncode}: {(done.stderr.strip() or 'no word').splitlines()[-1]}", None
    summary = json.loads((out / "summary.json").read_text())
    made, lost = summary["energy_error_highest"], summary["momentum_error_max"]
    wrong = made > MOST_ENERGY or lost > MOST_MOMENTUM
    return f"energy +{made:.1e}, momentum {lost:.1e}" if wrong else "", summary


def verdicts(ricochet, path):
    d = json.loads(path.read_text())
    first = None
    for protocol in PROTOCOLS:
        write(d, path, False, False)
        said, summary = run(ricochet, path, protocol)
        yield protocol, True, said
        first = summary if protocol == PROTOCOLS[0] else first
        if first and summary:
            yield protocol, False, differs(first, summary, MOST_BY_PROTOCOL)
        if summary and protocol == d["resumed"]:
            yield f"resumed {protocol}", False, resumed(ricochet, path, protocol)
        if summary and d["hands"] and protocol in ("all_explicit", "hughes_liu"):
            yield protocol, False, by_many_hands(ricochet, path, d, protocol)
    for name, turned, swapped, most in (("turned", True, False, MOST_BY_TURN), ("swapped", False, True, MOST_BY_ORDER)):
        if (turned and d["model"] == "axisymmetric") or (swapped and d["below"].startswith("rigid")):
            continue
        variant = path.with_name(f"{path.stem}_{name}.toml")
        write(d, variant, turned, swapped)
        said, summary = run(ricochet, variant, PROTOCOLS[0])
        yield name, True, said
        if first and summary:
            yield name, False, differs(first, summary, most)


if __name__ == "__main__":
    draw(__doc__, "curve", scene, verdicts)
