#!/usr/bin/env bash
# Makes the virtual environment (about 600 MB) that the tests Croissant.*, HuggingFace.* and ParallaxData.ReadsTheSameWith* want; they
# are skipped without it. Run as a user who may write to the folder, or with another one:
#   PARALLAX_PYTHON_TEST_ROOT=DIR setup_python.sh && cmake -DPARALLAX_PYTHON_TEST_ROOT=DIR --preset release
set -euo pipefail
requirements=$(dirname "$0")/python-requirements.txt
root=${PARALLAX_PYTHON_TEST_ROOT:-/opt/parallax/python-test}
if cmp -s "$requirements" "$root/requirements.txt"; then echo "present in $root"; exit 0; fi
rm -rf "$root"
mkdir -p "$root"
python3 -m venv "$root/venv"
"$root/venv/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: --no-binary jsonpath-rw \
  --requirement "$requirements"
cp "$requirements" "$root/requirements.txt"  # Last: it says that all is there.
echo "made in $root"
