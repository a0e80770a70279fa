#!/usr/bin/env bash
# Formatting (clang-format) and naming and bug patterns (clang-tidy) of all our sources, errors on any finding.
#   bash tests/lint.sh [BUILD_FOLDER]     default: build/release, which must have been built with Ninja
# A source that passed is not looked at again until it, a header of ours that it includes or .clang-tidy changes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${1:-build/release}

find common server client proto tests \( -name node_modules -prune \) -o \( -name '*.h' -o -name '*.cpp' \) -print0 |
    sort -z | xargs -0 clang-format --dry-run -Werror
echo "clang-format: clean"

[[ -e $build/compile_commands.json ]] || { echo "tests/lint.sh: $build is not configured: cmake --preset release" >&2; exit 1; }
passed=$build/tidy/passed
mkdir -p "$passed"

# GCC's precompiled headers mean nothing to clang; the sources include what they use.
sed -E 's/-Winvalid-pch|-include [^ ]*cmake_pch\.hxx//g' "$build/compile_commands.json" >"$build/tidy/compile_commands.json"

# Ninja's record of what each object was made from: the source first, then every header.
sources_with_headers() {
    ninja -C "$build" -t deps | awk -v root="$PWD/" '
        function flush() { if (line) print line; line = "" }
        /^[^ ]/ { flush(); next }
        NF {
            path = $1
            if (index(path, root) == 1) path = substr(path, length(root) + 1)
            else if (path !~ /^\.\.\/\.\.\/[^.]/) next
            sub(/^\.\.\/\.\.\//, "", path)  # a compiler cache may write paths from the build folder
            if (index(path, "build/") != 1) line = line (line ? " " : "") path
        }
        END { flush() }' | sort -u
}

tidy_one() {
    local key
    key=$(cat .clang-tidy $1 | sha256sum | cut -c1-40)
    [[ ! -e $passed/$key ]] || return 0
    clang-tidy --quiet --extra-arg=-Wno-unknown-warning-option -p "$build/tidy" "${1%% *}" 2>/dev/null && touch "$passed/$key"
}
export -f tidy_one
export build passed

sources_with_headers | tr '\n' '\0' | xargs -0 -n 1 -P "$(nproc)" bash -c 'tidy_one "$1"' tidy || { echo "clang-tidy: findings above" >&2; exit 1; }
echo "clang-tidy: clean"
