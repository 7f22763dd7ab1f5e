#!/usr/bin/env bash
# Set-up of all_implicit with each BLAS that the machine has: two blocks of N x N x N hexahedra that meet, default N = 26 (118 000 unknowns).
#   tests/bench/blas.sh [N]
# Debian: libblas3 is the reference, libopenblas0-serial and libopenblas0-pthread are OpenBLAS. Needs ./ricochet run to have built.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${RICOCHET_BUILD_DIR:-$root/build}
n=${1:-26}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{
  echo 'model = "solid"'
  for start in -0.02 0.0; do
    echo '[[body]]'
    [ "$start" = 0.0 ] && echo 'name = "second"' || printf 'name = "first"\ninitial_velocity_m_s = [0.0, 0.0, 5.0]\n'
    echo 'material = "steel_a36"'
    echo "mesh = { start_m = $start, length_m = 0.02, height_m = 0.02, width_m = 0.02, elements = [$n, $n, $n] }"
  done
  printf '[contact]\nsurfaces = ["first.end", "second.start"]\n[time]\nstep_s = 1e-7\nend_s = 5e-7\n[coupling]\nprotocol = "all_implicit"\n'
} > "$folder/scene.toml"
for library in /usr/lib/*-linux-gnu/{blas,openblas-serial,openblas-pthread}; do
  [ -e "$library/libblas.so.3" ] || continue
  LD_LIBRARY_PATH=$library "$build/ricochet" run "$folder/scene.toml" --out "$folder/out" > "$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
  python3 - "$folder/out/summary.json" << 'END'
import json, sys
s = json.load(open(sys.argv[1]))
print(f"set-up {s['phases']['setup_s']:.1f} s, stepping {s['phases']['stepping_s']:.2f} s, peak force {s['peak_contact_force_n']:.12g} N: {s['blas']}")
END
done
