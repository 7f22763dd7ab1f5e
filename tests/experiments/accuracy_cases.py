#!/usr/bin/env python3
"""Asks scenes with exact answers for results within 10, 3, 1 and 0.3 %, by the table [accuracy], and compares what the
run has with the exact answer: tests/experiments/accuracy_cases.py [--build DIR] [--only WORD] [--meshes]. With --meshes
the choice may take twice to 16 times the elements, too. One line for each case: asked, expected before the run, bar
after it, true error, what was chosen; then how often the answer holds. Needs Python 3.11 alone."""
import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
ERRORS = (0.1, 0.03, 0.01, 0.003)


def open_scene(name, elements, end_s=None):
    """The scene of configs/ with so many elements a body, without step and safety factor."""
    text = (ROOT / "configs" / f"{name}.toml").read_text()
    text = re.sub(r"elements = \d+", f"elements = {elements}", text)
    text = re.sub(r"(?m)^(step_s|safety_factor) = .*\n", "", text)
    return re.sub(r"end_s = \S+", f"end_s = {end_s}", text) if end_s else text


def impulse_of_unequal_bars(end_s):
    """Force v Z1 Z2/(Z1 + Z2) r^n in the n-th interval of 2 L1/c1, r = (Z1 - Z2)/(Z1 + Z2)."""
    area, length, speed = 1e-4, 0.1, 10.0
    impedance = [area * (e * rho) ** 0.5 for e, rho in ((207e9, 7860.0), (70e9, 2700.0))]
    first = speed * impedance[0] * impedance[1] / sum(impedance)
    ratio = (impedance[0] - impedance[1]) / sum(impedance)
    interval, sum_, n = 2 * length / (207e9 / 7860.0) ** 0.5, 0.0, 0
    while n * interval < end_s:
        sum_ += first * ratio**n * (min((n + 1) * interval, end_s) - n * interval)
        n += 1
    return sum_


def cases():
    """(name, scene, quantity, exact answer)"""
    force, contact, end = 1.33453e5, 98.937e-6, 148.393e-6
    bars = {"contact_impulse_n_s": force * contact, "rebound_velocity_left_m_s": -5.13588, "separation_time_s": end,
            "contact_duration_s": contact, "plateau_stress_pa": force / 6.4516e-4}
    for elements in (40, 160):
        for quantity, exact in bars.items():
            yield f"two_bars {elements}", open_scene("two_bars", elements, "300e-6"), quantity, exact
    for elements in (80, 320):
        yield f"rod_on_stop {elements}", open_scene("rod_on_stop", elements, "2.5"), "contact_impulse_n_s", 0.5
    for end_s in (60e-6, 100e-6):
        scene = open_scene("unequal_bars", 100, f"{end_s}")
        yield f"unequal_bars {end_s * 1e6:g} us", scene, "contact_impulse_n_s", impulse_of_unequal_bars(end_s)
    yield "two_bars 80", open_scene("two_bars", 80, "300e-6"), "contact_impulse_n_s", force * contact


def expected_of(folder):
    """Protocol, step, elements over those of the file and expected error of the run, from the candidates."""
    with open(folder / "advice.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    chosen = json.loads((folder / "summary.json").read_text())
    meshes = [tomllib.loads(path.read_text())["body"][0]["mesh"]["elements"]
              for path in (folder / "scene" / "scene.toml", folder.parent / "scene.toml")]
    column = next(name for name in rows[0] if name.startswith("expected_error/"))
    for row in rows:
        times = float(row["elements_times"])
        if (row["protocol"] == chosen["protocol"] and row[column] and times == meshes[0] / meshes[1]
                and abs(float(row["step_s"]) / chosen["window_size_s"] - 1) < 1e-4):
            return row["protocol"], float(row["step_s"]), times, float(row[column])
    raise RuntimeError(f"{folder}: the run is none of the candidates")


def try_case(build, scene, quantity, asked, meshes):
    """None where the program says that this cannot be had on the mesh."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        accuracy = f"[accuracy]\nrelative_error = {{ {quantity} = {asked} }}\n{meshes}\n"
        (folder / "scene.toml").write_text(f"{scene}\n{accuracy}")
        run = subprocess.run([build / "ricochet", "run", "scene.toml", "--out", "run"], cwd=folder, text=True,
                             capture_output=True)
        if run.returncode == 2 and "no protocol and step" in run.stderr:
            return None
        if run.returncode != 0:
            raise RuntimeError(run.stderr)
        entry = json.loads((folder / "run" / "summary.json").read_text())["error_bar"]["quantities"][quantity]
        bar = entry["total"] / abs(entry["value"]) if entry["total"] is not None else None
        return (*expected_of(folder / "run"), bar, entry["value"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", default=ROOT / "build", type=pathlib.Path)
    parser.add_argument("--only", default="", help="cases with this word in name or quantity")
    parser.add_argument("--meshes", action="store_true", help="the choice may take other meshes, too")
    arguments = parser.parse_args()
    meshes = "elements_times = [1, 2, 4, 8, 16]" if arguments.meshes else ""
    print(f"{'scene':<22} {'result':<26} {'asked':>7} {'expected':>9} {'bar':>9} {'true':>9}  chosen")
    answered = kept = bars = within = refused = 0
    for name, scene, quantity, exact in cases():
        if arguments.only not in name + " " + quantity:
            continue
        for asked in ERRORS:
            found = try_case(arguments.build.resolve(), scene, quantity, asked, meshes)
            if found is None:
                refused += 1
                where = "these meshes" if meshes else "this mesh"
                print(f"{name:<22} {quantity:<26} {100 * asked:>6g}%   not to be had on {where}")
                continue
            protocol, step_s, times, expected, bar, value = found
            true = abs(value / exact - 1.0)
            answered, kept = answered + 1, kept + (true <= asked)
            if bar is not None:
                bars, within = bars + 1, within + (0.5 * true <= bar <= 3.0 * true)
            shown = f"{100 * bar:>8.2g}%" if bar is not None else f"{'unknown':>9}"
            print(f"{name:<22} {quantity:<26} {100 * asked:>6g}% {100 * expected:>8.2g}% {shown} {100 * true:>8.2g}%"
                  f"{'' if true <= asked else ' *'}  {protocol}, {step_s:.3g} s, {times:g} x the elements")
            sys.stdout.flush()
    print(f"{answered} answered, {kept} with a true error within what was asked; {refused} said not to be had; "
          f"{within} of {bars} bars are 0.5 to 3 times the true error")


if __name__ == "__main__":
    main()
