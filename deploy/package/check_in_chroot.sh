#!/usr/bin/env bash
# Tries tarball, wheel and Debian package in a bare Debian 11 without network, as a user who is not root: from nothing to
# the first pair, every command of README and documentation, the notebook; and the tarball in a root that has nothing
# else, and as on Linux 3.10. Needs root, debootstrap and iproute2. Usage: check_in_chroot.sh DIST VERSION
# Environment: PARALLAX_CHECK_SUITE, another Debian than bullseye; PARALLAX_DEBIAN_MIRROR, an archive that has it.
set -euo pipefail
dist=$(realpath "$1") version=$2 suite=${PARALLAX_CHECK_SUITE:-bullseye}
source=$(realpath "$(dirname "$0")/../..")
# Debian's own archive among those that apt knows (a file of sources may be missing, and others may be listed before it).
mirror=${PARALLAX_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
  | grep -v -e security -e debug | sed -n 1p)}
[ -n "$mirror" ] || { echo "check: apt knows no archive of Debian; name one in PARALLAX_DEBIAN_MIRROR" >&2; exit 1; }
work=$(mktemp -d)
root=$work/debian empty=$work/empty
mkdir -p "$root" "$empty"
chmod 755 "$work"  # The user inside must get in.
leave() {
  for proc in "$root/proc" "$empty/proc"; do ! mountpoint -q "$proc" || umount "$proc"; done
  rm -rf "$work"
}
trap leave EXIT

say() { printf 'check: %s\n' "$*"; }
# in_root ROOT COMMAND...: with neither network nor root; loopback is there.
in_root() {
  local at=$1; shift
  unshare --net bash -c 'ip link set lo up; exec "$@"' - chroot --userspec=1000:1000 "$at" "$@"
}
inside() { in_root "$root" /usr/bin/env -i HOME=/home/user PATH=/usr/bin:/bin bash -ec "cd; $1"; }
seconds() { date +%s.%N; }
since() { awk "BEGIN { printf \"%.0f\", $(seconds) - $1 }"; }
megabytes() { du -m "$1" | cut -f1; }

say "bare $suite in $root"
debootstrap --variant=minbase --include=python3,python3-venv,sudo,xz-utils "$suite" "$root" "$mirror" >"$work/log" 2>&1 \
  || { tail -20 "$work/log"; exit 1; }
say "its C library: $(chroot "$root" ldd --version | sed -n '1s/.* //p'); its Python: $(chroot "$root" python3 --version)"
chroot "$root" useradd --uid 1000 --create-home --shell /bin/bash user
echo 'user ALL=(ALL) NOPASSWD: ALL' > "$root/etc/sudoers.d/user"
mkdir -p "$root/dist" "$root/repository/tests"
cp "$dist"/parallax*"$version"* "$root/dist/"
cp -r "$source"/{README.md,deploy} "$root/repository/"
cp -r "$source/tests/deploy" "$root/repository/tests/"
gcc -shared -fPIC -Os "$source/deploy/package/old_uname.c" -o "$root/repository/deploy/package/old_uname.so"
# What the wheel depends on, and the notebook.
python3 -m pip download --quiet --disable-pip-version-check --only-binary :all: --dest "$root/dist/wheels" \
  --python-version "$(chroot "$root" python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')" \
  --platform manylinux2014_x86_64 --platform manylinux_2_28_x86_64 'numpy>=1.21' 'OpenEXR>=3.3' 'pillow>=9' opencv-python-headless grpcio protobuf
echo '127.0.0.1 localhost' > "$root/etc/hosts"
mount -t proc proc "$root/proc"

readonly TREE=parallax-$version-linux-x86_64
readonly FIRST_PAIR='run quickstart --pairs 1 --rigs 1'
start=$(seconds)
inside "tar -xJf /dist/$TREE.tar.xz; mv $TREE 'else where';
  'else where/bin/parallax' $FIRST_PAIR --out tar-out; 'else where/bin/parallax' verify tar-out"
say "tarball of $(megabytes "$root/dist/$TREE.tar.xz") MB: unpacked, first pair and verified in $(since "$start") s"
inside "old() { python3 /repository/deploy/package/without_new_system_calls.py \"\$@\"; }
  old 'else where/bin/parallax' $FIRST_PAIR --out old-out
  old 'else where/bin/coordinator' init old-tls --host localhost --issue worker pool >/dev/null
  old 'else where/bin/coordinator' init old-tls --renew worker-pool >/dev/null
  cmp \$(find tar-out old-out -name left.png -not -path '*/.parallax/*' | sort)"
say "as on Linux 3.10: the same picture; certificates"

# A root with nothing but the tarball: no C library, no shell.
mkdir -p "$empty"/{proc,tmp,dev}
mount -t proc proc "$empty/proc"
mknod -m 666 "$empty/dev/null" c 1 3
mknod -m 666 "$empty/dev/urandom" c 1 9
chmod 1777 "$empty/tmp"
tar -xJf "$root/dist/$TREE.tar.xz" -C "$empty" --strip-components=1
in_root "$empty" /bin/parallax $FIRST_PAIR --out /tmp/out >/dev/null
cmp "$(find "$root/home/user/tar-out" -name left.png -not -path '*/.parallax/*')" \
  "$(find "$empty/tmp/out" -name left.png -not -path '*/.parallax/*')"
say "in a root without a C library: the same picture"
rm -rf "${empty:?}/lib" "$empty/libexec"

start=$(seconds)
inside "python3 -m venv venv; venv/bin/pip install --quiet --no-index --find-links /dist/wheels \"\$(echo /dist/parallax_stereo-$version-*.whl)[client]\";
  venv/bin/parallax $FIRST_PAIR --out wheel-out; cmp \$(find tar-out wheel-out -name left.png -not -path '*/.parallax/*' | sort)"
say "wheel of $(megabytes "$root"/dist/parallax_stereo-"$version"-*.whl) MB: installed and first pair in $(since "$start") s"

# The trainer, where DIST has it.
if [ -e "$root/dist/parallax-trainer-$version-linux-x86_64.tar.xz" ]; then
  inside "cd 'else where'; tar -xJf /dist/parallax-trainer-$version-linux-x86_64.tar.xz --strip-components=1; bin/trainer --help >/dev/null"
  say "trainer: unpacked over the tarball; starts"
  inside "venv/bin/pip install --quiet --no-index --find-links /dist/wheels \
    /dist/parallax_stereo_trainer-$version-*.whl opencv-python-headless"
  start=$(seconds)
  inside "cd /repository; ln -s /dist ~/dist; export PIP_NO_INDEX=1 PIP_FIND_LINKS=/dist/wheels
    . ~/venv/bin/activate
    python -B tests/deploy/commands_test.py --bin ~/venv/bin --has packages --dist /dist \
      README.md deploy/site/docs/*.md deploy/site/docs/recipes/*.md deploy/site/docs/reference/*.md
    python -B tests/deploy/notebook_test.py deploy/site/docs/notebooks/first_steps.ipynb ~/venv/bin"
  say "the commands of README and documentation, by the wheels: $(since "$start") s"
else
  say "trainer: no package in $dist, not tried; nor were the commands of the documentation"
fi

chroot "$root" dpkg -i "/dist/parallax-stereo_${version}_amd64.deb" >/dev/null
inside "parallax --version; coordinator --version; worker --version; parallax $FIRST_PAIR --out deb-out >/dev/null"
if [ -e "$root/dist/parallax-stereo-trainer_${version}_amd64.deb" ]; then
  chroot "$root" dpkg -i "/dist/parallax-stereo-trainer_${version}_amd64.deb" >/dev/null
  inside "trainer --help >/dev/null; parallax evaluate sgbm --on shipped --out scores >/dev/null"
fi
for program in parallax coordinator worker; do
  for file in bash-completion/completions/$program fish/vendor_completions.d/$program.fish man/man1/$program.1.gz; do
    for share in /usr/share '/home/user/else where/share' /home/user/venv/share; do
      inside "test -s '$share/$file'" || { echo "check: $share/$file is not there" >&2; exit 1; }
    done
  done
  # Debian's zsh looks elsewhere than zsh by itself, whose place the others keep.
  for file in /usr/share/zsh/vendor-completions '/home/user/else where/share/zsh/site-functions' /home/user/venv/share/zsh/site-functions; do
    inside "test -s '$file/_$program'" || { echo "check: $file/_$program is not there" >&2; exit 1; }
  done
done
inside "! grep -n '](' ~/venv/lib/python3*/site-packages/parallax_stereo-*.dist-info/METADATA | grep -v '](https\?:'" \
  || { echo "check: the wheel's description names files that are not beside it" >&2; exit 1; }
# The units name programs that are there, and no user that has to be made: they run as users that systemd makes.
for unit in coordinator worker; do
  file=$root/usr/lib/systemd/system/parallax-$unit.service
  program=$(sed -n 's/^ExecStart=\([^ ]*\).*/\1/p' "$file")
  page=$(sed -n 's|^Documentation=file://||p' "$file")
  inside "test -x '$program'" || { echo "check: $file starts '$program', which is not there" >&2; exit 1; }
  inside "test -r '$page'" || { echo "check: $file names '$page', which is not there" >&2; exit 1; }
  grep -qx 'DynamicUser=yes' "$file" || { echo "check: $file wants a user of its own" >&2; exit 1; }
done
say "Debian package: installed; first pair; its units name programs and pages that are there"
