#!/usr/bin/env bash
# Processor and wall time of a first build of what `./ricochet run` needs, without a compiler cache: each source by itself, and
# the sources of a room together (RICOCHET_UNITY), as `./ricochet` builds. Takes some minutes; the chart libraries come from npm.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
export CCACHE_DISABLE=1
for unity in OFF ON; do
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  cmake -S "$root" -B "$folder" -G Ninja -DBUILD_TESTING=OFF -DRICOCHET_NATIVE=ON -DRICOCHET_UNITY=$unity > /dev/null
  TIMEFORMAT="RICOCHET_UNITY=$unity: %U s + %S s of a processor, %R s wall"
  time ninja -C "$folder" --quiet ricochet explicit_solver implicit_solver
  rm -rf "$folder"
done
