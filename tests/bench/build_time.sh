#!/usr/bin/env bash
# Processor time of first builds without a compiler cache, against what is wanted of them:
#   tests/bench/build_time.sh          the product as `./ricochet run` builds it, then the tests beyond it as `./ricochet test` does
#   tests/bench/build_time.sh --each   the product with each source by itself, to compare
# Takes some minutes; the chart libraries come from npm. Other work on the machine makes the times longer: also these.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
export CCACHE_DISABLE=1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
TIMEFORMAT="%U %S %R"

# measure WHAT WANTED TARGETS...: user and system time of ninja and its children.
measure() {
  local what=$1 wanted=$2 user system wall
  shift 2
  { time ninja -C "$folder/build" --quiet "$@" > "$folder/log" 2>&1; } 2> "$folder/time" || { cat "$folder/log"; exit 1; }
  read -r user system wall < "$folder/time"
  awk -v what="$what" -v wanted="$wanted" -v user="$user" -v system_="$system" -v wall="$wall" 'BEGIN {
    printf "%s: %.0f s of a processor (%.0f user, %.0f system), %.0f s wall%s\n", what, user + system_, user, system_, wall,
      wanted == "" ? "" : ", at most " wanted " s of a processor wanted: " (user + system_ <= wanted ? "kept" : "missed") }'
}

unity=ON
[ "${1:-}" = --each ] && unity=OFF
configure=(cmake -S "$root" -B "$folder/build" -G Ninja -DRICOCHET_NATIVE=ON -DRICOCHET_UNITY="$unity")
"${configure[@]}" -DBUILD_TESTING=OFF > /dev/null
product=(ricochet explicit_solver implicit_solver)
if [ "$unity" = OFF ]; then
  measure "product, each source by itself" "" "${product[@]}"
  exit
fi
measure product 250 "${product[@]}"
"${configure[@]}" -DBUILD_TESTING=ON > /dev/null
measure "tests beyond it" 375
