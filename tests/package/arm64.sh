#!/usr/bin/env bash
# Builds the programs of the package for arm64 on this x86-64, runs the README's first command with them under qemu-user, three
# processes as ever, and compares its history.csv with the one of an x86-64 build for any processor:
#   tests/package/arm64.sh [BUILD [X86_BUILD]]
# BUILD (build-arm64 unless given) gets the libraries of Debian 12 for arm64 in its folder `sysroot`; nothing of another processor
# is installed on this machine. X86_BUILD is build-package unless given. Needs root, and Debian's mirror.
set -euo pipefail
here=$(cd "$(dirname "$0")/../.." && pwd)
build=$(realpath -m "${1:-$here/build-arm64}")
x86_build=$(realpath -m "${2:-$here/build-package}")
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
[ "$(id -u)" -eq 0 ] || { echo "arm64.sh: debootstrap needs root" >&2; exit 1; }
fail() { echo "arm64.sh: $*" >&2; exit 1; }

for tool in debootstrap aarch64-linux-gnu-g++ python3; do
  command -v "$tool" > /dev/null ||
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends debootstrap g++-aarch64-linux-gnu python3; } > /dev/null
done
mkdir -p "$build"

# The libraries are unpacked and not set up, for no program among them is needed. The emulator, too: set up, its package would
# change how this machine starts programs.
sysroot=$build/sysroot
libraries=libc6-dev,libstdc++-12-dev,libeigen3-dev,libsuitesparse-dev,libarpack2-dev,liblapack-dev,libzmq3-dev,cppzmq-dev,libmsgpack-cxx-dev
libraries+=,libtoml11-dev,libcli11-dev,libfmt-dev,libuv1-dev,nlohmann-json3-dev,libssl-dev,libboost-dev
if [ ! -f "$build/sysroot_is_complete" ]; then
  rm -rf --one-file-system "$sysroot"
  debootstrap --foreign --arch=arm64 --variant=minbase --include="$libraries" bookworm "$sysroot" "$mirror" > "$build/log" ||
    { cat "$build/log"; exit 1; }
  for package in "$sysroot"/var/cache/apt/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -x -C "$sysroot" --keep-directory-symlink  # /lib is a link
  done
  for library in blas lapack; do  # what Debian's alternatives would choose
    for link in so so.3; do
      ln -sf "$library/lib$library.$link" "$sysroot/usr/lib/aarch64-linux-gnu/lib$library.$link"
    done
  done
  apt-get update -qq > /dev/null
  (cd "$build" && apt-get download -qq -o APT::Sandbox::User=root qemu-user-static)
  dpkg-deb -x "$build"/qemu-user-static_*.deb "$build/emulator"
  rm "$build"/qemu-user-static_*.deb
  touch "$build/sysroot_is_complete"
fi

cat > "$build/toolchain.cmake" << END
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_SYSROOT $sysroot)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
END
export PKG_CONFIG_SYSROOT_DIR=$sysroot
export PKG_CONFIG_LIBDIR=$sysroot/usr/lib/aarch64-linux-gnu/pkgconfig:$sysroot/usr/share/pkgconfig
programs=(ricochet explicit_solver implicit_solver reduced_solver)
cmake -S "$here" -B "$build/cmake" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$build/toolchain.cmake" -DBUILD_TESTING=OFF -DRICOCHET_UNITY=ON \
  -DRICOCHET_NATIVE=OFF > "$build/log" 2>&1 || { cat "$build/log"; exit 1; }
ninja -C "$build/cmake" --quiet "${programs[@]}"
unset PKG_CONFIG_SYSROOT_DIR PKG_CONFIG_LIBDIR
for program in "${programs[@]}"; do
  [ "$(od -An -t u2 -j 18 -N 2 "$build/cmake/$program")" -eq 183 ] || fail "$program is no program for arm64"  # e_machine of ELF
done
if [ $# -lt 2 ]; then  # a folder that is named holds its programs already
  cmake -S "$here" -B "$x86_build" -G Ninja -DBUILD_TESTING=OFF -DRICOCHET_UNITY=ON -DRICOCHET_NATIVE=OFF > /dev/null
  ninja -C "$x86_build" --quiet "${programs[@]}"
fi

# The coupler starts what lies beside it: there, the solvers are scripts that start the emulator.
emulator="$build/emulator/usr/bin/qemu-aarch64-static -L $sysroot"
rm -rf "$build/emulated"
mkdir -p "$build/emulated"
cp "$build/cmake/ricochet" "$build/emulated"
for solver in explicit_solver implicit_solver; do
  printf '#!/bin/sh\nexec %s %s "$@"\n' "$emulator" "$build/cmake/$solver" > "$build/emulated/$solver"
  chmod +x "$build/emulated/$solver"
done
rm -rf "$build/arm64" "$build/x86-64"
# shellcheck disable=SC2086  # the emulator has arguments
$emulator "$build/emulated/ricochet" run "$here/configs/kim_impact.toml" --out "$build/arm64" | tee "$build/run"
grep -q '^done: 763 windows' "$build/run" || fail "the run did not end"
"$x86_build/ricochet" run "$here/configs/kim_impact.toml" --out "$build/x86-64" > "$build/run" || { cat "$build/run"; exit 1; }

python3 "$here/tests/package/compare_histories.py" "$build/x86-64/history.csv" "$build/arm64/history.csv"
echo "arm64.sh: the programs for arm64 run, and compute what those for x86-64 do"
