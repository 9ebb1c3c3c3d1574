#!/usr/bin/env bash
# Builds the fuzzers, or runs one of them from its kept corpus.
#   tests/fuzz/run.sh --build
#   tests/fuzz/run.sh NAME [SECONDS]     NAME: calibration, config, http, list, mesh, picture, recipe, sets, study; 60 seconds
# What it finds stands in build/fuzz/found-NAME; new inputs that reach new code in build/fuzz/corpus-NAME (copy the
# few that matter to tests/fuzz/corpus/NAME: run with -merge=1).
set -euo pipefail
cd "$(dirname "$0")/../.."

if [ "${1:?--build or a name}" = --build ]; then
  mkdir -p build
  cmake --preset fuzz >build/configure-fuzz.log 2>&1 || { cat build/configure-fuzz.log; exit 1; }
  exec cmake --build build/fuzz --target fuzzers -- --quiet
fi

name=$1
seconds=${2:-60}
mkdir -p "build/fuzz/corpus-$name" "build/fuzz/found-$name"
more=()
if [ "$name" = config ]; then more=(configs/*/); fi
# Limits an input's memory and time too: a small file must not stop a coordinator or a worker.
exec build/fuzz/bin/fuzz_"$name" "build/fuzz/corpus-$name" "tests/fuzz/corpus/$name" "${more[@]}" \
  -max_total_time="$seconds" -artifact_prefix="build/fuzz/found-$name/" \
  -timeout=20 -rss_limit_mb=3000 -max_len=20000 -print_final_stats=1 -verbosity=1
