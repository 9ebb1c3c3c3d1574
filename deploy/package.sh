#!/usr/bin/env bash
# Makes the files that users install, in dist/: a tarball that runs from any folder, a wheel and a Debian package of the
# same files, and each of these once more for the trainer, whose libraries (Debian's libtorch and what it draws in) are
# larger than all the rest: it is unpacked over the others. Prints each file's size. The programs bring their own C library
# and its loader, so that those of the system don't matter (package/launcher.c): the oldest kernel is their only limit.
#   deploy/package.sh                  build, then package
#   deploy/package.sh --build DIR      package the programs in DIR/bin as they are
#   deploy/package.sh --tree DIR       only collect the files of the programs in DIR; --trainer: with the trainer
#   deploy/package.sh --check          and try them in a bare Debian 11 without network (root, debootstrap)
set -euo pipefail
umask 022  # Whatever is packed can be read by all.
cd "$(dirname "$0")/.."
readonly SOURCE=$PWD
readonly PROGRAMS=(parallax coordinator worker)
readonly ADDED_PROGRAMS=(trainer)
# The C library: its loader, and the parts that libraries from outside ask for (LD_PRELOAD, name services of the system).
readonly LOADER=ld-linux-x86-64.so.2
readonly C_LIBRARY=(ld-linux-x86-64.so.2 libc.so.6 libm.so.6 libmvec.so.1 libdl.so.2 libpthread.so.0 librt.so.1
  libresolv.so.2 libutil.so.1)
# Debian's libtorch asks for them (package/collect_libraries.py): windows, videos, and files of pictures by OpenCV.
readonly UNUSED=('libopencv_highgui.*' 'libopencv_imgcodecs.*' 'libopencv_optflow.*' 'libopencv_video.*' 'libopencv_videoio.*'
  'libopencv_ximgproc.*' 'libav*.so.*' 'libsw*.so.*')
# RHEL 7 has glibc 2.17 and Linux 3.10. pip asks for the system's glibc; the programs bring theirs, and run with the
# system calls of that kernel (package/without_new_system_calls.py).
readonly WHEEL_TAG=manylinux2014_x86_64.manylinux_2_17_x86_64

readonly BENCHMARKS=${PARALLAX_BENCHMARKS_ROOT:-/opt/parallax/benchmarks}

build='' check='' only_tree='' trainer='' out=dist
while [ $# -gt 0 ]; do
  case $1 in
    --build) build=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    --tree) only_tree=$2; shift 2 ;;
    --trainer) trainer=yes; shift ;;
    --check) check=yes; shift ;;
    *) echo "package: unknown option $1; there are --build DIR, --out DIR, --tree DIR, --trainer and --check" >&2; exit 2 ;;
  esac
done

say() { printf 'package: %s\n' "$*"; }
fail() { printf 'package: %s\n' "$*" >&2; exit 1; }
version=$(sed -n 's/^project(parallax VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
[ -n "$version" ] || fail "CMakeLists.txt: no project version"
readonly NAME=parallax-$version-linux-x86_64
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 0)}

build_programs() {
  ./deploy/setup.sh
  mkdir -p build
  cmake --preset release >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
  cmake --build --preset release --target "${PROGRAMS[@]}" "${ADDED_PROGRAMS[@]}"
  build=build/release
}

is_of_c_library() { [[ " ${C_LIBRARY[*]} " == *" $(basename "$1") "* ]]; }

# make_tree TREE PROGRAM...: programs with their libraries, below one folder that can be moved.
make_tree() {
  local tree=$1 oidn; shift
  rm -rf "$tree"
  mkdir -p "$tree"/{bin,libexec,lib,share/doc/parallax,share/parallax}
  musl-gcc -static -Os -s -Wall -Wextra -Werror deploy/package/launcher.c -o "$tree/launcher"
  for program in "$@"; do
    [ -x "$build/bin/$program" ] || fail "$build/bin/$program is not there; build it, or leave out --build"
    cp "$build/bin/$program" "$tree/libexec/"
    cp "$tree/launcher" "$tree/bin/$program"
  done
  rm "$tree/launcher"
  oidn=$(dirname "$(ldd "$build/bin/worker" | awk '/libOpenImageDenoise/ { at = $3 } END { print at }')")
  # Open Image Denoise opens the files of its devices itself.
  python3 -B deploy/package/collect_libraries.py --out "$tree/lib" --system "${C_LIBRARY[@]}" --unused "${UNUSED[@]}" \
    --files "$tree"/libexec/* "$oidn"/libOpenImageDenoise_*.so* > "$tree/libraries"
  cp -L "$oidn"/libOpenImageDenoise_*.so* "$tree/lib/"
  chmod 755 "$tree"/lib/*
  python3 -B deploy/package/drop_weights.py "$(echo "$tree"/lib/libOpenImageDenoise_core.so.*)"
  chmod 755 "$tree"/lib/* "$tree"/libexec/* "$tree"/bin/*
  strip --strip-unneeded "$tree"/libexec/* "$tree"/lib/*
  # RPATH, unlike RUNPATH, comes before the user's LD_LIBRARY_PATH.
  for program in "$tree"/libexec/*; do
    patchelf --set-interpreter /proc/self/fd/241 --force-rpath --set-rpath '$ORIGIN/../lib' "$program"
  done
  for library in "$tree"/lib/*; do patchelf --force-rpath --set-rpath '$ORIGIN' "$library"; done
  for part in "${C_LIBRARY[@]}"; do cp -L "/lib/x86_64-linux-gnu/$part" "$tree/lib/"; done
  chmod 755 "$tree"/lib/*
  third_party_notices "$tree/libraries" > "$tree/share/doc/parallax/THIRD_PARTY"
  rm "$tree/libraries"
}

# add_shared_files TREE KIND: adds the files that the programs need beside libraries.
add_shared_files() {
  cp -r configs "$1/share/parallax/configs"
  /usr/bin/python3 -B deploy/site/make_reference.py config --out "$1/share/parallax/configs/schema"
  rm "$1/share/parallax/configs/schema/config.md"
  mkdir "$1/share/parallax/benchmarks"
  cp -r "$BENCHMARKS/shipped" "$1/share/parallax/benchmarks/shipped"
  installed_as tarball "$1"
  cp -r deploy/systemd deploy/slurm deploy/batch deploy/kubernetes deploy/dashboards deploy/README.md "$1/share/parallax/"
  cp README.md LICENSE CHANGELOG.md "$1/share/doc/parallax/"
  add_completion "$1/share" "${PROGRAMS[@]}"
  chmod -R u+w,go-w,a+rX "$1"  # A clone's files may be for its user alone.
}

# add_completion SHARE PROGRAM...: scripts of the shells and manual pages, from the programs' own tables of options.
add_completion() {
  local share=$1 program; shift
  mkdir -p "$share"/{bash-completion/completions,zsh/site-functions,fish/vendor_completions.d,man/man1}
  for program in "$@"; do
    "$build/bin/$program" completion bash > "$share/bash-completion/completions/$program"
    "$build/bin/$program" completion zsh > "$share/zsh/site-functions/_$program"
    "$build/bin/$program" completion fish > "$share/fish/vendor_completions.d/$program.fish"
    "$build/bin/$program" completion man | gzip -9n > "$share/man/man1/$program.1.gz"
  done
}

# installed_as KIND TREE: the programs name the remedy that fits (common/base/system/installation.h).
installed_as() { echo "$1" > "$2/share/parallax/installed_as"; }

# Leaves of a tree what another one lacks.
remove_what_is_in() {
  local tree=$1 other=$2
  (cd "$tree" && find bin libexec lib -type f) | while read -r file; do
    if [ -e "$other/$file" ]; then rm "$tree/$file"; fi
  done
  mv "$tree/share/doc/parallax/THIRD_PARTY" "$tree/share/doc/parallax/THIRD_PARTY.trainer"
}

# Lists the Debian package of each library, and the file of its licence if Debian has one.
third_party_notices() {
  echo "Libraries in lib/, by the Debian package that they are from. Licences: /usr/share/doc/PACKAGE/copyright there."
  { cat "$1"; echo "/lib/x86_64-linux-gnu/$LOADER"; } | while read -r library; do
    library=$(readlink -f "$library")
    # Files of /lib are registered there, though /lib is a link to /usr/lib.
    dpkg -S "$library" 2>/dev/null || dpkg -S "${library#/usr}" 2>/dev/null || true
  done | awk -F: '{ print $1 }' | sort -u | xargs dpkg-query -W -f '${Package} ${Version}\n'
  echo "Intel Open Image Denoise (Apache 2.0), from its wheel pyoidn"
}

# No program of the tree may need a library that is not in it.
check_tree_is_closed() {
  local tree stray; tree=$(realpath "$1")
  stray=$(for file in "$tree"/libexec/* "$tree"/lib/*.so*; do
      is_of_c_library "$file" || env -i "$tree/lib/$LOADER" --inhibit-cache --list "$file" 2>&1
    done | awk '/not found/ { print $1, "not found" } $3 ~ /^\// { print $3 }' | sort -u | grep -v "^$tree/" || true)
  [ -z "$stray" ] || fail "libraries from outside of the tree: $stray"
}

# make_tarball TREE FILE
make_tarball() {
  tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner -C "$(dirname "$1")" \
    -cf - "$(basename "$1")" | xz -T0 -6 > "$2.new"
  mv "$2.new" "$2"
  made+=("$2")
}

# make_wheel TREE NAME ARGUMENT...
make_wheel() {
  local tree=$1 name=$2; shift 2
  local file; file=$(python3 -B deploy/package/make_wheel.py --tree "$tree" --name "$name" --version "$version" \
    --tag "$WHEEL_TAG" --out "$out" "$@")
  made+=("$file")
}

# make_deb TREE NAME DEPENDS SUMMARY PROGRAM...: DEPENDS is a line of the control file, or empty.
make_deb() {
  local tree=$1 name=$2 depends=$3 summary=$4 root; shift 4; root=$(mktemp -d)
  mkdir -p "$root/DEBIAN" "$root/usr/bin" "$root/usr/lib/parallax" "$root/usr/share/doc"
  chmod 755 "$root"
  cp -r "$tree/bin" "$tree/libexec" "$tree/lib" "$root/usr/lib/parallax/"
  cp -r "$tree/share/doc/parallax" "$root/usr/share/doc/parallax"
  for program in "$@"; do ln -s "../lib/parallax/bin/$program" "$root/usr/bin/$program"; done
  if [ -e "$tree/share/parallax/systemd" ]; then
    for part in parallax bash-completion zsh fish man; do cp -r "$tree/share/$part" "$root/usr/share/$part"; done
    mv "$root/usr/share/zsh/site-functions" "$root/usr/share/zsh/vendor-completions"  # Where Debian's zsh looks.
    ln -s ../../share "$root/usr/lib/parallax/share"
    installed_as deb "$root/usr"
    mkdir -p "$root/usr/lib/systemd/system"
    for unit in "$tree"/share/parallax/systemd/*.service; do
      sed 's|/usr/local/bin/|/usr/bin/|g; s|/usr/share/doc/parallax/deploy/|/usr/share/parallax/|g' "$unit" > "$root/usr/lib/systemd/system/$(basename "$unit")"
    done
  fi
  cat > "$root/DEBIAN/control" <<CONTROL
Package: $name
Version: $version
Architecture: amd64
Maintainer: The Parallax authors <parallax@localhost>
Installed-Size: $(du -sk "$root" | cut -f1)
${depends:+$depends
}Section: science
Priority: optional
Description: $summary
 Parallax invents scenes, photographs them with stereo rigs and writes image pairs with exact disparity,
 trains networks on them and tells which data trains well.
CONTROL
  find "$root" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
  dpkg-deb --root-owner-group -Zxz --build "$root" "$out/${name}_${version}_amd64.deb" >/dev/null
  rm -rf "$root"
  made+=("$out/${name}_${version}_amd64.deb")
}

describe() { say "$1: $(find "$2/lib" -type f | wc -l) libraries, $(du -sm "$2" | cut -f1) MB"; }

main() {
  command -v patchelf musl-gcc >/dev/null || fail "needs patchelf and musl-gcc (deploy/setup.sh installs them)"
  [ -e "$BENCHMARKS/shipped/LICENSE" ] || fail "no real pair in $BENCHMARKS; run deploy/setup.sh"
  [ -n "$build" ] || build_programs
  if [ -n "$only_tree" ]; then
    make_tree "$only_tree" "${PROGRAMS[@]}" ${trainer:+"${ADDED_PROGRAMS[@]}"}
    add_shared_files "$only_tree"
    check_tree_is_closed "$only_tree"
    describe "programs" "$only_tree"
    exit
  fi
  mkdir -p "$out"
  local work tree added made=(); work=$(mktemp -d)
  # shellcheck disable=SC2064  # Expands now: work is local.
  trap "rm -rf '$work'" EXIT
  tree=$work/$NAME added=$work/trainer/$NAME
  make_tree "$tree" "${PROGRAMS[@]}"
  add_shared_files "$tree"
  check_tree_is_closed "$tree"
  describe "programs" "$tree"
  make_tree "$added" "${PROGRAMS[@]}" "${ADDED_PROGRAMS[@]}"
  check_tree_is_closed "$added"
  remove_what_is_in "$added" "$tree"
  describe "trainer" "$added"
  say "runs with any C library of the system, on processors with AVX2"

  make_tarball "$tree" "$out/$NAME.tar.xz"
  make_wheel "$tree" parallax-stereo --data common/python/parallax_data/parallax_data
  make_deb "$tree" parallax-stereo "" "synthetic stereo datasets with exact ground truth" "${PROGRAMS[@]}"
  make_tarball "$added" "$out/parallax-trainer-$version-linux-x86_64.tar.xz"
  make_wheel "$added" parallax-stereo-trainer
  make_deb "$added" parallax-stereo-trainer "Depends: parallax-stereo (= $version)" "the built-in trainer of Parallax" \
    "${ADDED_PROGRAMS[@]}"
  for file in "${made[@]}"; do say "$(du -m "$file" | cut -f1) MB  $file"; done
  if [ -n "$check" ]; then "$SOURCE/deploy/package/check_in_chroot.sh" "$out" "$version"; fi
}
main
