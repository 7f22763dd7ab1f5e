#!/usr/bin/env python3
"""compare_histories.py EXPECTED FOUND: two history.csv of the same scene, computed by different processors.

The largest difference within a column must be at most 1e-9 of the largest value in it. Processors add and multiply in other orders,
and what that does to the last digits grows over the windows of a run; states and counts of contact must be the same in every row.
`contact_residual` is nothing but rounding: there, both must stay below 1e-12.
"""
import csv
import sys

TOLERANCE = 1e-9
SMALL_RESIDUAL = 1e-12


def columns(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return dict(zip(rows[0], zip(*([float(value) for value in row] for row in rows[1:]))))


def main():
    expected, found = (columns(path) for path in sys.argv[1:3])
    if list(expected) != list(found) or len(expected["time_s"]) != len(found["time_s"]):
        sys.exit("compare_histories.py: other columns, or another number of rows")
    worst, where = 0.0, "time_s"
    for name, values in expected.items():
        scale = max(map(abs, values))
        if name == "contact_residual":
            if max(scale, *map(abs, found[name])) > SMALL_RESIDUAL:
                sys.exit(f"compare_histories.py: a contact residual above {SMALL_RESIDUAL:g}")
            continue
        difference = max(abs(a - b) for a, b in zip(values, found[name]))
        if not difference <= TOLERANCE * scale:  # also if it is not a number
            sys.exit(f"compare_histories.py: {name} differs by {difference:g}, and is at most {scale:g}")
        if scale > 0.0 and difference / scale >= worst:
            worst, where = difference / scale, name
    impulses = [max(map(abs, run["contact_impulse_n_s"])) for run in (expected, found)]
    print(f"contact impulse {impulses[0]:.12g} N s and {impulses[1]:.12g} N s, relative difference "
          f"{abs(impulses[1] / impulses[0] - 1.0):.1e}; largest of any column {worst:.1e} ({where}), allowed {TOLERANCE:g}")


if __name__ == "__main__":
    main()
