#!/usr/bin/env bash
# Installs what is needed, checks the format, builds everything (preset `release`, or $PARALLAX_PRESET) and runs all
# tests. Arguments go to ctest: ./tests/run.sh -L unit
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${PARALLAX_PRESET:-release}

step() { printf '\n== %s (%ds)\n' "$*" "$SECONDS"; }

step "set up"
./deploy/setup.sh

step "format"
git ls-files '*.h' '*.cc' | xargs clang-format --dry-run --Werror

step "configure ($preset)"
mkdir -p build
cmake --preset "$preset" >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }

step "build"
# Ninja's own status lines are left out of logs; warnings and errors are shown.
cmake --build --preset "$preset" -- --quiet

step "test"
# Files of unit tests; they are kept when a test fails.
TEST_TMPDIR=$(mktemp -d -t parallax-tests-XXXXXX)
export TEST_TMPDIR
ctest --preset "$preset" --parallel "$(nproc)" "$@" || { echo "files of the tests: $TEST_TMPDIR"; exit 1; }
rm -rf "$TEST_TMPDIR"
step "done"
