#!/usr/bin/env bash
# Makes the Debian package, installs it in a bare Debian 12 without a compiler, and runs the README's first command there:
#   tests/package/bare_machine.sh [BUILD]
# BUILD (build-package unless given) is configured and built for any processor. Needs root, and Debian's mirror.
set -euo pipefail
here=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$here/build-package}
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
[ "$(id -u)" -eq 0 ] || { echo "bare_machine.sh: chroot needs root" >&2; exit 1; }
fail() { echo "bare_machine.sh: $*" >&2; exit 1; }

for tool in debootstrap dpkg-shlibdeps; do
  command -v "$tool" > /dev/null || { apt-get update -qq && apt-get install -y -qq --no-install-recommends debootstrap dpkg-dev; } > /dev/null
done
cmake -S "$here" -B "$build" -G Ninja -DBUILD_TESTING=OFF -DRICOCHET_UNITY=ON -DRICOCHET_NATIVE=OFF > /dev/null
ninja -C "$build" --quiet ricochet explicit_solver implicit_solver reduced_solver
rm -f "$build"/*.deb
(cd "$build" && cpack > cpack.log) || { cat "$build/cpack.log"; exit 1; }
package=$(echo "$build"/*.deb)
grep -q "apt install ./$(basename "$package")" "$here/README.md" || fail "the README names another package than $(basename "$package")"

folder=$(mktemp -d)
root=$folder/root
clean_up() {
  for mounted in proc dev/shm; do ! mountpoint -q "$root/$mounted" || umount "$root/$mounted"; done
  rm -rf --one-file-system "$folder"
}
trap clean_up EXIT
debootstrap --variant=minbase bookworm "$root" "$mirror" > "$folder/log" || { cat "$folder/log"; exit 1; }
mount -t proc proc "$root/proc"
mount -t tmpfs tmpfs "$root/dev/shm"
inside() { chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/bin:/bin:/usr/sbin:/sbin DEBIAN_FRONTEND=noninteractive "$@"; }
cp "$package" "$root/tmp/ricochet.deb"
inside apt install -y -qq --no-install-recommends /tmp/ricochet.deb > "$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
for compiler in cc gcc c++ g++ clang ld node; do
  ! inside which "$compiler" > /dev/null || fail "$compiler came with the package"
done

inside ricochet run /usr/share/ricochet/configs/kim_impact.toml --out /root/impact | tee "$folder/run"
grep -q '^done: 763 windows' "$folder/run" || fail "the run did not end"
separation=$(grep -om1 'separation  *[0-9.]* us' "$here/README.md")
grep -q "$separation" "$folder/run" || fail "another time of separation than the README's"
for file in history.csv axial_stress.csv summary.json trace.json report.html fields/kim_impact.pvd; do
  [ -s "$root/root/impact/$file" ] || fail "no $file"
done
inside ricochet report /root/impact | tee "$folder/report"  # pages without node, pictures with it
grep -q 'no picture files: `node` is not on PATH' "$folder/report" || fail "the report does not say what it lacks"
inside test -s /usr/lib/python3/dist-packages/ricochet/__init__.py || fail "no Python package"
inside test -s /usr/share/doc/ricochet/copyright || fail "no licence"
echo "bare_machine.sh: $(basename "$package"), $(du -k "$package" | cut -f1) kB, installs and runs"
