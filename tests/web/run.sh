#!/usr/bin/env bash
# Runs one of the programs here, or tells ctest (exit code 77) what is missing for it: bash tests/web/run.sh PROGRAM.mjs ARGUMENT...
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
skip() { echo "skipped: $1"; exit 77; }

command -v node >/dev/null || skip "node is not installed (bash deploy/install_packages.sh test)"
[[ -x ${CHROMIUM:-/usr/bin/chromium} ]] || skip "chromium is not installed (bash deploy/install_packages.sh test)"
[[ -d $here/node_modules/three ]] || skip "the npm packages are not installed (cd tests/web && npm ci --ignore-scripts)"
exec node "$here/$1" "${@:2}"
