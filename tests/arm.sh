#!/usr/bin/env bash
# Portable runs on ARM64, under emulation: every shipped system, and one with every function, must have the bits
# that it has here. Debian with qemu-user is needed, and half a GiB; it takes some ten minutes.
#
#     tests/arm.sh [FOLDER]        what is downloaded and written goes there (a temporary one otherwise)
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=${1:-$(mktemp -d)}
mkdir -p "$work"/{state/lists/partial,cache/archives/partial,debs,system,site,runs}
cd "$work"

# A Python for ARM64, unpacked and not installed.
version=3.11
arm=(-o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State="$work/state" -o Dir::Cache="$work/cache"
     -o Dir::State::status=/dev/null)
apt-get "${arm[@]}" update -qq
(cd debs && apt-get "${arm[@]}" download -qq "python$version-minimal" "libpython$version-minimal" \
  "libpython$version-stdlib" libc6 libgcc-s1 libstdc++6 zlib1g libexpat1 libffi8 libssl3 libbz2-1.0 liblzma5 libuuid1)
for package in debs/*.deb; do dpkg-deb -x "$package" system; done

# What lagrange needs of the libraries, for both.
python3 -m venv tools
tools/bin/pip install -q "$root"
platforms=()
for glibc in 2014 _2_17 _2_27 _2_28; do platforms+=(--platform "manylinux${glibc}_aarch64"); done
tools/bin/pip freeze --exclude lagrange-cli > versions
tools/bin/pip download -q --no-deps --only-binary=:all: "${platforms[@]}" --python-version "$version" \
  -d wheels -r versions
for wheel in wheels/*.whl; do python3 -m zipfile -e "$wheel" site; done

emulated() {
  local libraries=$work/system/usr/lib/aarch64-linux-gnu:$work/system/lib/aarch64-linux-gnu
  qemu-aarch64 -L "$work/system" -E LD_LIBRARY_PATH="$libraries" -E PYTHONPATH="$work/site:$root" \
    -E PYTHONDONTWRITEBYTECODE=1 "$work/system/usr/bin/python$version" "$@"
}

cd "$root"
digests=(-m tests.support.portable_digests "$work/runs" here "")
"$work/tools/bin/python" "${digests[@]}" | tail -n 1 > "$work/here.json"
emulated "${digests[@]}" | tail -n 1 > "$work/there.json"
cmp "$work/here.json" "$work/there.json"
echo "the same bits on $(uname -m) and on $(emulated -c 'import platform; print(platform.machine())')"
