#!/usr/bin/env bash
# One command from nothing to pictures: installs what is missing, builds, starts the server with the built-in samples,
# serves four device classes end to end, prints one table and writes report.html.
usage="usage: bash deploy/demo.sh [--once] [--out DIR] [--assets DIR] [--port N]
  --once        stop the server after the report; otherwise it is left running
  --out DIR     where report, pictures, log and store go (default: build/demo)
  --assets DIR  serve the models of this folder too
  --port N      on 127.0.0.1 (default: 8080)"
set -euo pipefail

fail() {
    echo "demo: $1" >&2
    exit "${2:-1}"
}

caller=$PWD
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$root/build/demo port=8080 assets= once=
while (($#)); do
    case $1 in
        --once) once=1; shift; continue ;;
        --help | -h) echo "$usage"; exit 0 ;;
        --out | --assets | --port) (($# > 1)) || fail "$1 needs a value"$'\n'"$usage" 2 ;;
        *) fail "unknown option $1"$'\n'"$usage" 2 ;;
    esac
    case $1 in
        --out) out=$2 ;;
        --assets) assets=$2 ;;
        --port) port=$2 ;;
    esac
    shift 2
done
[[ $port =~ ^[0-9]{1,5}$ ]] && ((port >= 1 && port <= 65535)) || fail "--port must be 1 to 65535, not $port" 2
[[ $out == /* ]] || out=$caller/$out
[[ -z $assets || $assets == /* ]] || assets=$caller/$assets
[[ -z $assets || -d $assets ]] || fail "no folder $assets"
if (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then fail "port $port is in use: stop what listens there or pass --port N"; fi

cd "$root"
bash deploy/install_packages.sh build run || fail "installing packages failed; they are listed in deploy/packages.txt"
configure=(cmake --preset release)
[[ -e build/release/CMakeCache.txt ]] || configure+=(-DBUILD_TESTING=OFF)  # the tests need packages that a demo does not
"${configure[@]}" >/dev/null
cmake --build --preset release --target lodestream_server lodestream_client
bin=$root/build/release/bin

mkdir -p "$out"
log=$out/server.log
serve=("$bin/lodestream-server" serve --listen "127.0.0.1:$port" --store "$out/store" --samples)
[[ -z $assets ]] || serve+=(--assets "$assets")
nohup "${serve[@]}" >"$log" 2>&1 </dev/null &
server=$!
trap 'kill "$server" 2>/dev/null || true' EXIT

url=http://127.0.0.1:$port
stall_limit_s=300  # without any progress; how long all of it takes depends on the models

count_of() { grep -o "\"status\":\"$1\"" <<<"$assets_json" | wc -l; }

# Ready is not enough: the report wants every asset baked, and of a folder every file imported.
all_baked() {
    [[ $assets_json == *'"status":'* && $assets_json != *'"status":"baking"'* ]] &&
        { [[ -z $assets ]] || grep -q '^assets: ' "$log"; }
}

echo "waiting for the server to import and bake ..."
assets_json= last_seen= stalled_since=$SECONDS
until all_baked; do
    kill -0 "$server" 2>/dev/null || fail "the server stopped: $(tail -n 3 "$log")"
    sleep 1
    assets_json=$(curl -fsS "$url/v1/assets" 2>/dev/null) || assets_json=
    [[ ! -t 1 ]] || printf '\r%d baked, %d to go \033[K' "$(count_of ready)" "$(count_of baking)"
    if [[ $assets_json != "$last_seen" ]]; then
        last_seen=$assets_json stalled_since=$SECONDS
    fi
    ((SECONDS - stalled_since < stall_limit_s)) || fail "nothing was imported or baked for $stall_limit_s s; see $log"
done
[[ ! -t 1 ]] || printf '\r\033[K'

"$bin/lodestream-client" report --server "$url" --out "$out" || fail "the report failed; the server's log is $log"

echo
pictures=$(find "$out" -name '*.png' -not -path "$out/store/*" | wc -l)
((pictures == 0)) || echo "pictures: $pictures PNG files below $out"
if [[ -n $once ]]; then
    kill "$server"
    wait "$server" 2>/dev/null || true
else
    echo "server:   $url/ (log $log); stop it with: kill $server"
fi
trap - EXIT
