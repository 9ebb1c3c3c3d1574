#!/usr/bin/env bash
# Fails when a source, test or migration is in the tree but in no CMake file, or when the parts' one-way rule is broken.
# Usage: tests/check_tree.sh [ROOT]
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
failed=0
report() { printf 'tree: %s\n' "$*"; failed=1; }

# Every source is listed in the CMakeLists.txt of its folder or of one above it.
registered() {
  local dir name
  dir=$(dirname "$1"); name=$(basename "$1")
  while [ "$dir" != . ]; do
    if [ -f "$dir/CMakeLists.txt" ] && grep -qwF -- "$name" "$dir/CMakeLists.txt"; then return 0; fi
    dir=$(dirname "$dir")
  done
  return 1
}
while IFS= read -r file; do
  registered "$file" || report "$file is in no CMakeLists.txt"
done < <(find common coordinator worker tests -name '*.cc' -o -name '*.sql' | sort)

# The coordinator's queue, study, rpc and http know nothing of the worker; the worker nothing of the coordinator.
while IFS= read -r line; do report "coordinator includes the worker: $line"; done < <(
  grep -rnE '#include "worker/' coordinator --include='*.h' --include='*.cc' | grep -v '^coordinator/client/' || true)
while IFS= read -r line; do report "worker includes the coordinator: $line"; done < <(
  grep -rnE '#include "coordinator/' worker common --include='*.h' --include='*.cc' || true)
while IFS= read -r line; do report "common includes a part above it: $line"; done < <(
  grep -rnE '#include "(worker|coordinator)/' common --include='*.h' --include='*.cc' || true)

[ "$failed" -eq 0 ] && echo "tree: every source is registered, every include points down"
exit "$failed"
