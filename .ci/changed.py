"""Prints the sources of a compilation database that the last commits may have broken: those whose code they changed, those that
include a header with such a change, and those that are compiled together with such. Comments are no code. Without so long a
history, all.
  changed.py DATABASE [--commands]: instead, the command that reads each and compiles nothing."""
import json
import pathlib
import re
import subprocess
import sys

COMMITS = 25

root = pathlib.Path(__file__).resolve().parent.parent
# By a shell, so that a machine without git is one without a history; a clone may belong to somebody else.
changes = subprocess.run(f"git -c safe.directory='*' diff -U0 --no-renames HEAD~{COMMITS} -- '*.?pp' '*.h'", shell=True, cwd=root,
                         capture_output=True, text=True, errors="replace")


def code(hunk, sign):
    return "".join(re.sub(r"(^|\s+)//.*", "", line[1:]) for line in hunk.split("\n") if line.startswith(sign))


def changed_files(diff):
    for of_file in re.split(r"^diff --git ", diff, flags=re.M)[1:]:
        head, *hunks = of_file.split("\n@@")
        if any(code(hunk, "+") != code(hunk, "-") for hunk in hunks):
            yield str(root / head.split("\n")[0].split(" b/")[-1])


changed = set(changed_files(changes.stdout))


def broken(file):
    included = {str(root / line.split('"')[1]) for line in open(file) if line.startswith('#include "')}
    return file in changed or included & changed or any(broken(name) for name in included if name.endswith(".cpp"))


commands = {entry["file"]: entry["command"] for entry in json.load(open(sys.argv[1]))}
for file, command in sorted(commands.items()):
    if changes.returncode or broken(file):
        print(f"{command.split(' -o ')[0]} -fsyntax-only {file}" if "--commands" in sys.argv else file)
