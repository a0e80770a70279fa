#!/usr/bin/env bash
# Proves that the commands of README.md work on a bare Debian 12: makes a fresh tree, copies the checkout into it and runs
# them there with this machine's own network settings. Root is needed (chroot, mount).
#   bash tests/bare.sh [--work DIR] [--keep] [--packages | --demo | --tests]     default: the demo, then the tests
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work= keep= what=(demo tests)
while (($#)); do
    case $1 in
        --work) work=$2; shift 2 ;;
        --keep) keep=1; shift ;;
        --packages | --demo | --tests) what=("${1#--}"); shift ;;
        *) sed -n '2,4s/^# *//p' "$0" >&2; exit 2 ;;
    esac
done
((EUID == 0)) || { echo "tests/bare.sh: needs root for chroot and mount" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "tests/bare.sh: needs debootstrap: apt-get install debootstrap" >&2; exit 1; }

work=${work:-$(mktemp -d -t bare-debian.XXXXXX)}
tree=$work/tree
mkdir -p "$tree"

clean_up() {
    local point
    for point in dev/pts dev/shm dev sys proc; do
        mountpoint -q "$tree/$point" && umount -l "$tree/$point"
    done
    [[ -n $keep ]] || rm -rf --one-file-system "$work"
}
trap clean_up EXIT

timed() {
    local name=$1 start=$SECONDS status=0
    shift
    echo "== $name"
    "$@" || status=$?
    echo "== $name: $((SECONDS - start)) s, exit $status"
    return $status
}

# The mirror, proxies and certificates of this machine; none of them is written down in the repository.
mirror() {
    apt-get indextargets --format '$(CREATED_BY) $(CODENAME) $(REPO_URI)' | awk '$1 == "Packages" && $2 == "bookworm" { print $3; exit }'
}

copy_network_settings() {
    cp -L /etc/resolv.conf /etc/hosts "$tree/etc/"
    rm -f "$tree/etc/apt/sources.list"
    cp -r /etc/apt/sources.list* "$tree/etc/apt/"
    [[ ! -e /etc/apt/auth.conf ]] || cp /etc/apt/auth.conf "$tree/etc/apt/"
    apt-config dump --format '%f "%v";%n' Acquire >"$tree/etc/apt/apt.conf.d/99host"
    mkdir -p "$tree/usr/local/share/ca-certificates" "$tree/etc/ssl"
    cp -r /usr/local/share/ca-certificates/. "$tree/usr/local/share/ca-certificates/"
    cp -rL /etc/ssl/certs "$tree/etc/ssl/" 2>/dev/null || true
    [[ ! -e ~/.npmrc ]] || cp ~/.npmrc "$tree/root/"
    if command -v npm >/dev/null; then
        printf '\nregistry=%s\n' "$(npm config get registry 2>/dev/null)" >>"$tree/root/.npmrc"
    fi
}

copy_checkout() {
    mkdir -p "$tree/src/main"
    (cd "$root" && git ls-files -z --cached --others --exclude-standard | tar -c --null --no-recursion --ignore-failed-read -T - 2>/dev/null) |
        tar -x -C "$tree/src/main"
    if [[ -d $root/../shared ]]; then cp -r "$root/../shared" "$tree/src/shared"; fi
}

inside() {
    local names
    mapfile -t names < <(compgen -e | grep -iE '(_proxy|_ca_certs|cert_file|cert_dir|ca_bundle)$')
    local name pass=()
    for name in "${names[@]}"; do pass+=("$name=${!name}"); done
    chroot "$tree" /usr/bin/env -i HOME=/root TERM=dumb LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin "${pass[@]}" \
        bash -c "cd /src/main && $1"
}

from=$(mirror)
[[ -n $from ]] || { echo "tests/bare.sh: no mirror of bookworm among this machine's apt sources" >&2; exit 1; }
make_tree() { debootstrap --variant=minbase bookworm "$tree" "$from" >"$work/debootstrap.log" 2>&1; }
[[ -e $tree/etc/debian_version ]] || timed "fresh tree" make_tree || { tail -5 "$work/debootstrap.log" >&2; exit 1; }
copy_network_settings
copy_checkout
mount -t proc proc "$tree/proc"
mount -t sysfs sys "$tree/sys"
mount --bind /dev "$tree/dev"
mkdir -p "$tree/dev/pts" "$tree/dev/shm"
mount --bind /dev/pts "$tree/dev/pts"
mount --bind /dev/shm "$tree/dev/shm"

result=0
for step in "${what[@]}"; do
    case $step in
        packages) timed "packages" inside "bash deploy/install_packages.sh build run test" || result=1 ;;
        demo) timed "demo" inside "bash deploy/demo.sh --once" || result=1 ;;
        tests) timed "tests" inside "bash tests/run.sh" || result=1 ;;
    esac
done
exit $result
