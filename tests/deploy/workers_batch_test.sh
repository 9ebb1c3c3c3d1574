#!/usr/bin/env bash
# Tests which worker deploy/batch/workers.sh starts under PBS, under LSF and without either.
# Usage: workers_batch_test.sh SCRIPT
set -euo pipefail
script=$1
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
failed=0
fail() { printf 'FAILED: %s\n' "$*"; failed=1; }

cat > "$tmp/worker" <<'WORKER'
#!/usr/bin/env bash
kill -USR2 $$  # LSF's; the worker must outlive it.
echo "$* tls=${PARALLAX_TLS-unset}" > "$OUT"
exit 4
WORKER
chmod +x "$tmp/worker"

# expect STATUS PATTERN VARIABLE=VALUE...: runs the script with nothing else in the environment.
expect() {
  local status=$1 pattern=$2 rc=0; shift 2
  : > "$tmp/out"
  env -i PATH="$PATH" HOME="$tmp/home" OUT="$tmp/out" PARALLAX_WORKER="$tmp/worker" "$@" bash "$script" > "$tmp/log" 2>&1 || rc=$?
  if [ "$rc" -ne "$status" ]; then fail "status $rc, wanted $status: $* $(cat "$tmp/log")"; fi
  grep -qE -- "$pattern" "$tmp/out" "$tmp/log" || fail "no '$pattern': $(cat "$tmp/out" "$tmp/log")"
}
pbs=(PARALLAX_COORDINATOR=farm:7070 PARALLAX_ENGINE=pbs PBS_JOBID=12.head)
expect 1 'PARALLAX_COORDINATOR: set it' PARALLAX_ENGINE=pbs
expect 1 'PARALLAX_ENGINE: set it' PARALLAX_COORDINATOR=farm:7070
expect 4 "^--role all --name pbs-12-0 --outbox $tmp/home/.local/state/parallax/pbs-12-0/outbox --exit-when-idle 300 tls=unset$" \
  "${pbs[@]}" PARALLAX_TLS= PARALLAX_CORES= PARALLAX_ARGUMENTS=
expect 4 "--name pbs-12-3 --outbox $tmp/s/pbs-12-3/outbox --exit-when-idle 60 --threads 16 --memory-mb 500 --grace 7 --slots 2 --verbose tls=/tls$" \
  "${pbs[@]}" PBS_JOBID='12[3].head' PBS_ARRAY_INDEX=3 PARALLAX_IDLE=60 PARALLAX_CORES=16 PARALLAX_MEMORY_MB=500 \
  PARALLAX_GRACE=7 PARALLAX_LONG_GRACE= PARALLAX_ARGUMENTS='--slots 2 --verbose' PARALLAX_TLS=/tls PARALLAX_STATE="$tmp/s"
expect 4 '--name lsf-17-2 .*--long-grace 270 --deadline' PARALLAX_COORDINATOR=farm:7070 PARALLAX_ENGINE=lsf LSB_JOBID=17 \
  LSB_JOBINDEX=2 PARALLAX_LONG_GRACE=270 PARALLAX_WALL_S=600
deadline=$(sed 's/.*--deadline \([0-9]*\).*/\1/' "$tmp/out")
left=$((deadline - $(date +%s)))
if [ "$left" -gt 600 ] || [ "$left" -lt 540 ]; then fail "the deadline is in $left s"; fi
expect 4 '--name mine-[a-zA-Z0-9-]+-[0-9]+-0 ' PARALLAX_COORDINATOR=farm:7070 PARALLAX_ENGINE=mine
# Installed elsewhere than on the machine that submits.
expect 4 '--name pbs-12-0 ' "${pbs[@]}" PARALLAX_WORKER=/nowhere/worker PATH="$tmp:$PATH"

if [ "$failed" -eq 0 ]; then echo "workers.sh: 7 environments as wanted"; fi
exit "$failed"
