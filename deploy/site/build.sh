#!/usr/bin/env bash
# Builds the documentation, with every warning an error. Needs the built programs (for --help), and what
# deploy/setup.sh installs.
#   deploy/site/build.sh [--bin DIR] [--out DIR] [--serve]
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=build/release/bin out=build/site serve=''
while [ $# -gt 0 ]; do
  case $1 in
    --bin) bin=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    --serve) serve=yes; shift ;;
    *) echo "site: unknown option $1; there are --bin, --out and --serve" >&2; exit 2 ;;
  esac
done
readonly VENV=${PARALLAX_SITE_ROOT:-/opt/parallax/site}/venv
[ -x "$VENV/bin/mkdocs" ] || { echo "site: no mkdocs in $VENV; run deploy/setup.sh" >&2; exit 1; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r deploy/site/docs deploy/site/mkdocs.yml "$work/"
# What a fence's first line says beside its language is for tests/deploy/commands_test.py.
find "$work/docs" -name '*.md' -exec sed -i -E 's/^( *```[a-z]+) .*/\1/' {} +
mkdir -p "$work/docs/images"
cp deploy/images/* "$work/docs/images/"
/usr/bin/python3 -B deploy/site/make_reference.py config --out "$work/docs/reference"
/usr/bin/python3 -B deploy/site/make_reference.py commands --bin "$bin" --out "$work/docs/reference"
/usr/bin/python3 -B deploy/site/notebook_page.py "$work/docs/notebooks/first_steps.ipynb" "$work/docs/notebooks/first_steps.md"
if [ -n "$serve" ]; then "$VENV/bin/mkdocs" serve --config-file "$work/mkdocs.yml"; exit; fi
"$VENV/bin/mkdocs" build --quiet --strict --config-file "$work/mkdocs.yml" --site-dir "$(realpath -m "$out")"
echo "site: $out/index.html"
