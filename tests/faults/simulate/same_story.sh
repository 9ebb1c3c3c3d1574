#!/bin/sh
# same_story.sh FAULTS: the stories of 20 seeds must be the same bytes when the C library takes this processor for one
# of another type, for which it has other routines.
set -eu
tell() {
  "$@" simulate --seeds 1..20 --trace | sed '$d'  # Its last line has times.
}
here=$(tell "$1")
there=$(tell env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX512VL,-ERMS,-BMI2 "$1")
test "$(echo "$here" | wc -l)" -gt 1000
test "$here" = "$there"
