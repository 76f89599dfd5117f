#!/usr/bin/env bash
# Every C++ file is as clang-format leaves it; `./run format` mends.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/cpp_files.sh | xargs clang-format-19 --dry-run -Werror
