#!/usr/bin/env python3
"""Whether two builds compute the same physics: every scene in configs/, by every protocol, compared by value.

    tests/digests/physics.py --build before/build --write FOLDER     # keeps history.csv and summary.json of each run
    tests/digests/physics.py --build build --against FOLDER          # exit code 1 and a list if any number differs

Numbers of a column of history.csv may differ by 1e-9 (--tolerance) of the column's largest magnitude, which of energies is that of all
energies and of momenta that of all momenta and impulses; numbers of summary.json by 1e-9 of their own, or of what the history has of their
unit; those of fixed_point by ten times the tolerance of its iteration, if that is more. Counts of pairs and exit codes are equal. The
effort of finding the forces (iterations, residuals) and times of the computer are not compared. Where a byte may not change, digests.py
tells.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

from digests import OF_THIS_RUN, PROTOCOLS, ROOT, folder_with_scene

OF_THE_METHOD = {"contact_iterations", "contact_residual", "coupling_residual", "coupling_iterations"}
# Differences of numbers that are larger by far: their round-off is that of those.
SCALE_OF = {"energy_error": 1.0, "energy_drift": 1.0, "momentum_error": 1.0, "angular_momentum_error": 1.0}

# Round-off decides where within coupling.tolerance, 1e-10, its iteration ends.
OF_FIXED_POINT = 1e-9


def run(build, scene, folder):
    """Exit code; history.csv and summary.json are in the folder."""
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name) / "out"
        done = subprocess.run([build / "ricochet", "run", scene, "--out", out], capture_output=True, text=True)
        for kept in ("history.csv", "summary.json"):
            if (out / kept).exists():
                (folder / kept).write_bytes((out / kept).read_bytes())
    (folder / "exit_code").write_text(str(done.returncode))


def columns(folder):
    path = folder / "history.csv"
    if not path.exists():
        return {}
    rows = list(csv.reader(path.open()))
    return {name: [float(row[i] or "nan") for row in rows[1:]] for i, name in enumerate(rows[0])}


def scales(found):
    """The largest magnitude of each column, of energies and of momenta together."""
    own = {name: max((abs(x) for x in values if x == x), default=0.0) for name, values in found.items()}
    for kinds in (["energy_"], ["momentum_", "_impulse_"], ["velocity_"], ["_force_"]):
        members = [name for name in own if any(kind in name for kind in kinds) and name not in SCALE_OF]
        largest = max((own[name] for name in members), default=0.0)
        own.update({name: largest for name in members})
    if "gap_min_m" in own:  # closed gaps are the round-off of displacements
        own["gap_min_m"] = max(own["gap_min_m"], own["time_s"] * max((own[name] for name in own if "velocity_" in name), default=0.0))
    return own | {name: scale for name, scale in SCALE_OF.items() if name in own}


def numbers(value, path=""):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{path}/{key}")
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from numbers(inner, f"{path}/{i}")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield path, float(value)


def summary(folder):
    path = folder / "summary.json"
    if not path.exists():
        return {}
    return dict(numbers({key: value for key, value in json.loads(path.read_text()).items() if key not in OF_THIS_RUN}))


def scale_of_number(name, value, of_columns):
    """Of a number of the summary, with the history's of its unit."""
    kind = next((k for k in ("energy", "momentum", "impulse", "force") if k in name), None)
    return max([abs(value)] + [scale for column, scale in of_columns.items() if kind and kind in column])


def differences(before, after, tolerance):
    """Name and difference over its scale of all that is not the same."""
    if (before / "exit_code").read_text() != (after / "exit_code").read_text():
        yield "exit code", float("inf")
        return
    old, new = columns(before), columns(after)
    scale = scales(old)
    for name in sorted((set(old) | set(new)) - OF_THE_METHOD):
        if len(old.get(name, ())) != len(new.get(name, ())):
            yield f"rows of {name}", float("inf")
            continue
        worst = max((0.0 if x == y or (x != x and y != y) else abs(x - y) for x, y in zip(old[name], new[name])), default=0.0)
        if worst > tolerance * scale[name]:
            yield name, worst / scale[name] if scale[name] > 0.0 else float("inf")
    old, new = summary(before), summary(after)
    for name in sorted(set(old) | set(new)):
        if any(part in name for part in ("iterations", "residual", "_s/", "error", "drift")):
            continue
        if name not in old or name not in new:
            yield name, float("inf")
            continue
        by, of = abs(old[name] - new[name]), scale_of_number(name, old[name], scale)
        if by > tolerance * of:
            yield name, by / of if of > 0.0 else float("inf")


def cases(scenes, protocols):
    for config in sorted((ROOT / "configs").glob("*.toml")):
        for protocol in PROTOCOLS:
            if (not scenes or config.stem in scenes) and (not protocols or protocol in protocols):
                yield config, protocol


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    options.add_argument("--scenes", nargs="*", default=[], help="names in configs/; without it, all")
    options.add_argument("--protocols", nargs="*", default=[], help="without it, all")
    options.add_argument("--tolerance", type=float, default=1e-9, help="of a number's scale; without it, 1e-9")
    task = options.add_mutually_exclusive_group(required=True)
    task.add_argument("--write", type=pathlib.Path)
    task.add_argument("--against", type=pathlib.Path)
    asked = options.parse_args()
    differ = compared = 0
    for config, protocol in cases(asked.scenes, asked.protocols):
        kept = (asked.write or asked.against) / f"{config.stem}-{protocol}"
        if asked.against and not kept.exists():
            continue
        with folder_with_scene(config, protocol) as (folder, scene):
            into = kept if asked.write else folder / "kept"
            into.mkdir(parents=True, exist_ok=True)
            run(asked.build.resolve(), scene, into)
            if asked.write:
                continue
            tolerance = max(asked.tolerance, OF_FIXED_POINT) if protocol == "fixed_point" else asked.tolerance
            found = list(differences(kept, into, tolerance))
            compared += 1
            differ += bool(found)
            for what, by in found:
                print(f"{config.stem} {protocol}: {what} differs by {by:.1e}", flush=True)
    if asked.against:
        print(f"{compared - differ} of {compared} runs have the same physics")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
