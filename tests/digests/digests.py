#!/usr/bin/env python3
"""Digests of what every scene in configs/ computes, by every protocol, in three processes and in one.

    tests/digests/digests.py --write before.txt      # before a change that must not change results
    tests/digests/digests.py --against before.txt    # after it: exit code 1 and a list if any digest differs

A line is: scene, protocol, "processes" or "one", what, SHA-256. `what` is `history.csv`, `axial_stress.csv`, `fields` (all VTU and PVD
files) and `summary.json` without times, process ids, run ids and paths; of the run in one process, `history.csv`. A protocol that the
scene refuses has the digest of the message. Digests hold for one machine and one build configuration: another processor rounds otherwise.
"""

import argparse
import contextlib
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROTOCOLS = ["hughes_liu", "kim", "kim_predicted", "belytschko_mullen", "prakash_hjelmstad", "gravouil_combescure", "fixed_point",
             "all_implicit", "all_explicit"]
OF_THIS_RUN = {"wall_s", "cpu_s", "phases", "processes", "scene", "run_id", "scene_sha256", "version"}


def with_protocol(text, protocol):
    """The scene with another protocol; everything else, line by line, as it was."""
    if "coupling" not in tomllib.loads(text):
        return f'{text}\n[coupling]\nprotocol = "{protocol}"\n'
    table = re.search(r"^\[coupling\]$.*?(?=^\[|\Z)", text, re.M | re.S)
    body = re.sub(r"^protocol\s*=.*\n", "", table[0], flags=re.M).replace("[coupling]", f'[coupling]\nprotocol = "{protocol}"', 1)
    return text[:table.start()] + body + text[table.end():]


def digest(data):
    return hashlib.sha256(data).hexdigest()


def without_paths(text, folder):
    return re.sub(r"\d+\.\d+ m?s\b", "", text.replace(str(folder), "")).encode()


def of_run(build, scene, folder):
    out = folder / "out"
    run = subprocess.run([build / "ricochet", "run", scene, "--out", out], capture_output=True, text=True)
    yield "exit code", digest(str(run.returncode).encode())
    if not (out / "summary.json").exists():
        yield "message", digest(without_paths(run.stderr, folder))
        return
    for name in ("history.csv", "axial_stress.csv"):
        if (out / name).exists():
            yield name, digest((out / name).read_bytes())
    fields = sorted(path for path in (out / "fields").glob("*") if path.suffix in (".vtu", ".vtm", ".pvd"))
    if fields:
        yield "fields", digest(b"".join(path.name.encode() + path.read_bytes() for path in fields))
    summary = {key: value for key, value in json.loads((out / "summary.json").read_text()).items() if key not in OF_THIS_RUN}
    yield "summary.json", digest(without_paths(json.dumps(summary), folder))


def of_one_process(build, scene, folder):
    history = folder / "one.csv"
    run = subprocess.run([build / "one_process_history", scene, history], capture_output=True, text=True)
    if run.returncode == 0:
        yield "history.csv", digest(history.read_bytes())
    else:
        yield "message", digest(without_paths(run.stderr, folder))


@contextlib.contextmanager
def folder_with_scene(config, protocol):
    """A folder of its own with the scene under that protocol, and the meshes beside it."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for mesh in (ROOT / "configs").glob("*.msh"):
            (folder / mesh.name).symlink_to(mesh)
        scene = folder / config.name
        scene.write_text(with_protocol(config.read_text(), protocol))
        yield folder, scene


def lines(build):
    for config in sorted((ROOT / "configs").glob("*.toml")):
        for protocol in PROTOCOLS:
            with folder_with_scene(config, protocol) as (folder, scene):
                for how, found in (("processes", of_run(build, scene, folder)), ("one", of_one_process(build, scene, folder))):
                    for what, value in found:
                        yield f"{config.stem} {protocol} {how} {what.replace(' ', '_')} {value}"


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    task = options.add_mutually_exclusive_group(required=True)
    task.add_argument("--write", type=pathlib.Path)
    task.add_argument("--against", type=pathlib.Path)
    asked = options.parse_args()
    found = []
    for line in lines(asked.build.resolve()):
        print(line, file=sys.stderr)
        found.append(line)
    if asked.write:
        asked.write.write_text("\n".join(found) + "\n")
        return 0
    before = asked.against.read_text().split("\n")[:-1]
    for line in sorted(set(before) ^ set(found)):
        print(("- " if line in before else "+ ") + line)
    print(f"{len(set(before) & set(found))} of {len(before)} digests are the same")
    return 0 if set(before) == set(found) else 1


if __name__ == "__main__":
    sys.exit(main())
