#!/bin/sh
# usage: isa_objects_have_no_weak_symbols.sh NM OBJECT...
# Of weak copies of one function the linker keeps any, perhaps the one compiled with AVX flags, for all callers: then an
# older processor meets an illegal instruction in ordinary code. Objects of ISA files therefore define no weak symbol.
# DW.ref.* is a word of data for the unwinder, the same in every object.
set -eu
nm=$1
shift
checked=0
failed=0
for object in "$@"; do
  case $object in
    *_sse41.cpp.* | *_avx2.cpp.* | *_avx512.cpp.* | *_avxvnni.cpp.* | *_avx512vnni.cpp.* | \
      *_neon.cpp.* | *_neondot.cpp.* | *_neonmm.cpp.*) ;;
    *) continue ;;
  esac
  checked=$((checked + 1))
  weak=$("$nm" -C --defined-only "$object" | grep -E '^[0-9a-f]+ [WVu] ' | grep -v ' DW\.ref\.' || true)
  if [ -n "$weak" ]; then
    failed=1
    printf '%s defines weak symbols (use static or an anonymous namespace, no std templates):\n%s\n' "$object" "$weak"
  fi
done
if [ "$checked" -eq 0 ]; then
  echo "no ISA object among the arguments: the check would pass on nothing"
  exit 1
fi
[ "$failed" -eq 0 ] && echo "$checked ISA objects, no weak symbol"
exit "$failed"
