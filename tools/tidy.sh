#!/usr/bin/env bash
# clang-tidy over every source of the project, with the compile commands of the release preset:
#   tools/tidy.sh                      all of them
#   tools/tidy.sh control apps/linuxcnc    those whose path has one of these words
set -euo pipefail
cd "$(dirname "$0")/.."
dpkg-query -W clang-tidy-19 >/dev/null 2>&1 || { echo "tidy: apt-get install clang-tidy-19" >&2; exit 5; }
# ITK's macro stands on the command line, where the check of macros would judge it: here it comes
# from a header that is not ours.
mkdir -p build/tidy
printf '%s\n' '#pragma GCC system_header' '#define ITK_EIGEN(header) <Eigen/header>' >build/tidy/itk_eigen.h
sed 's|\\"-DITK_EIGEN(header)=<Eigen/header>\\"|-include '"$PWD"'/build/tidy/itk_eigen.h|' \
  build/release/compile_commands.json >build/tidy/compile_commands.json
words=$(IFS='|'; echo "${*:-.}")
tools/cpp_files.sh | grep '\.cpp$' | grep -v '_test\.cpp$' | grep -E "$words" |
  xargs -P "$(nproc)" -n 4 clang-tidy-19 -quiet -p build/tidy
