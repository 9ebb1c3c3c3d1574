#!/usr/bin/env bash
# A pilot under PBS, LSF or another batch system: one worker, which `parallax farm` submits and which talks to its
# coordinator. What the variables are filled with, says the engine's file (configs/engines).
#
# PARALLAX_ENGINE, PARALLAX_COORDINATOR, PARALLAX_TLS, PARALLAX_IDLE, PARALLAX_CORES, PARALLAX_MEMORY_MB, PARALLAX_WALL_S,
# PARALLAX_GRACE, PARALLAX_LONG_GRACE, PARALLAX_ARGUMENTS    by `parallax farm`; an empty one is as an absent one
# PARALLAX_WORKER       the program, by `parallax farm`; without it, or if it is not here: worker, on the path
# PARALLAX_STATE        folder on a disk that outlives the job (default: ~/.local/state/parallax)
#
# The worker takes this script's place, so each signal reaches it once. SIGUSR1: it takes nothing new and finishes what runs.
# SIGTERM: it finishes what ends within PARALLAX_GRACE and hands back the rest.
# Exit status 0: nothing left to do; 4: work was handed back, which is no failure.
set -euo pipefail

export PARALLAX_COORDINATOR=${PARALLAX_COORDINATOR:?set it to HOST:PORT of the coordinator}
if [ -z "${PARALLAX_TLS:-}" ]; then unset PARALLAX_TLS; fi
# Another batch system's variables are added here.
job=${PBS_JOBID:-${LSB_JOBID:-$(hostname -s)-$$}}
task=${PBS_ARRAY_INDEX:-${LSB_JOBINDEX:-0}}
name=${PARALLAX_ENGINE:?set it to the name of the engine}-${job%%[.[]*}-$task
# A job that is queued again finds the reports that its predecessor could not send.
state=${PARALLAX_STATE:-$HOME/.local/state/parallax}/$name
mkdir -p "$state"

arguments=(--role all --name "$name" --outbox "$state/outbox" --exit-when-idle "${PARALLAX_IDLE:-300}")
add() { if [ -n "$2" ]; then arguments+=("$1" "$2"); fi; }
add --threads "${PARALLAX_CORES:-}"
add --memory-mb "${PARALLAX_MEMORY_MB:-}"
add --grace "${PARALLAX_GRACE:-}"
add --long-grace "${PARALLAX_LONG_GRACE:-}"
if [ -n "${PARALLAX_WALL_S:-}" ]; then add --deadline $(($(date +%s) + PARALLAX_WALL_S)); fi
read -ra more <<< "${PARALLAX_ARGUMENTS:-}"

# LSF sends it at the end of the time limit, before SIGTERM.
trap '' USR2
worker=${PARALLAX_WORKER:-worker}
if ! command -v "$worker" > /dev/null; then
  echo "no program $worker here: starts worker" >&2
  worker=worker
fi
exec "$worker" "${arguments[@]}" "${more[@]}"
