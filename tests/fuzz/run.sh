#!/usr/bin/env bash
# Builds the fuzz targets (build/fuzz) and runs one of them on its kept corpus (build/fuzz/corpus):
#   bash tests/fuzz/run.sh bake|image|importer|lean_mesh|lean_points|lean_shading|level_codec|messages [seconds=3600]
# New corpora are seeded with the small files of ../shared/data where they are there. Exits with other than 0 on a
# finding, whose input is kept beside the corpus.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

target=${1:-} seconds=${2:-3600}
case $target in
    bake | image | importer | lean_mesh | lean_points | lean_shading | level_codec | messages) ;;
    *) sed -n '2,5s/^# *//p' "$0" >&2; exit 2 ;;
esac

bash deploy/install_packages.sh build fuzz
cmake --preset fuzz >/dev/null
cmake --build build/fuzz --target "fuzz_$target"

max_seed_bytes=200000
corpus=build/fuzz/corpus/$target findings=build/fuzz/findings

# Names of the importer's formats in the order of their numbers, which a seed begins with.
formats=(gltf glb obj ply stl off drc png hgt asc)

format_byte() {
    local extension=${1##*.} k
    for k in "${!formats[@]}"; do
        [[ ${extension,,} == "${formats[k]}" ]] && printf '%b' "\\x0$k" && return
    done
    return 1
}
# Each seed file behind the bytes that the target reads before it.
seed() {
    mkdir -p "$corpus"
    local file n=0
    while read -r file; do
        n=$((n + 1))
        case $target in
            bake) { format_byte "$file" && printf '\x55' && cat "$file"; } >"$corpus/seed$n" || rm -f "$corpus/seed$n" ;;
            importer) { format_byte "$file" && cat "$file"; } >"$corpus/seed$n" || rm -f "$corpus/seed$n" ;;
            image) [[ ${file,,} == *.@(png|jpg|jpeg) ]] && cp "$file" "$corpus/seed$n" ;;
            level_codec) [[ ${file,,} == *.@(glb|drc) ]] && cp "$file" "$corpus/seed$n" ;;
            messages) [[ $file == *.json ]] && cp "$file" "$corpus/seed$n" ;;
        esac || true
    done < <(find -L ../shared/data -type f -size "-${max_seed_bytes}c" 2>/dev/null)
    if [[ $target == messages ]]; then cp proto/examples/*.json "$corpus/"; fi
    if [[ $target == level_codec ]]; then cp tests/fuzz/seeds/*.glb "$corpus/"; fi
}

[[ -d $corpus ]] || seed
mkdir -p "$findings"
exec "build/fuzz/bin/fuzz_$target" -max_total_time="$seconds" -max_len="$max_seed_bytes" -timeout=60 -rss_limit_mb=2048 \
    -print_final_stats=1 -artifact_prefix="$findings/$target-" "$corpus"
