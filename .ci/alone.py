"""Prints, for each source of a compilation database, the command that reads it and compiles nothing."""
import json
import sys

commands = {entry["file"]: entry["command"] for entry in json.load(open(sys.argv[1]))}
for file, command in sorted(commands.items()):
    print(command.split(" -o ")[0], "-fsyntax-only", file)
