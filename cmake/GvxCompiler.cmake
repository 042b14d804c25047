# Language level, warnings, sanitizers and the CUDA language.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
find_program(GVX_CCACHE ccache)
if(GVX_CCACHE)
  # What one clone has compiled another need not.
  set(launcher ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros ${GVX_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${launcher})
  set(CMAKE_CUDA_COMPILER_LAUNCHER ${launcher})
endif()

# Without contraction a picture is the same bits in every build of one instruction set.
# -Wrestrict: g++ 12 warns about std::string's own operator+ (GCC bug 105651).
set(GVX_CXX_FLAGS -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wno-restrict -ffp-contract=off)
# g++ gives the members of a structure no constructor for another instruction set than the whole file's.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  list(APPEND GVX_CXX_FLAGS -march=armv8-a+crypto)
endif()
if(GVX_SANITIZE)
  add_compile_options(-fsanitize=${GVX_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${GVX_SANITIZE})
endif()

set(GVX_WITH_CUDA OFF)
if(NOT GVX_CUDA STREQUAL "OFF")
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
      set(CMAKE_CUDA_ARCHITECTURES 75)  # its PTX runs on every later GPU
    endif()
    enable_language(CUDA)
    # CMake 3.25 knows C++20 of g++, but not of nvcc.
    set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION -std=c++20)
    set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION -std=c++20)
    set(CMAKE_CUDA_STANDARD 20)
    find_package(CUDAToolkit REQUIRED)
    set(GVX_WITH_CUDA ON)
  elseif(GVX_CUDA STREQUAL "ON")
    message(FATAL_ERROR "GVX_CUDA=ON, but no CUDA compiler (nvcc) was found")
  else()
    message(STATUS "gvx: no nvcc found: built without --device cuda")
  endif()
endif()
