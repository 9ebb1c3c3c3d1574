#!/usr/bin/env bash
# Makes what users install, in dist/: a tarball that runs from any folder on any glibc that is new enough, a wheel
# and a Debian package of the same files, and each of these once more for the trainer, whose libraries (Debian's libtorch
# and what it draws in) are larger than all the rest: it is unpacked over the others. Prints each file's size and the
# oldest glibc that the programs run on.
#   deploy/package.sh                  build, then package
#   deploy/package.sh --build DIR      package the programs in DIR/bin as they are
#   deploy/package.sh --tree DIR       only collect the files of the programs without trainer in DIR
#   deploy/package.sh --check          and try tarball and wheel in a bare Debian without network (root, debootstrap)
set -euo pipefail
cd "$(dirname "$0")/.."
readonly SOURCE=$PWD
readonly PROGRAMS=(parallax coordinator worker)
readonly ADDED_PROGRAMS=(trainer)
# Libraries of the system: the C library and its loader. The package brings all others, the C++ library too.
readonly SYSTEM='^(ld-linux-x86-64|libc|libm|libdl|libpthread|librt|libresolv|libutil|libanl|libnsl)\.so'

build='' check='' only_tree='' out=dist
while [ $# -gt 0 ]; do
  case $1 in
    --build) build=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    --tree) only_tree=$2; shift 2 ;;
    --check) check=yes; shift ;;
    *) echo "package: unknown option $1; there are --build DIR, --out DIR, --tree DIR and --check" >&2; exit 2 ;;
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

# The libraries that a file needs and the system does not have, with those that they need.
closure_of() {
  ldd "$@" | awk '$3 ~ /^\// { name = $3; sub(/.*\//, "", name); if (!seen[name]++) print $3 }' \
    | while read -r library; do
        [[ $(basename "$library") =~ $SYSTEM ]] || echo "$library"
      done
}

# make_tree TREE PROGRAM...: programs with their libraries, below one folder that can be moved.
make_tree() {
  local tree=$1 oidn; shift
  rm -rf "$tree"
  mkdir -p "$tree/bin" "$tree/lib" "$tree/share/doc/parallax" "$tree/share/parallax"
  for program in "$@"; do
    [ -x "$build/bin/$program" ] || fail "$build/bin/$program is not there; build it, or leave out --build"
    cp "$build/bin/$program" "$tree/bin/"
  done
  oidn=$(dirname "$(ldd "$build/bin/worker" | awk '/libOpenImageDenoise/ { at = $3 } END { print at }')")
  # Open Image Denoise opens the files of its devices itself.
  closure_of "$tree"/bin/* "$oidn"/libOpenImageDenoise_*.so* | xargs cp -L -t "$tree/lib"
  cp -L "$oidn"/libOpenImageDenoise_*.so* "$tree/lib/"
  chmod 755 "$tree"/lib/* "$tree"/bin/*
  strip --strip-unneeded "$tree"/bin/* "$tree"/lib/*
  for program in "$tree"/bin/*; do patchelf --set-rpath '$ORIGIN/../lib' "$program"; done
  for library in "$tree"/lib/*; do patchelf --set-rpath '$ORIGIN' "$library"; done
  third_party_notices "$@" > "$tree/share/doc/parallax/THIRD_PARTY"
}

# Adds the files that the programs need beside libraries.
add_shared_files() {
  cp -r configs "$1/share/parallax/configs"
  cp -r deploy/systemd deploy/slurm deploy/kubernetes deploy/dashboards deploy/README.md "$1/share/parallax/"
  cp README.md LICENSE CHANGELOG.md "$1/share/doc/parallax/"
}

# Leaves of a tree what another one lacks.
remove_what_is_in() {
  local tree=$1 other=$2
  (cd "$tree" && find bin lib -type f) | while read -r file; do
    if [ -e "$other/$file" ]; then rm "$tree/$file"; fi
  done
  mv "$tree/share/doc/parallax/THIRD_PARTY" "$tree/share/doc/parallax/THIRD_PARTY.trainer"
}

# Lists the Debian package of each library, and the file of its licence if Debian has one.
third_party_notices() {
  echo "Libraries in lib/, by the Debian package that they are from. Licences: /usr/share/doc/PACKAGE/copyright there."
  closure_of "${@/#/$build/bin/}" | while read -r library; do
    library=$(readlink -f "$library")
    # Files of /lib are registered there, though /lib is a link to /usr/lib.
    dpkg -S "$library" 2>/dev/null || dpkg -S "${library#/usr}" 2>/dev/null || true
  done | awk -F: '{ print $1 }' | sort -u | xargs dpkg-query -W -f '${Package} ${Version}\n'
  echo "Intel Open Image Denoise (Apache 2.0), from its wheel pyoidn"
}

# The newest version of the C library's symbols that any file asks for.
oldest_glibc() {
  find "$1/bin" "$1/lib" -type f -print0 | xargs -0 objdump -T 2>/dev/null \
    | sed -n 's/.*(\{0,1\}GLIBC_\([0-9.]*\))\{0,1\}.*/\1/p' | sort -Vu | tail -1
}

# No program of the tree may need a library that is neither in it nor the system's.
check_tree_is_closed() {
  local tree; tree=$(realpath "$1")
  local stray
  stray=$(env -i PATH="$PATH" ldd "$tree"/bin/* "$tree"/lib/* 2>&1 \
    | awk '/not found/ { print $1, "not found" } $3 ~ /^\// { print $3 }' | sort -u \
    | while read -r library rest; do
        case $library in "$tree"/*) continue ;; esac
        [[ $(basename "$library") =~ $SYSTEM ]] || echo "$library $rest"
      done)
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
    --glibc "$glibc" --out "$out" "$@")
  made+=("$file")
}

# make_deb TREE NAME DEPENDENCIES SUMMARY PROGRAM...
make_deb() {
  local tree=$1 name=$2 depends=$3 summary=$4 root; shift 4; root=$(mktemp -d)
  mkdir -p "$root/DEBIAN" "$root/usr/bin" "$root/usr/lib/parallax" "$root/usr/share/doc"
  chmod 755 "$root"
  cp -r "$tree/bin" "$tree/lib" "$root/usr/lib/parallax/"
  cp -r "$tree/share/doc/parallax" "$root/usr/share/doc/parallax"
  for program in "$@"; do ln -s "../lib/parallax/bin/$program" "$root/usr/bin/$program"; done
  if [ -e "$tree/share/parallax/systemd" ]; then
    cp -r "$tree/share/parallax" "$root/usr/share/parallax"
    mkdir -p "$root/usr/lib/systemd/system"
    for unit in "$tree"/share/parallax/systemd/*.service; do
      sed 's|/usr/local/bin/|/usr/bin/|g' "$unit" > "$root/usr/lib/systemd/system/$(basename "$unit")"
    done
  fi
  cat > "$root/DEBIAN/control" <<CONTROL
Package: $name
Version: $version
Architecture: amd64
Maintainer: The Parallax authors <parallax@localhost>
Installed-Size: $(du -sk "$root" | cut -f1)
Depends: $depends
Section: science
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
  command -v patchelf >/dev/null || fail "needs patchelf (Debian: apt-get install patchelf)"
  [ -n "$build" ] || build_programs
  if [ -n "$only_tree" ]; then
    make_tree "$only_tree" "${PROGRAMS[@]}"
    add_shared_files "$only_tree"
    check_tree_is_closed "$only_tree"
    describe "programs" "$only_tree"
    exit
  fi
  mkdir -p "$out"
  local work tree added glibc made=(); work=$(mktemp -d)
  # shellcheck disable=SC2064  # Expands now: work is local.
  trap "rm -rf '$work'" EXIT
  tree=$work/$NAME added=$work/trainer/$NAME
  make_tree "$tree" "${PROGRAMS[@]}"
  add_shared_files "$tree"
  check_tree_is_closed "$tree"
  describe "programs" "$tree"
  make_tree "$added" "${PROGRAMS[@]}" "${ADDED_PROGRAMS[@]}"
  check_tree_is_closed "$added"
  glibc=$(oldest_glibc "$added")
  remove_what_is_in "$added" "$tree"
  describe "trainer" "$added"
  say "runs on glibc $glibc and later, on processors with AVX2"

  make_tarball "$tree" "$out/$NAME.tar.xz"
  make_wheel "$tree" parallax-stereo --data common/python/parallax_data/parallax_data
  make_deb "$tree" parallax-stereo "libc6 (>= $glibc)" "synthetic stereo datasets with exact ground truth" "${PROGRAMS[@]}"
  make_tarball "$added" "$out/parallax-trainer-$version-linux-x86_64.tar.xz"
  make_wheel "$added" parallax-stereo-trainer
  make_deb "$added" parallax-stereo-trainer "parallax-stereo (= $version)" "the built-in trainer of Parallax" \
    "${ADDED_PROGRAMS[@]}"
  for file in "${made[@]}"; do say "$(du -m "$file" | cut -f1) MB  $file"; done
  if [ -n "$check" ]; then "$SOURCE/deploy/package/check_in_chroot.sh" "$out" "$version"; fi
}
main
