#!/usr/bin/env python3
"""What a backward cone would save: tests/experiments/backward_cone.py SCENE... A row x away from a contact is computed
once a wave has reached it, for t >= x/c, with c = sqrt(E/rho). A run that is asked for forces of the contact alone could
leave it out after t = T - x/c, when nothing of it comes back before the end T. Prints for each structured body of a
contact the share of rows that are computed, and how many of these the second cone leaves out. Needs Python 3.11 alone."""
import math
import sys
import tomllib

CELLS = 400


def shares(length_m, speed_m_s, end_s):
    """Rows that a wave has reached, of all; and of these, those from where none comes back."""
    reached = useless = 0
    for i in range(CELLS):
        away_s = length_m / speed_m_s * (i + 0.5) / CELLS
        for j in range(CELLS):
            time_s = end_s * (j + 0.5) / CELLS
            reached += away_s <= time_s
            useless += end_s - away_s < time_s and away_s <= time_s
    return reached / CELLS**2, useless / reached


def main():
    for path in sys.argv[1:]:
        with open(path, "rb") as file:
            scene = tomllib.load(file)
        for body in scene["body"]:
            if "length_m" not in body["mesh"]:
                continue
            speed_m_s = math.sqrt(body["material"]["youngs_modulus_pa"] / body["material"]["density_kg_m3"])
            reached, useless = shares(body["mesh"]["length_m"], speed_m_s, scene["time"]["end_s"])
            print(f"{path.split('/')[-1]} {body['name']} reached {100 * reached:.0f} % useless {100 * useless:.0f} %")


if __name__ == "__main__":
    main()
