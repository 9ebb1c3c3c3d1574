#!/usr/bin/env bash
# The files that deploy/package.sh collects run from any folder, with nothing but the C library from the system.
# Usage: package_test.sh SOURCE_DIR BUILD_DIR
set -euo pipefail
source=$1 build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$source/deploy/package.sh" --build "$build" --tree "$work/made"
mv "$work/made" "$work/else where"
cd "$work/else where"

for program in parallax worker coordinator; do
  said=$(env -i "bin/$program" --version)
  [ -n "$said" ] || { echo "$program --version says nothing"; exit 1; }
done
# The libraries that the programs really open are those that were packed.
env -i LD_DEBUG=libs LD_DEBUG_OUTPUT="$work/opened" bin/worker --version >/dev/null
if grep -h 'calling init: ' "$work"/opened.* | grep -v -e "$work/else where/" \
    -e '/lib\(c\|m\|dl\|pthread\|rt\|resolv\)\.so' -e '/ld-linux'; then
  echo "libraries from outside, above"; exit 1
fi
grep -qh "calling init: $work/else where/bin/../lib/libembree" "$work"/opened.* || { echo "no packed library was opened"; exit 1; }
