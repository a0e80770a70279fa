#!/usr/bin/env bash
# Installs what is missing, builds the benchmarks apart from everything else (build/bench) and runs one of them.
#   bash tests/bench/run.sh simplify|cut|growth|seams|codec|shading|probe|frame_time|control|terrain [its options; --help lists them]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

case ${1:-} in
    simplify | cut | growth | seams | codec | shading | probe | frame_time | control | terrain) program=lodestream_bench_$1; shift ;;
    *) sed -n '2,3s/^# *//p' "$0" >&2; exit 2 ;;
esac

bash deploy/install_packages.sh build run bench

# CGAL is headers alone, but its package insists on an older Boost than ours and cannot be installed beside it.
if [[ ! -d build/cgal/usr/include/CGAL ]]; then
    mkdir -p build/cgal
    (cd build/cgal && apt-get download -qq libcgal-dev && dpkg-deb -x libcgal-dev_*.deb .)
fi

cmake --preset release -B build/bench -DLODESTREAM_BENCHMARKS=ON -DBUILD_TESTING=OFF -Wno-dev >/dev/null
cmake --build build/bench --target "$program"
exec "build/bench/bin/$program" "$@"
