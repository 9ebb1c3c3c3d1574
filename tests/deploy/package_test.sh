#!/usr/bin/env bash
# The files that deploy/package.sh collects run from any folder, with nothing from the system: libraries, C library, data.
# Usage: package_test.sh SOURCE_DIR BUILD_DIR
set -euo pipefail
source=$1 build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$*"; exit 1; }

# Whatever the packer's umask is, others can read what is packed.
(umask 077; "$source/deploy/package.sh" --build "$build" --tree "$work/made")
[ -z "$(find "$work/made" ! -perm -o=r)" ] || fail "others can't read: $(find "$work/made" ! -perm -o=r | head -3)"
tree="$work/else where"
mv "$work/made" "$tree"

# By their path, by a link, by the name alone.
mkdir "$work/links"
for program in parallax worker coordinator; do
  ln -s "$tree/bin/$program" "$work/links/$program"
  for way in "$tree/bin/$program" "$work/links/$program"; do
    [[ $(env -i "$way" --version) == "$program "* ]] || fail "$way --version says something else"
  done
  [[ $(env -i PATH="$work/links" "$program" --version) == "$program "* ]] || fail "$program is not found by its name"
done
cd "$work"

# Shells and man find what the packed programs say of themselves.
for program in parallax worker coordinator; do
  cmp <("$tree/bin/$program" completion bash) "$tree/share/bash-completion/completions/$program"
  cmp <("$tree/bin/$program" completion zsh) "$tree/share/zsh/site-functions/_$program"
  cmp <("$tree/bin/$program" completion fish) "$tree/share/fish/vendor_completions.d/$program.fish"
  cmp <("$tree/bin/$program" completion man) <(zcat "$tree/share/man/man1/$program.1.gz")
done

# Editors find the schemas of studies, scenes and lands.
for name in study scene biome; do
  grep -q "\"Parallax $name\"" "$tree/share/parallax/configs/schema/$name.schema.json" || fail "no schema of a $name"
done

# The libraries that the programs really open are those that were packed, the C library among them. The loader, which is
# the packed one, knows itself by the name under which the kernel opened it.
env -i LD_DEBUG=libs LD_DEBUG_OUTPUT="$work/opened" "$tree/bin/worker" --version >/dev/null
if grep -h 'calling init: ' "$work"/opened.* | grep -v -e "$tree/" -e '/proc/self/fd/241$'; then fail "libraries from outside, above"; fi
for library in libembree libc.so.6; do
  grep -qh "calling init: $tree/libexec/../lib/$library" "$work"/opened.* || fail "the packed $library was not opened"
done

# The user's libraries are for the user's programs: ours don't open them, and our children get the variable. A process has
# the name of its program, and none of our files open.
mkdir "$work/hostile"
cp "$source/README.md" "$work/hostile/libembree3.so.3"
cat > "$work/look.sh" <<'LOOK'
env > "$0.environment"
read -r _ _ _ above _ < /proc/$PPID/stat  # The parent is the shell that runs the command line.
cat "/proc/$above/comm" > "$0.parent"
ls -l /proc/self/fd > "$0.files"
exit 1
LOOK
LD_LIBRARY_PATH=$work/hostile "$tree/bin/parallax" evaluate --on shipped --out scores --command "sh $work/look.sh {list}" \
  >evaluate.log 2>&1 || true
[ -e look.sh.environment ] || { cat evaluate.log; fail "the command of a user's network did not run"; }
grep -qx "LD_LIBRARY_PATH=$work/hostile" look.sh.environment || fail "a child lost the user's LD_LIBRARY_PATH"
grep -qx parallax look.sh.parent || fail "the process is called $(cat look.sh.parent), not parallax"
if grep "$tree" look.sh.files; then fail "a child has our files open, above"; fi

# What is missing is named, with the remedy for a tarball.
printf 'PK\003\004' > net.pt
said=$("$tree/bin/parallax" evaluate net.pt --on shipped --out scores 2>&1) && fail "evaluated without a trainer"
[[ $said == *"no $tree/bin/trainer; unpack its tarball: tar -xf parallax-trainer-"*"-C '$tree' "* ]] || fail "says: $said"
rm -r "$tree/share/parallax/benchmarks"
said=$("$tree/bin/parallax" evaluate sgbm --on shipped --out scores 2>&1) && fail "evaluated on a pair that is not there"
[[ $said == *"$tree/share/parallax/benchmarks/shipped: missing; install Parallax again"* ]] || fail "says: $said"
