#!/usr/bin/env bash
# Installs what Parallax needs to build and run on Debian 12: packages, and Intel Open Image Denoise, which
# Debian does not have, from a wheel pinned by version and hash; a real stereo pair with truth that another wheel
# ships (the benchmark `shipped`); and, in virtual environments of their own, an S3 server (moto) for the tests and
# the tools that build the documentation.
# Idempotent: a second run changes nothing.
# Run as root or as a user with sudo.
set -euo pipefail
umask 022  # Others than root use what is installed.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

readonly OIDN_VERSION=2.5.1
readonly OIDN_WHEEL=pyoidn==2.5.1.0
readonly OIDN_SHA256=32ad13368f8de1ef63001942ad05b02a00cd732d1206d97f352d3a3f606d823e
readonly OIDN_ROOT=${PARALLAX_OIDN_ROOT:-/opt/parallax/oidn-$OIDN_VERSION}
readonly SHIPPED_WHEEL=scikit-image==0.16.2
readonly SHIPPED_SHA256=41e28db0136f29ecd305bef0408fdfc64be9d415e54f5099a95555c65f5c1865
readonly SHIPPED_ROOT=${PARALLAX_BENCHMARKS_ROOT:-/opt/parallax/benchmarks}/shipped
S3_TEST_REQUIREMENTS=$(dirname "$0")/s3-test-requirements.txt
readonly S3_TEST_ROOT=${PARALLAX_S3_TEST_ROOT:-/opt/parallax/s3-test}
SITE_REQUIREMENTS=$(dirname "$0")/site/requirements.txt
readonly SITE_ROOT=${PARALLAX_SITE_ROOT:-/opt/parallax/site}
readonly PACKAGES=(
  build-essential cmake ninja-build ccache clang-format pkg-config git ca-certificates unzip python3 python3-numpy python3-opencv python3-pip python3-venv
  libboost-dev libeigen3-dev libembree-dev libfcl-dev libosd-dev libtbb-dev
  libgrpc++-dev libprotobuf-dev protobuf-compiler protobuf-compiler-grpc libabsl-dev libssl-dev libcurl4-openssl-dev
  patchelf musl-tools libopencv-dev libopenexr-dev libpng-dev libjpeg62-turbo-dev libstb-dev libdraco-dev libtinygltf-dev libzstd-dev
  libsqlite3-dev sqlite3 libtorch-dev libspdlog-dev python3-grpcio python3-protobuf libfmt-dev libyaml-cpp-dev libexpat1-dev nlohmann-json3-dev libcli11-dev
  libgtest-dev libgmock-dev zsh fish mandoc
  clang-14 libclang-rt-14-dev
)

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else fail "needs root for: $* (run as root, or install sudo)"; fi
}

install_packages() {
  local missing=()
  for package in "${PACKAGES[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then say "Debian packages: all ${#PACKAGES[@]} present"; return; fi
  say "Debian packages: installing ${missing[*]}"
  as_root apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" \
    >/dev/null
}

install_oidn() {
  if [ -e "$OIDN_ROOT/lib/libOpenImageDenoise_core.so.$OIDN_VERSION" ]; then
    say "Open Image Denoise $OIDN_VERSION: present in $OIDN_ROOT"; return
  fi
  say "Open Image Denoise $OIDN_VERSION: installing into $OIDN_ROOT"
  local tmp=$work/oidn; mkdir "$tmp"
  echo "$OIDN_WHEEL --hash=sha256:$OIDN_SHA256" > "$tmp/requirements.txt"
  python3 -m pip download --quiet --disable-pip-version-check --no-deps --require-hashes --only-binary :all: \
    --dest "$tmp" --requirement "$tmp/requirements.txt"
  unzip -q "$tmp"/pyoidn-*.whl 'pyoidn/oidn/lib/libOpenImageDenoise.so.2' \
    'pyoidn/oidn/lib/libOpenImageDenoise_core.so.*' 'pyoidn/oidn/lib/libOpenImageDenoise_device_cpu.so.*' -d "$tmp"
  as_root mkdir -p "$OIDN_ROOT"
  as_root rm -rf "$OIDN_ROOT/lib.new"
  as_root cp -r "$tmp/pyoidn/oidn/lib" "$OIDN_ROOT/lib.new"
  as_root rm -rf "$OIDN_ROOT/lib"
  as_root mv "$OIDN_ROOT/lib.new" "$OIDN_ROOT/lib"
}

# Middlebury's Motorcycle: two pictures, and the true disparities as numpy stores them (inf = unknown).
install_shipped_pair() {
  if [ -e "$SHIPPED_ROOT/LICENSE" ]; then say "real stereo pair: present in $SHIPPED_ROOT"; return; fi
  say "real stereo pair: installing into $SHIPPED_ROOT"
  local tmp=$work/pair; mkdir "$tmp"
  echo "$SHIPPED_WHEEL --hash=sha256:$SHIPPED_SHA256" > "$tmp/requirements.txt"
  python3 -m pip download --quiet --disable-pip-version-check --no-deps --require-hashes --only-binary :all: \
    --python-version 3.8 --platform manylinux1_x86_64 --dest "$tmp" --requirement "$tmp/requirements.txt"
  unzip -q -j "$tmp"/scikit_image-*.whl 'skimage/data/motorcycle_*' -d "$tmp/pair"
  unzip -q -p "$tmp"/scikit_image-*.whl '*.dist-info/LICENSE.txt' > "$tmp/LICENSE.txt"
  {
    echo "Motorcycle of the Middlebury 2014 stereo datasets (https://vision.middlebury.edu/stereo/data/scenes2014/) at a"
    echo "quarter of its size: D. Scharstein, H. Hirschmueller, Y. Kitajima, G. Krathwohl, N. Nesic, X. Wang, P. Westling:"
    echo "High-resolution stereo datasets with subpixel-accurate ground truth, GCPR 2014. The files are from"
    echo "$SHIPPED_WHEEL, unchanged, which distributes them under this licence:"
    echo
    cat "$tmp/LICENSE.txt"
  } > "$tmp/LICENSE"
  unzip -q "$tmp/pair/motorcycle_disp.npz" arr_0.npy -d "$tmp/pair"
  as_root rm -rf "$SHIPPED_ROOT.new"
  as_root mkdir -p "$SHIPPED_ROOT.new"
  mv "$tmp/pair/arr_0.npy" "$tmp/pair/motorcycle_disp.npy"
  as_root install -m 644 "$tmp/pair/"motorcycle_{left.png,right.png,disp.npy} "$tmp/LICENSE" "$SHIPPED_ROOT.new"
  as_root rm -rf "$SHIPPED_ROOT"
  as_root mv "$SHIPPED_ROOT.new" "$SHIPPED_ROOT"
}

# Python packages in an environment of their own: what they are for, the environment's folder, pinned requirements.
install_venv() {
  local what=$1 root=$2 requirements=$3
  if cmp -s "$requirements" "$root/requirements.txt"; then say "$what: present in $root"; return; fi
  say "$what: installing into $root"
  as_root rm -rf "$root"
  as_root mkdir -p "$root"
  as_root python3 -m venv "$root/venv"
  as_root "$root/venv/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes \
    --only-binary :all: --requirement "$requirements"
  as_root cp "$requirements" "$root/requirements.txt"  # Last: it says that all is there.
}

[ -f /etc/debian_version ] || fail "made for Debian 12; on other systems install the packages listed in this file by hand"
install_packages
install_oidn
install_shipped_pair
install_venv "S3 server for the tests" "$S3_TEST_ROOT" "$S3_TEST_REQUIREMENTS"
install_venv "tools of the documentation" "$SITE_ROOT" "$SITE_REQUIREMENTS"
say "ready"
