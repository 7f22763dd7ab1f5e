"""What programs that draw scenes by lot share: their options, a scene for each number, and what they print."""
import argparse
import pathlib
import random
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def draw(about, name, scene, verdicts):
    """Writes NAME_SEED_NUMBER.toml from `scene(lot)`, each number with a lot of its own. `verdicts(ricochet, path)`
    yields (protocol, whether this is a run, what is wrong): an empty text if nothing is, None if it was refused. What
    only all runs of a scene together tell is no run. Exits with 1 if anything was wrong."""
    options = argparse.ArgumentParser(description=about)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--count", type=int, default=100)
    options.add_argument("--keep", type=pathlib.Path, help="folder that scenes and results stay in")
    options = options.parse_args()
    runs = refused = wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        keep = options.keep or pathlib.Path(folder)
        keep.mkdir(parents=True, exist_ok=True)
        for number in range(options.count):
            path = keep / f"{name}_{options.seed}_{number}.toml"
            path.write_text(scene(random.Random(f"{options.seed} {number}")))
            for protocol, is_run, said in verdicts(options.build / "ricochet", path):
                runs += is_run
                refused += said is None
                if said:
                    wrong += 1
                    print(f"! {path.name}, {protocol}: {said}", flush=True)
    print(f"{runs} runs, {refused} refused, {wrong} wrong")
    sys.exit(1 if wrong else 0)
