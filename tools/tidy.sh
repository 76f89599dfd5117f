#!/usr/bin/env bash
# clang-tidy over every source of the project, with the compile commands of the release preset.
set -euo pipefail
cd "$(dirname "$0")/.."
dpkg-query -W clang-tidy-19 >/dev/null 2>&1 || { echo "tidy: apt-get install clang-tidy-19" >&2; exit 5; }
tools/cpp_files.sh | grep '\.cpp$' | grep -v '_test\.cpp$' | xargs -P "$(nproc)" -n 4 clang-tidy-19 -quiet -p build/release
