#!/usr/bin/env bash
# Every C++ file is as clang-format leaves it; `./run format` mends.
set -euo pipefail
cd "$(dirname "$0")/.."
find src apps bench examples -name '*.cpp' -o -name '*.hpp' | xargs clang-format-19 --dry-run -Werror
