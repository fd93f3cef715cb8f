#!/usr/bin/env bash
# Sets flipflow up on a bare Debian 12 or 13, in .venv beside this checkout.  Run it as often as you
# like: what is there already is left alone.  The Dockerfile, the README and CI all run this file.
set -euo pipefail
cd "$(dirname "$0")/.."

fail() { echo "setup.sh: $*" >&2; exit 1; }
say() { echo "setup.sh: $*"; }

# shellcheck disable=SC1091
. /etc/os-release 2>/dev/null || fail "needs Debian 12 or 13; /etc/os-release is missing"
debian=${VERSION_ID:-}
[ "${ID:-}" = debian ] && [ -f "docker/debian$debian.txt" ] ||
    fail "needs Debian 12 or 13; this is ${PRETTY_NAME:-unknown}"

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
[ "$debian" != 12 ] || packages+=(calculix-ccx)                # a test computes a side plate with it (5 MB)
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
    { "${as_root[@]}" apt-get update -q -o DPkg::Lock::Timeout=600 &&
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -q --no-install-recommends -o DPkg::Lock::Timeout=600 "${missing[@]}"; } >"$log" 2>&1 ||
        fail "apt-get failed: $(grep -m1 '^E:' "$log" || tail -n1 "$log") (whole log: $log)"
    rm -f "$log"
fi

# Debian's own Python: the one that dolfinx and petsc4py belong to.  What else lies in the system's folders must not
# change which program this is, so .venv does not see them; an older one, which did, or of another Debian, is made anew.
modules_of_venv=.venv/lib/$(/usr/bin/python3 -c 'import sys; print("python%d.%d" % sys.version_info[:2])')/site-packages
if [ ! -x .venv/bin/python ] || [ ! -d "$modules_of_venv" ] ||
    grep -q '^include-system-site-packages *= *true' .venv/pyvenv.cfg; then
    say "making the virtual environment .venv"
    /usr/bin/python3 -m venv --clear .venv || fail "cannot make .venv"
fi

# Links to the modules that docker/debian12.txt or debian13.txt names, each distribution with what pip and Python ask of
# it.  There is no RECORD, so pip can neither replace nor remove what belongs to Debian.
links=$(mktemp -d .venv/debian.XXXXXX)
trap 'rm -rf "$links"' EXIT
while read -r pin from modules; do
    name=${pin%%==*} version=${pin#*==}
    files=$(dpkg -L ${from//,/ } 2>/dev/null) || fail "docker/debian$debian.txt: $pin: not installed: ${from//,/ }"
    grep -qE "/[^/]+-${version//./\\.}\.(dist|egg)-info(/|$)" <<<"$files" ||
        fail "docker/debian$debian.txt names $pin, but ${from%%,*} holds another version of it"
    for module in ${modules//,/ }; do
        file=$(grep -m1 -E "/python3/dist-packages/$module(\.py|\.cpython-3[0-9]*-[^/]*\.so)?$" <<<"$files") ||
            fail "docker/debian$debian.txt: ${from//,/ } holds no module $module"
        ln -s "$file" "$links/"
    done
    info="$links/${name//-/_}-$version.dist-info"
    mkdir "$info"
    printf 'Metadata-Version: 2.1\nName: %s\nVersion: %s\n' "$name" "$version" >"$info/METADATA"
    echo debian >"$info/INSTALLER"
    tr , "\n" <<<"$modules" >"$info/top_level.txt"
    echo "${from%%,*}" >"$info/debian-package"
    echo "$pin" >>"$links/pins.txt"
done < <(grep -v '^#' "docker/debian$debian.txt")
if ! diff -rq --no-dereference "$links" .venv/debian >/dev/null 2>&1; then
    chmod 755 "$links"
    rm -rf .venv/debian
    mv "$links" .venv/debian
fi
rm -rf "$links"
# Debian 13's dolfinx imports basix, ffcx and ufl by the system's own paths alone, unless it is told otherwise (pusimp).
printf '%s\n' ../../../debian 'import os; os.environ.setdefault("DOLFINX_ALLOW_USER_SITE_IMPORTS", "1")' \
    >"$modules_of_venv/debian.pth"

# what is compiled, and which modules there are: the editable installation has a list of them
stamp=$({ cat pyproject.toml docker/*.txt CMakeLists.txt adapters/*.h {adapters,orchestrator}/*/kernel/* adapters/particles/bridge/*
    find flipflow orchestrator adapters -name '*.py' | sort; } | sha256sum | cut -d' ' -f1)
if [ "$(cat .venv/flipflow.stamp 2>/dev/null)" != "$stamp" ]; then
    say "installing flipflow and its pinned dependencies into .venv, building what is compiled"
    log=$(mktemp)
    # from the environment, pip hands constraints on to the folder that it builds in, too
    PIP_CONSTRAINT="docker/constraints.txt docker/constraints$debian.txt .venv/debian/pins.txt" \
        .venv/bin/pip install --disable-pip-version-check -q -e '.[test]' >"$log" 2>&1 ||
        fail "pip failed: $(grep -m1 -E 'Could not|No matching|fatal error|Connection|^ERROR' "$log" || tail -n1 "$log") (whole log: $log)"
    rm -f "$log"
    echo "$stamp" >.venv/flipflow.stamp
fi
say "ready: .venv/bin/flipflow --help"
