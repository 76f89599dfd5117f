#!/usr/bin/env bash
# Lists the C++ files of the project.
cd "$(dirname "$0")/.."
find . \( -name build -o -name runs -o -name node_modules -o -name .git \) -prune -o \( -name '*.cpp' -o -name '*.hpp' \) -print
