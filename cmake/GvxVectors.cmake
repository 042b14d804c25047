# Which instruction sets the loops over vectors (*_simd.cpp) are compiled for. Compiling them is most of the
# work of a build, so only a build for other machines needs all.

set(GVX_VECTORS "all" CACHE STRING
  "Instruction sets of the vectors: all (chosen at run time), native (what this machine has), SSE4, AVX2, AVX3 (AVX-512) or scalar")
set_property(CACHE GVX_VECTORS PROPERTY STRINGS all native SSE4 AVX2 AVX3 scalar)
set(GVX_VECTORS_LIBRARY "" CACHE FILEPATH
  "The vectors of another build of the same sources (libgvx_vectors.a), to link instead of compiling them")

# Highway takes the least of the sets from the compiler's flags, and wants AES beside each.
set(SSE4_flags -march=x86-64-v2 -maes -mpclmul)
set(AVX2_flags -march=x86-64-v3 -maes -mpclmul)
set(AVX3_flags -march=x86-64-v4 -maes -mpclmul)

if(NOT GVX_VECTORS MATCHES "^(all|native|SSE4|AVX2|AVX3|scalar)$")
  message(FATAL_ERROR "GVX_VECTORS: '${GVX_VECTORS}' is not one of all, native, SSE4, AVX2, AVX3, scalar")
endif()
set(set_of_vectors ${GVX_VECTORS})
if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  if(NOT GVX_VECTORS STREQUAL "scalar")
    set(set_of_vectors native)
  endif()
  set(SSE4_flags)
elseif(GVX_VECTORS STREQUAL "native")
  # What the compiler would use here.
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -march=native -dM -E -x c++ /dev/null OUTPUT_VARIABLE macros
    ERROR_QUIET)
  if(macros MATCHES "__AVX512BW__" AND macros MATCHES "__AVX512VL__" AND macros MATCHES "__AVX512DQ__")
    set(set_of_vectors AVX3)
  elseif(macros MATCHES "__AVX2__" AND macros MATCHES "__FMA__" AND macros MATCHES "__BMI2__" AND macros MATCHES "__F16C__")
    set(set_of_vectors AVX2)
  elseif(macros MATCHES "__SSE4_2__" AND macros MATCHES "__AES__")
    set(set_of_vectors SSE4)
  else()
    set(set_of_vectors scalar)
  endif()
endif()
if(set_of_vectors STREQUAL "all")
  set(GVX_VECTOR_FLAGS ${SSE4_flags})
elseif(set_of_vectors STREQUAL "scalar")
  set(GVX_VECTOR_FLAGS -DHWY_COMPILE_ONLY_SCALAR)
else()
  set(GVX_VECTOR_FLAGS ${${set_of_vectors}_flags} -DHWY_COMPILE_ONLY_STATIC)
endif()
message(STATUS "gvx: vectors for ${set_of_vectors} (GVX_VECTORS=${GVX_VECTORS})")
