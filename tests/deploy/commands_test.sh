#!/usr/bin/env bash
# Runs the commands of README and documentation with the programs of a build.
# Usage: commands_test.sh SOURCE_DIR BIN_DIR
set -euo pipefail
cd "$1"
# Pages that go on in the folder of another one come after it.
exec /usr/bin/python3 -B tests/deploy/commands_test.py --bin "$2" --tree . README.md \
  deploy/site/docs/*.md deploy/site/docs/recipes/*.md deploy/site/docs/reference/*.md
