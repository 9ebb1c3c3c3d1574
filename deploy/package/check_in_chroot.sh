#!/usr/bin/env bash
# Tries tarball, wheel and Debian package in a bare Debian 12 without network, as a user who is not root: from nothing
# to the first pair. Needs root and debootstrap. Usage: check_in_chroot.sh DIST VERSION
set -euo pipefail
dist=$(realpath "$1") version=$2
# Debian's own archive among those that apt knows (a file of sources may be missing, and others may be listed before it).
mirror=${PARALLAX_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
  'Codename: bookworm' | sed -n 1p)}
[ -n "$mirror" ] || { echo "check: apt knows no archive of Debian 12; name one in PARALLAX_DEBIAN_MIRROR" >&2; exit 1; }
root=$(mktemp -d)
chmod 755 "$root"  # The user inside must get in.
trap 'rm -rf "$root"' EXIT

say() { printf 'check: %s\n' "$*"; }
# Runs a command line in the chroot, with neither network nor root.
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

readonly FIRST_PAIR='run quickstart --pairs 1 --rigs 1'
megabytes() { du -m "$1" | cut -f1; }
start=$(seconds)
inside "cd; tar -xJf /dist/parallax-$version-linux-x86_64.tar.xz; mv parallax-$version-linux-x86_64 'else where';
  'else where/bin/parallax' $FIRST_PAIR --out tar-out; 'else where/bin/parallax' verify tar-out"
say "tarball of $(megabytes "$root/dist/parallax-$version-linux-x86_64.tar.xz") MB: unpacked, first pair and verified in \
$(awk "BEGIN { print $(seconds) - $start }") s"

start=$(seconds)
inside "cd; python3 -m venv venv; venv/bin/pip install --quiet --no-index --no-deps /dist/parallax_stereo-$version-*.whl;
  venv/bin/parallax $FIRST_PAIR --out wheel-out; cmp \$(find tar-out wheel-out -name left.png -not -path '*/.parallax/*' | sort)"
say "wheel of $(megabytes "$root"/dist/parallax_stereo-"$version"-*.whl) MB: installed and first pair in \
$(awk "BEGIN { print $(seconds) - $start }") s"

# The trainer, where DIST has it.
trainer=/dist/parallax-trainer-$version-linux-x86_64.tar.xz
if [ -e "$root$trainer" ]; then
  inside "cd; cd 'else where'; tar -xJf $trainer --strip-components=1; bin/trainer --help >/dev/null"
  say "trainer: unpacked over the tarball; starts"
else
  say "trainer: no package in $dist, not tried"
fi

chroot "$root" dpkg -i "/dist/parallax-stereo_${version}_amd64.deb" >/dev/null
inside "cd; parallax --version; coordinator --version; worker --version"
if [ -e "$root/dist/parallax-stereo-trainer_${version}_amd64.deb" ]; then
  chroot "$root" dpkg -i "/dist/parallax-stereo-trainer_${version}_amd64.deb" >/dev/null
  inside "cd; trainer --help >/dev/null"
fi
# The units name programs that are there, and no user that has to be made: they run as users that systemd makes.
for unit in coordinator worker; do
  file=$root/usr/lib/systemd/system/parallax-$unit.service
  program=$(sed -n 's/^ExecStart=\([^ ]*\).*/\1/p' "$file")
  inside "test -x '$program'" || { echo "check: $file starts '$program', which is not there" >&2; exit 1; }
  grep -qx 'DynamicUser=yes' "$file" || { echo "check: $file wants a user of its own" >&2; exit 1; }
done
say "Debian package: installed; its programs start, its units name them"
