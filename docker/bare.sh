#!/usr/bin/env bash
# Runs commands on a bare Debian 12 or 13, made for them and taken away after them:
#
#   sudo bash docker/bare.sh                               the README's two commands (this is what CI does)
#   sudo bash docker/bare.sh --debian 13 'bash docker/setup.sh && .venv/bin/flipflow --version' ...
#
# Without --debian it is Debian 12.  The tree is what a container from debian:12 or debian:13 is (debootstrap's minbase),
# in mount and process namespaces of its own, with a clone of this checkout's last commit, the variables that the
# Dockerfile sets, and no others.  So this is how the Dockerfile is tried out where there is no container engine.  Of the
# host it has the processors, the network, and what apt and pip need to get through: Debian's mirror, proxies,
# certificates, pip's settings and the folders they name.
#
# Exit code: that of the first command that fails, 0 if none does; 125 if no tree can be made here, with the reason,
# and nothing was run.  The tree is in TMPDIR or /var/tmp (5 GB while the tests run).
set -euo pipefail
checkout=$(cd "$(dirname "$0")/.." && pwd)

debian=12
if [ "${1:-}" = --debian ]; then
    debian=${2:-}
    shift $(($# < 2 ? $# : 2))
fi
case $debian in
    12) codename=bookworm ;;
    13) codename=trixie ;;
    *) echo "bare.sh: --debian takes 12 or 13, not '$debian'" >&2 && exit 2 ;;
esac

cannot() { echo "bare.sh: cannot make a bare Debian $debian here: $*" >&2; exit 125; }
say() { echo "bare.sh: $*"; }

commands=("$@")
if [ $# = 0 ]; then # the lines of the README that set up and do something
    mapfile -t commands < <(grep '^bash docker/setup.sh && ' "$checkout/README.md")
fi

[ "$(id -u)" = 0 ] || cannot "that needs root"
command -v apt-get >/dev/null || cannot "the host has no apt-get to say where Debian is"
unshare --mount --pid --fork --kill-child true 2>/dev/null || cannot "this root may not make namespaces (unshare)"
if ! command -v debootstrap >/dev/null; then
    say "installing debootstrap"
    wait_for_apt=(-q -o DPkg::Lock::Timeout=600)
    { apt-get update "${wait_for_apt[@]}" && DEBIAN_FRONTEND=noninteractive \
        apt-get install -y --no-install-recommends "${wait_for_apt[@]}" debootstrap; } >/dev/null 2>&1 ||
        cannot "debootstrap is missing, and apt-get does not install it"
fi

# The place: whoever is killed leaves it behind without its lock, and the next one takes it away.  Nothing is ever
# mounted in it but in a namespace that ends with its processes, so removing it reaches nothing else.
places="${TMPDIR:-/var/tmp}/flipflow-bare"
for place in "$places".*; do
    [ ! -e "$place/lock" ] || ! flock -n "$place/lock" true || rm -rf --one-file-system "$place"
done
place=$(mktemp -d "$places.XXXXXX")
tree="$place/tree"
exec 9>"$place/lock"
flock 9
inside=
leave() {
    trap '' INT TERM HUP
    if [ -n "$inside" ]; then # its children are killed with it
        kill -KILL "$inside" 2>/dev/null || true
        wait "$inside" 2>/dev/null || true
    fi
    rm -rf --one-file-system "$place" 2>/dev/null || { sleep 2 && rm -rf --one-file-system "$place"; }
}
trap leave EXIT
trap 'exit 129' HUP
trap 'exit 130' INT
trap 'exit 143' TERM

# Runs a command and waits for it, in a way that Ctrl-C interrupts.
run() {
    "$@" &
    inside=$!
    local status=0
    wait "$inside" || status=$?
    inside=
    return $status
}

# Debian's sources of the host, which may be another Debian than the tree
host=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
sources=$(apt-get indextargets --format 'deb $(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian' 2>/dev/null |
    sed "s#/ # #; s# ${host:-none}# $codename#" | grep -E " $codename(-updates|-security)? " | sort -u || true)
mirror=$(awk -v codename="$codename" '$3 == codename { print $2; exit }' <<<"$sources")
proxy=$(apt-config shell value Acquire::http::Proxy | sed "s/^value='\(.*\)'$/\1/")
say "making a bare Debian $debian in $place"
run env ${proxy:+http_proxy="$proxy"} unshare --mount --pid --fork --kill-child --mount-proc \
    debootstrap --variant=minbase "$codename" "$tree" \
    "${mirror:-http://deb.debian.org/debian}" >"$place/log" 2>&1 ||
    cannot "debootstrap failed: $(tail -n1 "$place/log")"

# What apt, pip and git need to get through; of the host's sources Debian's own alone
[ -z "$sources" ] || echo "$sources" >"$tree/etc/apt/sources.list"
cp -a /etc/apt/auth.conf /etc/apt/auth.conf.d "$tree/etc/apt/" 2>/dev/null || true
apt-config dump | grep '^Acquire::' >"$tree/etc/apt/apt.conf.d/90host" || true
cp -L /etc/resolv.conf /etc/hosts "$tree/etc/"
mkdir -p "$tree/usr/local/share/ca-certificates"
cp -a /usr/local/share/ca-certificates/. "$tree/usr/local/share/ca-certificates/" 2>/dev/null || true
for file in /etc/pip.conf ~/.config/pip/pip.conf ~/.pip/pip.conf; do
    [ ! -f "$file" ] || { mkdir -p "$tree$(dirname "${file/#$HOME//root}")" && cp "$file" "$tree${file/#$HOME//root}"; }
done
variables=(HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin TERM="${TERM:-dumb}")
while IFS= read -r variable; do
    variables+=("$variable")
done < <(sed -n 's/^ENV //p' "$checkout/docker/Dockerfile" | tr ' ' '\n')
while IFS= read -r variable; do
    variables+=("$variable")
done < <(env | grep -iE '^(PIP_|https?_proxy=|no_proxy=|all_proxy=|SSL_CERT_|REQUESTS_CA_|CURL_CA_)')
for file in /etc/ssl/certs/ca-certificates.crt "${variables[@]#*=}"; do
    [ ! -f "$file" ] || { mkdir -p "$tree$(dirname "$file")" && cp -L "$file" "$tree$file"; }
done
folders=() # of packages, which pip's settings name (an index has its files beside simple/); read-only in the tree
while IFS= read -r folder; do
    [ ! -d "$folder" ] || folders+=("$folder")
done < <({ cat /etc/pip.conf ~/.config/pip/pip.conf ~/.pip/pip.conf 2>/dev/null; env | grep '^PIP_' | cut -d= -f2-; } |
    tr ' =' '\n\n' | sed -n 's#^file://##; s#/simple/*$##; /^\//p' | sort -u)

git clone -q --no-hardlinks "$checkout" "$tree/flipflow" || cannot "git cannot clone $checkout"
[ -z "$(git -C "$checkout" status --porcelain 2>/dev/null)" ] ||
    say "warning: what is not committed in $checkout is not in the tree"

# Mounts as container engines make them, /dev/shm as large as half of the memory, for MPI.  A shell stays process 1: it
# takes care of orphans.  Signals are as they are for a foreground command, which the shell changes for others.
enter='
set -e
tree=$1; shift
mount -t proc proc "$tree/proc"
mount -t sysfs -o ro sysfs "$tree/sys" 2>/dev/null || mount --rbind /sys "$tree/sys"
mount -t tmpfs -o mode=755 tmpfs "$tree/dev"
for device in null zero full random urandom tty; do
    touch "$tree/dev/$device"
    mount --bind "/dev/$device" "$tree/dev/$device"
done
mkdir "$tree/dev/pts" "$tree/dev/shm"
mount -t devpts -o newinstance,ptmxmode=0666,mode=620 devpts "$tree/dev/pts"
mount -t tmpfs -o mode=1777 tmpfs "$tree/dev/shm"
ln -s pts/ptmx "$tree/dev/ptmx"
ln -s /proc/self/fd "$tree/dev/fd"
ln -s fd/0 "$tree/dev/stdin"
ln -s fd/1 "$tree/dev/stdout"
ln -s fd/2 "$tree/dev/stderr"
while [ "$1" != -- ]; do
    mkdir -p "$tree$1"
    mount --rbind -o ro "$1" "$tree$1"
    shift
done
shift
exec chroot "$tree" "$@"
'
for command in "${commands[@]}"; do
    say "$ $command"
    status=0
    run unshare --mount --pid --fork --kill-child bash -c "$enter" enter "$tree" ${folders[@]+"${folders[@]}"} -- \
        /usr/bin/env -i --default-signal=INT,QUIT "${variables[@]}" \
        bash -c "cd /flipflow && { $command"$'\n'"}; exit \$?" </dev/null || status=$?
    if [ $status != 0 ]; then
        echo "bare.sh: exit code $status" >&2
        exit $status
    fi
done
