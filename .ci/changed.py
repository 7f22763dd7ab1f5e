"""Prints the sources of a compilation database that the last commits may have broken: those that they changed, those that
include a header that they changed, and those that are compiled together with such. Without so long a history, all.
  changed.py DATABASE [--commands]: instead, the command that reads each and compiles nothing."""
import json
import pathlib
import subprocess
import sys

COMMITS = 40

root = pathlib.Path(__file__).resolve().parent.parent
# By a shell, so that a machine without git is one without a history; a clone may belong to somebody else.
changes = subprocess.run(f"git -c safe.directory='*' diff --name-only HEAD~{COMMITS}", shell=True, cwd=root,
                         capture_output=True, text=True)
changed = {str(root / name) for name in changes.stdout.split()}


def broken(file):
    included = {str(root / line.split('"')[1]) for line in open(file) if line.startswith('#include "')}
    return file in changed or included & changed or any(broken(name) for name in included if name.endswith(".cpp"))


commands = {entry["file"]: entry["command"] for entry in json.load(open(sys.argv[1]))}
for file, command in sorted(commands.items()):
    if changes.returncode or broken(file):
        print(f"{command.split(' -o ')[0]} -fsyntax-only {file}" if "--commands" in sys.argv else file)
