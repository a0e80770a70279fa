#!/usr/bin/env bash
# Installs what is missing, builds, lints and runs every test; exits non-zero on any failure.
#   bash tests/run.sh [--preset release|debug|asan|tsan] [--no-lint]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=release lint=1
while (($#)); do
    case $1 in
        --preset) preset=${2:-}; shift 2 || shift ;;
        --no-lint) lint=; shift ;;
        *) sed -n '2,3s/^# *//p' "$0" >&2; exit 2 ;;
    esac
done
case $preset in
    release | debug | asan | tsan) ;;
    *) echo "tests/run.sh: --preset must be release, debug, asan or tsan, not \"$preset\"" >&2; exit 2 ;;
esac

bash deploy/install_packages.sh build run test
(cd tests/web && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
cmake --preset "$preset" -DBUILD_TESTING=ON -Wno-dev
cmake --build --preset "$preset"

# A sanitizer build is judged by its tests; the sources are linted once, in the ordinary run.
if [[ -n $lint && $preset == release ]]; then bash tests/lint.sh "build/$preset"; fi

source tests/sanitizers/options.sh
ctest --preset "$preset" -j2
