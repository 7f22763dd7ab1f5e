#!/usr/bin/env bash
# Builds the fuzz targets and runs each on its seeds: tests/fuzz/run.sh [SECONDS_PER_TARGET [RUNS [NUMBER]]], 60 seconds if not
# said otherwise; RUNS ends a target that has tried so many inputs before; runs of the same NUMBER try the same inputs one after
# another, 0 (the default) is another one every time. RICOCHET_FUZZ_TARGETS names those to run, if not all.
# RICOCHET_FUZZ_SANITIZE=OFF leaves the sanitizers out, for some ten times as many inputs; a run with them begins with what it kept.
# One line per target; exit code 1 if one has a finding, with the file that repeats it.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-60} runs=${2:--1} number=${3:-0}
read -ra targets <<< "${RICOCHET_FUZZ_TARGETS:-wire session mesh scene study state manifest}"

build=build-fuzz sanitize=${RICOCHET_FUZZ_SANITIZE:-ON}
[ "$sanitize" = ON ] || build=build-fuzz-plain
cmake -S . -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++-14 -DCMAKE_BUILD_TYPE=Debug -DBUILD_TESTING=OFF -DRICOCHET_FUZZ=ON -DRICOCHET_FUZZ_SANITIZE="$sanitize" \
  -DRICOCHET_UNITY=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON > /dev/null  # clang cannot read the headers that GCC compiled
ninja -C "$build" --quiet "${targets[@]/#/fuzz_}"

# Inputs that find new code are kept in the build folder for the next time, findings beside them.
fuzz() {
  local target=$1 found=build-fuzz/found options=(-rss_limit_mb=1024 -timeout=25 -print_final_stats=1)
  local inputs=$found/$target log=$found/$target.log
  mkdir -p "$inputs"
  [ ! -f "tests/fuzz/$target.dict" ] || options+=("-dict=tests/fuzz/$target.dict")
  local verdict="no finding"
  ASAN_OPTIONS=malloc_context_size=4:quarantine_size_mb=16 "$build/fuzz_$target" "${options[@]}" \
    "-max_total_time=$seconds" "-runs=$runs" "-seed=$number" "-artifact_prefix=$found/$target-" "$inputs" "tests/fuzz/seeds/$target" \
    > "$log" 2>&1 || verdict="FOUND: $build/fuzz_$target $(sed -n 's/.*Test unit written to //p' "$log" | head -n 1), see $log"
  figure() { sed -n "s/^stat::$1: *//p" "$log"; }
  printf '%-10s %10s inputs %8s a second, %6s kept for new code: %s\n' "$target" "$(figure number_of_executed_units)" \
    "$(figure average_exec_per_sec)" "$(figure new_units_added)" "$verdict"
  [ "$verdict" = "no finding" ]
}

# Two at once, for the two processors of a small machine.
export -f fuzz
export seconds runs number build
printf '%s\0' "${targets[@]}" | xargs -0 -n 1 -P 2 bash -c 'fuzz "$1" || exit 255' fuzz || exit 1
