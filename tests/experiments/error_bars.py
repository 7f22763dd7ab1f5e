#!/usr/bin/env python3
"""Compares error bars with true errors where the answer is known exactly: runs scenes of configs/ with
--estimate-error, by several protocols, in steps of several lengths, on meshes of 40 to 320 elements a body.
tests/experiments/error_bars.py [--build DIR] [--only WORD]. One line for each scene and result: how many runs, in how
many the bar holds the true error, in how many it is half to three times that error, and the least, middle and largest
of their ratios. Needs Python 3.11 alone."""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

from accuracy_cases import ROOT, impulse_of_unequal_bars, open_scene

FORCE, CONTACT = 1.33453e5, 98.937e-6  # N and s, of two_bars
STEPS = {"hughes_liu": (0.45, 0.9), "kim": (0.45, 0.9), "all_explicit": (0.45, 0.9),
         "all_implicit": (0.5, 0.9, 1.7, 3.3)}


def scenes():
    """(name, text by elements, step of one element's wave [s] times the elements, exact answers)"""
    bars = {"contact_impulse_n_s": FORCE * CONTACT, "rebound_velocity_left_m_s": -5.13588,
            "separation_time_s": 148.393e-6, "contact_duration_s": CONTACT, "plateau_stress_pa": FORCE / 6.4516e-4,
            "peak_contact_force_n": FORCE}
    yield "two_bars", lambda n: open_scene("two_bars", n, "300e-6"), 4.9468e-5, bars
    yield "rod_on_stop", lambda n: open_scene("rod_on_stop", n, "2.5"), 1.0, {"contact_impulse_n_s": 0.5}
    yield ("rod_on_stop, four impacts", lambda n: open_scene("rod_on_stop", n), 1.0,
           {"contact_impulse_n_s": 2.0, "peak_contact_force_n": 0.5})
    for end_s in (60e-6, 100e-6):
        yield (f"unequal_bars, to {end_s * 1e6:g} us", lambda n, end_s=end_s: open_scene("unequal_bars", n, f"{end_s}"),
               1.9486e-5, {"contact_impulse_n_s": impulse_of_unequal_bars(end_s)})


def estimate(build, text, settings):
    """Quantities of the run with their bars; None where it is refused or unstable."""
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "scene.toml").write_text(text)
        command = [build / "ricochet", "run", "scene.toml", "--out", "run", "--estimate-error"]
        for setting in settings:
            command += ["--set", setting]
        run = subprocess.run(command, cwd=folder, text=True, capture_output=True)
        if run.returncode != 0:
            return None
        return json.loads((pathlib.Path(folder) / "run" / "summary.json").read_text())["error_bar"]["quantities"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", default=ROOT / "build", type=pathlib.Path)
    parser.add_argument("--only", default="", help="scenes with this word in their name")
    parser.add_argument("--elements", nargs="+", default=(40, 80, 160, 320), type=int, help="of a bar")
    arguments = parser.parse_args()
    ratios, failed = {}, 0
    for name, text, unit_s, exact in scenes():
        if arguments.only not in name:
            continue
        for protocol, steps in STEPS.items():
            for factor in steps:
                for elements in arguments.elements:
                    found = estimate(arguments.build.resolve(), text(elements),
                                     [f"coupling.protocol={protocol}", f"time.step_s={factor * unit_s / elements}"])
                    failed += found is None
                    for quantity, answer in exact.items() if found else ():
                        bar = found[quantity]
                        if bar["total"] is not None:
                            error = max(abs(bar["value"] - answer), 1e-300)
                            ratios.setdefault((name, quantity), []).append(bar["total"] / error)
    print(f"{'scene':<26} {'result':<26} {'runs':>4} {'hold':>4} {'0.5 to 3':>8}   least  middle  largest")
    for (name, quantity), of in ratios.items():
        print(f"{name:<26} {quantity:<26} {len(of):>4} {sum(r >= 1 for r in of):>4} "
              f"{sum(0.5 <= r <= 3 for r in of):>8} {min(of):>7.2g} {statistics.median(of):>7.2g} {max(of):>8.2g}")
    all_ratios = [r for of in ratios.values() for r in of]
    print(f"{len(all_ratios)} bars: {sum(r >= 1 for r in all_ratios)} hold, "
          f"{sum(0.5 <= r <= 3 for r in all_ratios)} are 0.5 to 3 times the true error; "
          f"{failed} runs were refused or unstable")


if __name__ == "__main__":
    main()
