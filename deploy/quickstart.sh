#!/usr/bin/env bash
# From a fresh clone to a first dataset: installs what is needed, builds the programs and runs the study `quickstart`
# (2 scenes x 4 stereo pairs at 1280x720) with the coordinator and its workers in one command.
# The dataset goes to out/quickstart, or to the folder given as argument.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/quickstart}

step() { printf '\n== %s\n' "$*"; }

step "set up"
./deploy/setup.sh

step "build (minutes the first time)"
mkdir -p build
cmake --preset release >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
cmake --build --preset release --target parallax worker coordinator trainer -- --quiet

step "make a dataset in $out"
exec build/release/bin/parallax run quickstart --out "$out"
