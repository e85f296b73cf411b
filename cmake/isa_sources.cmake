# File suffix -> compiler flags: the only place where an -m flag is written. Flags also forbid the next level up,
# so that a body cannot silently use more than its name says.
include(CheckCXXCompilerFlag)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  set(EGOFOCUS_ARCH x86)
  set(EGOFOCUS_ISA_sse41 "-msse4.1;-mno-sse4.2;-mno-avx")
  set(EGOFOCUS_ISA_avx2 "-mavx2;-mno-fma;-mno-avx512f")
  set(EGOFOCUS_ISA_avx512 "-mavx512f;-mavx512bw;-mavx512vl;-mavx512dq;-mprefer-vector-width=512")
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    list(APPEND EGOFOCUS_ISA_avx512 "-mno-fma")  # clang counts FMA as a part of AVX-512 and would switch off both
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    list(APPEND EGOFOCUS_ISA_avx512 "-Wno-maybe-uninitialized")  # its own avx512fintrin.h trips over it
  endif()
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  set(EGOFOCUS_ARCH aarch64)
  set(EGOFOCUS_ISA_neon "")
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^arm")
  set(EGOFOCUS_ARCH armv7)
  set(EGOFOCUS_ISA_neon "-mfpu=neon")
else()
  set(EGOFOCUS_ARCH generic)
endif()

# egofocus_isa_sources(<isa> file...): adds the files to the library with the flags of the ISA, when the target has it.
function(egofocus_isa_sources isa)
  if(NOT DEFINED EGOFOCUS_ISA_${isa})
    return()
  endif()
  foreach(file IN LISTS ARGN)
    target_sources(egofocus PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    set_source_files_properties(${CMAKE_CURRENT_SOURCE_DIR}/${file} TARGET_DIRECTORY egofocus
                                PROPERTIES COMPILE_OPTIONS "${EGOFOCUS_ISA_${isa}}")
  endforeach()
  string(TOUPPER ${isa} upper)
  target_compile_definitions(egofocus PUBLIC $<BUILD_INTERFACE:EGOFOCUS_HAVE_${upper}=1>)
endfunction()
