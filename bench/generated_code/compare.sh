#!/usr/bin/env bash
# compare.sh CANORB_IDLC INCLUDE_DIRECTORY...
#
# How much code canorb-idlc and omniidl generate for the same IDL: lines of header and source, and
# octets of .text at -Os. omniidl gives no type codes (-Wba would), canorb-idlc always does: as
# constants, which take nothing where they are not used. Exit code 1: canorb's is not the smaller.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
canorb_idlc=$1
shift
includes=("${@/#/-I}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

mkdir "$work/canorb" "$work/omniorb"
"$canorb_idlc" --output-dir "$work/canorb" "$here/gauge.idl"
omniidl -bcxx -C"$work/omniorb" "$here/gauge.idl"

lines() { cat "$@" | wc -l; }
# text SOURCE OPTION...: octets of .text and of read-only data, as size(1) counts them.
text() { "${CXX:-g++}" -Os "${@:2}" -c "$1" -o "$work/object.o" && size "$work/object.o" | awk 'NR == 2 { print $1 }'; }

our_lines=$(lines "$work"/canorb/*)
their_lines=$(lines "$work"/omniorb/*)
our_text=$(text "$work/canorb/gauge.cpp" -std=c++20 "${includes[@]}" -I"$work/canorb")
their_text=$(text "$work/omniorb/gaugeSK.cc" -I"$work/omniorb")

printf '%-24s %10s %10s %8s\n' 'gauge.idl' canorb-idlc omniidl ratio
row() { printf '%-24s %10d %10d %8.2f\n' "$1" "$2" "$3" "$(awk "BEGIN { print $2 / $3 }")"; }
row 'lines generated' "$our_lines" "$their_lines"
row '.text at -Os, octets' "$our_text" "$their_text"
((our_lines < their_lines && our_text < their_text))
