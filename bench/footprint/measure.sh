#!/usr/bin/env bash
# measure.sh [--no-cross]
#
# How large the engine is: octets of text, data and bss, as size(1) counts them, of each layer from
# orb/base to orb/core, compiled at -Os without exceptions and RTTI, for this machine and for a
# Cortex-M4. It is what a program has that uses all of it: nothing is linked, so functions that no
# program calls count too, and what the layers need of the C++ library does not.
# --no-cross: without the Cortex-M4.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cross=1
if [[ ${1:-} == --no-cross ]]; then cross=0; fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
layers=(base ccdr giop can caniop poa mca core)
options=(-std=c++20 -Os -DNDEBUG -fno-exceptions -fno-rtti -ffunction-sections -fdata-sections
    -I"$root" -c)

# measure TITLE COMPILER SIZE OPTION...
measure() {
    local title=$1 compiler=$2 size=$3 layer source objects all=()
    printf '%-24s %8s %8s %8s\n' "$title" text data bss
    for layer in "${layers[@]}"; do
        objects=()
        for source in "$root/orb/$layer"/*.cpp; do
            objects+=("$work/$layer-$(basename "$source" .cpp).o")
            "$compiler" "${options[@]}" "${@:4}" "$source" -o "${objects[-1]}"
        done
        row "$layer" "$size" "${objects[@]}"
        all+=("${objects[@]}")
    done
    row total "$size" "${all[@]}"
}

# row NAME SIZE OBJECT...
row() {
    "$2" -t "${@:3}" |
        awk -v name="$1" '/TOTALS/ { printf "%-24s %8d %8d %8d\n", name, $1, $2, $3 }'
}

measure "x86-64, octets" "${CXX:-g++}" size
if ((cross)); then
    # -Wno-psabi: nothing here is linked with what compilers before gcc 7 made.
    measure "Cortex-M4, octets" arm-none-eabi-g++ arm-none-eabi-size -mcpu=cortex-m4 -mthumb \
        -mfloat-abi=soft -Wno-psabi
fi
