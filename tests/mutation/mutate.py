#!/usr/bin/env python3
"""mutate.py [--list] [--only N,M] [--scratch DIR]: do the tests notice when one line of the program is wrong?

Copies the tree to a scratch folder, applies one mutation of mutations.toml at a time, builds what is needed, runs its
tests until one fails, and puts the line back. Prints the mutations that survive. README.md says more.
"""
import argparse
import csv
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
TREE = HERE.parent.parent
COLUMNS = ["result", "by", "seconds", "file", "find", "replace"]


class Wrong(Exception):
    """Something about the list or the tree, not about a mutation."""


class Mutation:
    def __init__(self, number, area, entry):
        self.number, self.area = number, area["name"]
        self.file, self.find, self.replace = entry[:3]
        self.stages = entry[3:] + area["stages"]  # its own first, then those of the area

    def key(self):
        return (self.file, self.find, self.replace)

    def __str__(self):
        return f"{self.number}: {self.file}: {self.find}  ->  {self.replace}"


def read_list():
    with open(HERE / "mutations.toml", "rb") as file:
        areas = tomllib.load(file)["area"]
    pairs = [(area, entry) for area in areas for entry in area["mutations"]]
    mutations = [Mutation(i + 1, area, entry) for i, (area, entry) in enumerate(pairs)]
    for mutation in mutations:
        path = TREE / mutation.file
        count = path.read_text().count(mutation.find) if path.is_file() else 0
        if count != 1 or "\n" in mutation.find or mutation.find == mutation.replace:
            raise Wrong(f"mutations.toml, {mutation}\n  its fragment stands {count} times in the file; it must stand "
                        "there once, in one line, and change")
    if len({mutation.key() for mutation in mutations}) < len(mutations):
        raise Wrong("mutations.toml: one mutation stands there twice")
    return mutations


def results_path(folder):
    return folder / "build" / "mutations.csv"


def read_results(folder):
    """The last row of each mutation."""
    if not results_path(folder).exists():
        return {}
    with open(results_path(folder), newline="") as file:
        return {(row["file"], row["find"], row["replace"]): row for row in csv.DictReader(file)}


class Scratch:
    """A copy of the tree with a build folder of its own, and what has been found out so far."""

    def __init__(self, folder):
        self.folder, self.build = folder, folder / "build"
        self.passing_path = self.build / "passing.txt"
        self.copy_tree()
        flags = os.environ.get("RICOCHET_CMAKE_FLAGS", "").split()
        self.command(["cmake", "-S", folder, "-B", self.build, "-G", "Ninja", "-DBUILD_TESTING=ON", *flags], "cmake")
        self.passing = set(self.passing_path.read_text().split()) if self.passing_path.exists() else set()

    def copy_tree(self):
        listed = subprocess.run(["git", "-C", TREE, "ls-files", "-co", "--exclude-standard", "-z"], check=True,
                                stdout=subprocess.PIPE, text=True).stdout
        for name in filter(None, listed.split("\0")):
            source, target = TREE / name, self.folder / name
            if not source.is_file() or (target.is_file() and target.read_bytes() == source.read_bytes()):
                continue  # an unchanged file keeps its time, so that nothing of it is built again
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)

    def command(self, arguments, what):
        done = subprocess.run(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            raise Wrong(f"{what} failed in {self.folder}:\n{done.stdout[-3000:]}")

    def builds(self, stage):
        arguments = ["ninja", "-C", self.build, "-j", "1", stage.split()[0]]
        return subprocess.run(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def results(self):
        return read_results(self.folder)

    def add_result(self, mutation, result, by, seconds):
        fresh = not results_path(self.folder).exists()
        with open(results_path(self.folder), "a", newline="") as file:
            writer = csv.writer(file)
            if fresh:
                writer.writerow(COLUMNS)
            writer.writerow([result, by, f"{seconds:.0f}", *mutation.key()])

    def write(self, mutation, text):
        (self.folder / mutation.file).write_text(text)

    def first_failure(self, program, names, excluded, timeout_s):
        """Name of the first test that fails, crashes or hangs; None if all pass. `names`: a --gtest_filter."""
        log_path = self.build / "mutation.log"
        negative = (":" if "-" in names else "-") + ":".join(excluded) if excluded else ""
        arguments = [self.build / program, "--gtest_fail_fast", f"--gtest_filter={names}{negative}"]
        with open(log_path, "w") as log:
            process = subprocess.Popen(arguments, stdout=log, stderr=subprocess.STDOUT, cwd=self.build,
                                       start_new_session=True)
            try:
                code = process.wait(timeout_s)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                code = process.wait()
        text = log_path.read_text(errors="replace")
        failed = re.search(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", text, re.M)
        if code == 0 and not failed:
            return None
        began = re.findall(r"^\[ RUN      \] (\S+)", text, re.M)
        return failed.group(1) if failed else began[-1] if began else "start"

    def noticed_by(self, stage, timeout_s):
        """Name of a test that fails twice, so that no race has done it; None if there is none."""
        program, names = (stage.split() + ["*"])[:2]
        excluded = []
        while failed := self.first_failure(program, names, excluded, timeout_s):
            if failed == "start" or self.first_failure(program, failed, [], timeout_s):
                return failed
            excluded.append(failed)
        return None

    def passes_unmutated(self, stage, test):
        """Whether the test passes on the tree as it is: only then has it noticed anything."""
        if test in self.passing:
            return True
        program = stage.split()[0]
        if not self.builds(program) or self.first_failure(program, "*" if test == "start" else test, [], 900.0):
            return False
        self.passing.add(test)
        self.passing_path.write_text("\n".join(sorted(self.passing)) + "\n")
        return True


def try_out(scratch, mutation, timeout_s):
    """(result, test): killed, survived, or why nothing can be said."""
    original = (TREE / mutation.file).read_text()
    skipped = []
    for stage in mutation.stages:
        scratch.write(mutation, original.replace(mutation.find, mutation.replace))
        try:
            if not scratch.builds(stage):
                return "does not build", stage
            failed = scratch.noticed_by(stage, timeout_s)
        finally:
            scratch.write(mutation, original)
        if failed and scratch.passes_unmutated(stage, failed):
            return "killed", failed
        if failed:
            skipped.append(failed)  # it fails without the mutation, too
    return ("survived", "") if not skipped else ("unclear", " ".join(skipped))


def summary(mutations, results):
    rows = [results[m.key()] for m in mutations if m.key() in results]
    killed = sum(row["result"] == "killed" for row in rows)
    share = f", {100.0 * killed / len(rows):.1f} %" if rows else ""
    return f"{len(rows)} of {len(mutations)} mutations tried, {killed} killed{share}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--list", action="store_true", help="print the mutations and what is known of them")
    parser.add_argument("--only", help="numbers, separated by commas: try these again")
    parser.add_argument("--scratch", type=pathlib.Path, default=TREE / "build-mutation", help="folder of the copy")
    parser.add_argument("--timeout", type=float, default=600.0, help="longest time of one test program [s]")
    options = parser.parse_args()
    mutations = read_list()
    folder = options.scratch.resolve()
    if options.list:
        known = read_results(folder)
        for mutation in mutations:
            row = known.get(mutation.key())
            print(f"{mutation}" + (f"  [{row['result']} {row['by']}]" if row else ""))
        return 0
    only = {int(n) for n in options.only.split(",")} if options.only else None
    if only and not only <= {mutation.number for mutation in mutations}:
        raise Wrong(f"--only: found {options.only}; allowed are numbers from 1 to {len(mutations)}")
    folder.mkdir(parents=True, exist_ok=True)
    scratch = Scratch(folder)
    for mutation in mutations:
        if mutation.number not in only if only else mutation.key() in scratch.results():
            continue
        begin = time.monotonic()
        result, by = try_out(scratch, mutation, options.timeout)
        scratch.add_result(mutation, result, by, time.monotonic() - begin)
        print(f"{result}{' by ' if by else ''}{by}  {mutation}", flush=True)
    results = scratch.results()
    left = [m for m in mutations if m.key() in results and results[m.key()]["result"] != "killed"]
    print("\nNot killed:" if left else "")
    for mutation in left:
        print(f"  {results[mutation.key()]['result']} {results[mutation.key()]['by']}  {mutation}")
    print(summary(mutations, results))
    return 1 if left else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Wrong as wrong:
        sys.exit(f"mutate.py: {wrong}")
