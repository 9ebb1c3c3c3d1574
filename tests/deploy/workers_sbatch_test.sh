#!/usr/bin/env bash
# Tests which workers deploy/slurm/workers.sbatch starts in different environments. A program that prints its arguments
# and counts signals stands for the worker.
# Usage: workers_sbatch_test.sh SCRIPT
set -euo pipefail
script=$1
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
failed=0
fail() { printf 'FAILED: %s\n' "$*"; failed=1; }

# Waits for SIGTERM when $WAIT is set; counts those that come within half a second.
cat > "$tmp/worker" <<'WORKER'
#!/usr/bin/env bash
printf '%s\n' "$@" > "$OUT/arguments"
env > "$OUT/environment"
if [ -n "${WAIT:-}" ]; then
  signals=0
  trap 'signals=$((signals + 1))' TERM
  echo $$ > "$OUT/pid.new"; mv "$OUT/pid.new" "$OUT/pid"
  while [ "$signals" -eq 0 ]; do sleep 0.02; done
  for _ in 1 2 3 4 5; do sleep 0.1; done
  echo "$signals" > "$OUT/signals"
fi
exit 4
WORKER
chmod +x "$tmp/worker"

# start VARIABLE=VALUE... [-- ARGUMENT...]: runs the script with nothing else in the environment; rc, $OUT/arguments.
start() {
  local variables=()
  while [ $# -gt 0 ] && [ "$1" != -- ]; do variables+=("$1"); shift; done
  if [ $# -gt 0 ]; then shift; fi
  rm -rf "$tmp/out"; mkdir "$tmp/out"
  rc=0
  env -i PATH="$PATH" HOME="$tmp/home" OUT="$tmp/out" PARALLAX_WORKER="$tmp/worker" SLURM_JOB_ID=7 "${variables[@]}" \
    bash "$script" "$@" >"$tmp/out/log" 2>&1 || rc=$?
}
value_of() { awk -v option="$1" 'found { print; exit } $0 == option { found = 1 }' "$tmp/out/arguments" 2>/dev/null || true; }
expect() {  # expect OPTION VALUE: "" means that the option is not given.
  local value; value=$(value_of "$1")
  if [ "$value" != "$2" ]; then fail "$case: $1 is '$value', wanted '$2'"; fi
}

case="no coordinator"
start
if [ "$rc" -eq 0 ] || ! grep -q 'PARALLAX_COORDINATOR: set it' "$tmp/out/log"; then fail "$case: rc $rc"; fi

case="loopback, no certificates"
start PARALLAX_COORDINATOR=127.0.0.1:7070
[ "$rc" -eq 4 ] || fail "$case: rc $rc: $(cat "$tmp/out/log")"
expect --role all
expect --name slurm-7-0
expect --outbox "$tmp/home/.local/state/parallax/slurm-7-0/outbox"
expect --threads ""
expect --memory-mb ""
if grep -q '^PARALLAX_TLS' "$tmp/out/environment"; then fail "$case: PARALLAX_TLS is set"; fi
grep -q '^PARALLAX_COORDINATOR=127.0.0.1:7070$' "$tmp/out/environment" || fail "$case: no coordinator"
expect --exit-when-idle 300
expect --deadline ""
# Slurm kills 30 s after SIGTERM, and 300 s after the signal that announces the end.
[ "$(value_of --long-grace)" -lt 300 ] || fail "$case: long grace $(value_of --long-grace)"
[ "$(value_of --grace)" -lt 30 ] || fail "$case: grace $(value_of --grace)"

case="end of time, by Slurm's variable and by squeue"
start PARALLAX_COORDINATOR=127.0.0.1:7070 SLURM_JOB_END_TIME=1800000000 PARALLAX_IDLE=60
expect --deadline 1800000000
expect --exit-when-idle 60
mkdir "$tmp/path"
printf '#!/bin/sh\necho 2027-01-15T08:00:00\n' > "$tmp/path/squeue"
chmod +x "$tmp/path/squeue"
start PARALLAX_COORDINATOR=127.0.0.1:7070 PATH="$tmp/path:$PATH"
expect --deadline "$(date -d 2027-01-15T08:00:00 +%s)"
printf '#!/bin/sh\nexit 1\n' > "$tmp/path/squeue"
start PARALLAX_COORDINATOR=127.0.0.1:7070 PATH="$tmp/path:$PATH"
[ "$rc" -eq 4 ] || fail "$case: rc $rc"

case="unix socket, empty PARALLAX_TLS"
start PARALLAX_COORDINATOR=unix:/run/c.sock PARALLAX_TLS=
[ "$rc" -eq 4 ] || fail "$case: rc $rc"
if grep -q '^PARALLAX_TLS' "$tmp/out/environment"; then fail "$case: PARALLAX_TLS is set"; fi

case="certificates, array, state folder, arguments"
start PARALLAX_COORDINATOR=farm:7070 PARALLAX_TLS=/tls SLURM_ARRAY_JOB_ID=5 SLURM_ARRAY_TASK_ID=3 \
  PARALLAX_STATE="$tmp/state" SLURM_CPUS_PER_TASK=16 SLURM_MEM_PER_NODE=32768 -- --slots 2
grep -q '^PARALLAX_TLS=/tls$' "$tmp/out/environment" || fail "$case: PARALLAX_TLS is lost"
expect --name slurm-7-3
expect --outbox "$tmp/state/slurm-5-3/outbox"
expect --threads 16
expect --memory-mb 32768
expect --slots 2
[ -d "$tmp/state/slurm-5-3" ] || fail "$case: no state folder"

# Memory and threads: what Slurm sets, and what the worker must be told.
while IFS='|' read -r settings threads memory; do
  case=$settings
  # shellcheck disable=SC2086  # The settings are words.
  start PARALLAX_COORDINATOR=127.0.0.1:7070 $settings
  expect --threads "$threads"
  expect --memory-mb "$memory"
done <<'CASES'
SLURM_MEM_PER_NODE=0||
SLURM_MEM_PER_NODE=4096 SLURM_CPUS_ON_NODE=4|4|4096
SLURM_MEM_PER_CPU=500 SLURM_CPUS_ON_NODE=8|8|4000
SLURM_MEM_PER_CPU=500 SLURM_CPUS_PER_TASK=6|6|3000
SLURM_MEM_PER_CPU=500 SLURM_CPUS_PER_TASK=6 SLURM_CPUS_ON_NODE=8|6|4000
SLURM_MEM_PER_CPU=500||500
SLURM_MEM_PER_NODE=0 SLURM_MEM_PER_CPU=500 SLURM_CPUS_ON_NODE=2|2|1000
CASES

case="one SIGTERM"
rm -rf "$tmp/out"; mkdir "$tmp/out"
env -i PATH="$PATH" HOME="$tmp/home" OUT="$tmp/out" PARALLAX_WORKER="$tmp/worker" SLURM_JOB_ID=7 WAIT=1 \
  PARALLAX_COORDINATOR=127.0.0.1:7070 bash "$script" >"$tmp/out/log" 2>&1 &
started=$!
for _ in $(seq 100); do if [ -f "$tmp/out/pid" ]; then break; fi; sleep 0.05; done
[ "$(cat "$tmp/out/pid")" = "$started" ] || fail "$case: the worker is not the process that Slurm signals"
# Slurm signals script and worker at preemption, if they are two processes.
kill -TERM "$started"
worker=$(cat "$tmp/out/pid")
if [ "$worker" != "$started" ]; then kill -TERM "$worker"; fi
rc=0
wait "$started" || rc=$?
[ "$rc" -eq 4 ] || fail "$case: rc $rc"
[ "$(cat "$tmp/out/signals")" = 1 ] || fail "$case: $(cat "$tmp/out/signals") signals"

if [ "$failed" -eq 0 ]; then echo "workers.sbatch: 16 environments and one signal as wanted"; fi
exit "$failed"
