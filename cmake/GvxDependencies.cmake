# Everything gvx is built on; each has a Debian package of the name in brackets (tools/setup installs them).

find_package(Threads REQUIRED)
find_package(TBB REQUIRED)              # libtbb-dev
find_package(ZLIB REQUIRED)             # zlib1g-dev
find_package(BZip2 REQUIRED)            # libbz2-dev
find_package(PNG REQUIRED)              # libpng-dev
find_package(nlohmann_json REQUIRED)    # nlohmann-json3-dev
find_package(PkgConfig REQUIRED)        # pkg-config
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)  # libzstd-dev
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)    # liblz4-dev
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)      # libhwy-dev
find_path(GVX_XXHASH_INCLUDE xxhash.h REQUIRED)           # libxxhash-dev

find_package(OpenEXR QUIET)             # libopenexr-dev
if(NOT OpenEXR_FOUND)
  message(STATUS "gvx: OpenEXR not found: built without EXR pictures")
endif()

find_package(TIFF 4.5 QUIET)            # libtiff-dev
find_package(EXPAT 2.4 QUIET)           # libexpat1-dev: the XML of OME-TIFF
if(TIFF_FOUND AND EXPAT_FOUND)
  set(GVX_WITH_TIFF ON)
else()
  set(GVX_WITH_TIFF OFF)
  message(STATUS "gvx: libtiff 4.5 or expat 2.4 not found: built without TIFF volumes")
endif()

find_path(GVX_EMBREE_INCLUDE embree3/rtcore.h)            # libembree-dev
find_library(GVX_EMBREE_LIBRARY embree3)
if(NOT GVX_EMBREE_INCLUDE OR NOT GVX_EMBREE_LIBRARY)
  message(STATUS "gvx: Embree 3 not found: built without distances to meshes, their hypertextures and their voxels")
endif()

# Not its package configuration, which also wants GDCM's programs.
find_path(GVX_GDCM_INCLUDE gdcmImage.h PATH_SUFFIXES gdcm-3.0)  # libgdcm-dev
set(GVX_GDCM_LIBRARIES)
set(GVX_GDCM_FOUND ON)
foreach(part MSFF DICT DSED Common)
  find_library(GVX_GDCM_${part} gdcm${part})
  list(APPEND GVX_GDCM_LIBRARIES ${GVX_GDCM_${part}})
  if(NOT GVX_GDCM_${part} OR NOT GVX_GDCM_INCLUDE)
    set(GVX_GDCM_FOUND OFF)
  endif()
endforeach()
if(NOT GVX_GDCM_FOUND)
  message(STATUS "gvx: GDCM not found: built without DICOM files whose pixels are packed as JPEG, JPEG-LS or JPEG 2000")
endif()
