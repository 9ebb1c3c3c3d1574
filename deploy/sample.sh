#!/usr/bin/env bash
# Makes the sample of a release: 40 pairs (16 of rooms, 8 of rooms with floating objects, 16 of dense scenes) as one archive of
# files and as WebDataset shards, each as a tar beside its SHA-256.
#   deploy/sample.sh [--bin DIR] [--out DIR] [--pairs N]     # N pairs a variant instead; for a trial
set -euo pipefail
cd "$(dirname "$0")/.."
bin=build/release/bin out=out/sample pairs=''
while [ $# -gt 0 ]; do
  case $1 in
    --bin) bin=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    --pairs) pairs=$2; shift 2 ;;
    *) echo "sample: unknown option $1; there are --bin, --out and --pairs" >&2; exit 2 ;;
  esac
done
mkdir -p "$out"
cat >"$out/sample.yaml" <<'YAML'
study: sample
base: indoor
seed: 2026
pairs: 16
rigs_per_scene: 4
variants:
  - name: rooms
    set: {floating: {count: 0}, rigs: {count: 4}}
  - name: floating
    pairs: 8
    set: {rigs: {count: 4}}
  - name: dense
    base: dense
    set: {rigs: {count: 4}}
YAML
"$bin/parallax" run "$out/sample.yaml" --out "$out/archive" ${pairs:+--pairs "$pairs"}
"$bin/parallax" verify "$out/archive"
rm -rf "$out/webdataset"
"$bin/parallax" export "$out/archive" --layout webdataset --out "$out/webdataset"
version=$("$bin/parallax" --version | grep -oE '[0-9]+\.[0-9]+\.[0-9]+' | head -1)
for kind in archive webdataset; do
  name=parallax-sample-$version-$kind.tar
  # The same bytes from the same files: names in order, no owner and no time.
  tar --create --file "$out/$name" --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 --exclude=.parallax \
    --transform "s,^$kind,parallax-sample-$version," --directory "$out" "$kind"
  (cd "$out" && sha256sum "$name" >"$name.sha256")
  echo "sample: $out/$name ($(du -h "$out/$name" | cut -f1))"
done
