#!/usr/bin/env bash
# The alert rules by Prometheus' own tool, with series whose alerts are known; every metric that they name is exported.
# Usage: alerts_test.sh SOURCE_DIR. Status 77: no promtool here (Debian: apt-get install prometheus).
set -euo pipefail
source=$1
rules=$source/deploy/dashboards/alerts.yml
for metric in $(grep -v '^ *#' "$rules" | grep -o 'parallax_[a-z_]*' | sort -u); do
  grep -q "\"${metric#parallax_}\"" "$source/coordinator/http/metrics_text.cc" || { echo "$metric is not exported"; exit 1; }
done
promtool=$(command -v "${PROMTOOL:-promtool}") || { echo "SKIPPED: no promtool; apt-get install prometheus brings it"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$rules" "$source/tests/deploy/alerts_test.yml" "$work"
"$promtool" check rules "$work/alerts.yml"
"$promtool" test rules "$work/alerts_test.yml"
