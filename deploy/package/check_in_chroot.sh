#!/usr/bin/env bash
# Tries tarball, wheel and Debian package in a bare Debian 12 without network, as a user who is not root: from nothing
# to the first pair. Needs root and debootstrap. Usage: check_in_chroot.sh DIST VERSION
set -euo pipefail
dist=$(realpath "$1") version=$2
mirror=${PARALLAX_DEBIAN_MIRROR:-$(sed -n 's/^URIs: *//p; s/^deb \(\[[^]]*\] \)\{0,1\}\([^ ]*\) .*/\2/p' \
  /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | head -1)}
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT

say() { printf 'check: %s\n' "$*"; }
# In the chroot, with neither network nor root: a command line.
inside() { unshare --net chroot --userspec=1000:1000 "$root" /usr/bin/env -i HOME=/home/user PATH=/usr/bin:/bin bash -ec "$1"; }
seconds() { date +%s.%N; }

say "bare Debian 12 in $root"
debootstrap --variant=minbase --include=python3,python3-venv,xz-utils bookworm "$root" "$mirror" >"$root.log" 2>&1 \
  || { tail -20 "$root.log"; exit 1; }
rm -f "$root.log"
mkdir -p "$root/home/user" "$root/dist"
cp "$dist"/parallax*"$version"* "$root/dist/"
chown -R 1000:1000 "$root/home/user"
mount -t proc proc "$root/proc"
trap 'umount "$root/proc"; rm -rf "$root"' EXIT

readonly STUDY='printf "study: one\nseed: 1\npairs: 1\nrigs_per_scene: 1\nvariants: [{name: a, set: {rigs: {count: 1}}}]\n" > one.yaml'
start=$(seconds)
inside "cd; tar -xJf /dist/parallax-$version-linux-x86_64.tar.xz; $STUDY; mv parallax-$version-linux-x86_64 'else where';
  'else where/bin/parallax' run one.yaml --out tar-out; 'else where/bin/parallax' verify tar-out"
say "tarball: unpacked, first pair and verified in $(awk "BEGIN { print $(seconds) - $start }") s"

start=$(seconds)
inside "cd; python3 -m venv venv; venv/bin/pip install --quiet --no-index --no-deps /dist/parallax_stereo-$version-*.whl; $STUDY;
  venv/bin/parallax run one.yaml --out wheel-out; cmp tar-out/a/*/*/left.png wheel-out/a/*/*/left.png"
say "wheel: installed and first pair in $(awk "BEGIN { print $(seconds) - $start }") s"

inside "cd 'else where'; tar -xJf /dist/parallax-trainer-$version-linux-x86_64.tar.xz --strip-components=1; bin/trainer --help >/dev/null"
say "trainer: unpacked over the tarball; starts"

chroot "$root" dpkg -i "/dist/parallax-stereo_${version}_amd64.deb" "/dist/parallax-stereo-trainer_${version}_amd64.deb" >/dev/null
inside "cd; parallax --version; coordinator --version; worker --version; trainer --help >/dev/null"
say "Debian package: installed; its programs start"
