#!/usr/bin/env bash
# Sets flipflow up on a bare Debian 12, in .venv beside this checkout.  Run it as often as you
# like: what is there already is left alone.  The Dockerfile, the README and CI all run this file.
set -euo pipefail
cd "$(dirname "$0")/.."

fail() { echo "setup.sh: $*" >&2; exit 1; }
say() { echo "setup.sh: $*"; }

# shellcheck disable=SC1091
. /etc/os-release 2>/dev/null || fail "needs Debian 12 (bookworm); /etc/os-release is missing"
[ "${ID:-}" = debian ] && [ "${VERSION_ID:-}" = 12 ] ||
    fail "needs Debian 12 (bookworm); this is ${PRETTY_NAME:-unknown}"

packages=(
    python3-venv python3-dev g++ git ca-certificates          # Python, and compilers for what is in C++ and for the forms
    libopenmpi-dev openmpi-bin python3-mpi4py                  # MPI
    python3-dolfinx libopenblas0-serial                        # panels; OpenBLAS is 4 times faster in MUMPS
    liggghts libliggghts-dev                                   # particles
    python3-h5py python3-h5py-mpi                              # results
    libegl1 libgl1 libxrender1                                 # off-screen pictures
    libglu1-mesa libxft2 libxinerama1 libxcursor1 libfontconfig1  # gmsh loads them, with or without a screen
    chromium-headless-shell                                    # tests look at reports in a browser (96 MB)
)
missing=()
for package in "${packages[@]}"; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] ||
        missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
    say "installing Debian packages: ${missing[*]}"
    as_root=()
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || fail "needs root or sudo to install: ${missing[*]}"
        as_root=(sudo)
    fi
    log=$(mktemp)
    { "${as_root[@]}" apt-get update -q &&
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -q --no-install-recommends "${missing[@]}"; } >"$log" 2>&1 ||
        fail "apt-get failed: $(grep -m1 '^E:' "$log" || tail -n1 "$log") (whole log: $log)"
    rm -f "$log"
fi

# Debian's own python3.11: the one that dolfinx and petsc4py belong to
if [ ! -x .venv/bin/python ]; then
    say "making the virtual environment .venv"
    /usr/bin/python3 -m venv --system-site-packages .venv || fail "cannot make .venv"
fi

stamp=$(cat pyproject.toml docker/constraints.txt CMakeLists.txt adapters/panel/kernel/* adapters/particles/bridge/* | sha256sum | cut -d' ' -f1)
if [ "$(cat .venv/flipflow.stamp 2>/dev/null)" != "$stamp" ]; then
    say "installing flipflow and its pinned dependencies into .venv, building what is compiled"
    log=$(mktemp)
    .venv/bin/pip install --disable-pip-version-check -q -c docker/constraints.txt -e '.[test]' >"$log" 2>&1 ||
        fail "pip failed: $(grep -m1 -E 'Could not|No matching|fatal error|Connection|^ERROR' "$log" || tail -n1 "$log") (whole log: $log)"
    rm -f "$log"
    echo "$stamp" >.venv/flipflow.stamp
fi
say "ready: .venv/bin/flipflow --help"
