# gvx_room(NAME MAY_INCLUDE <room>... [SOURCES <file>...] [DEVICE_SOURCES <file>...] [VECTOR_SOURCES <file>...] [TESTS <file>...]
#          [DEVICE_TESTS <file>...] [LIBRARIES <target>...])
#
# A room is a folder of src/gvx, a namespace and a library. MAY_INCLUDE is the house's include table: the build
# links these rooms and no others, and tools/check_includes.py compares every #include with it.
# DEVICE_SOURCES launch kernels: CUDA where CUDA is enabled, C++ where it is not.
# VECTOR_SOURCES are compiled once for each instruction set (GvxVectors.cmake), into a library of their own.
# TESTS are compiled into the one unit-test program; DEVICE_TESTS launch kernels themselves.
function(gvx_room NAME)
  cmake_parse_arguments(ROOM "" "" "MAY_INCLUDE;SOURCES;DEVICE_SOURCES;VECTOR_SOURCES;TESTS;DEVICE_TESTS;LIBRARIES" ${ARGN})
  set(target gvx_${NAME})
  if(ROOM_SOURCES OR ROOM_DEVICE_SOURCES)
    add_library(${target} STATIC ${ROOM_SOURCES} ${ROOM_DEVICE_SOURCES})
    set(scope PUBLIC)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:${GVX_CXX_FLAGS}>)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(gvx::${NAME} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${NAME})
  target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>
                                                $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  list(TRANSFORM ROOM_MAY_INCLUDE PREPEND gvx_ OUTPUT_VARIABLE rooms)
  target_link_libraries(${target} ${scope} ${rooms} ${ROOM_LIBRARIES})
  if(GVX_WITH_CUDA AND ROOM_DEVICE_SOURCES)
    set_source_files_properties(${ROOM_DEVICE_SOURCES} PROPERTIES LANGUAGE CUDA)
    target_compile_options(${target} PRIVATE
      $<$<COMPILE_LANGUAGE:CUDA>:--extended-lambda --expt-relaxed-constexpr --fmad=false -Xcompiler=-Wall,-Wextra,-ffp-contract=off>)
    set_target_properties(${target} PROPERTIES CUDA_RESOLVE_DEVICE_SYMBOLS OFF)
  endif()
  if(ROOM_VECTOR_SOURCES)
    gvx_vectors(${target} "${rooms};${ROOM_LIBRARIES}" ${ROOM_VECTOR_SOURCES})
  endif()
  list(TRANSFORM ROOM_TESTS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  list(TRANSFORM ROOM_DEVICE_TESTS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set_property(GLOBAL APPEND PROPERTY GVX_UNIT_TESTS ${ROOM_TESTS})
  set_property(GLOBAL APPEND PROPERTY GVX_DEVICE_UNIT_TESTS ${ROOM_DEVICE_TESTS})
  set_property(GLOBAL APPEND PROPERTY GVX_ROOMS ${NAME})
endfunction()

# The vectors of a room, which is linked with them: a library of their own, gvx_ROOM_vectors or, for those of the
# march, gvx_vectors. Builds may share the latter, as compiling them takes the longest.
function(gvx_vectors ROOM LIBRARIES)
  if(ROOM STREQUAL "gvx_render")
    set(name vectors)
    if(GVX_VECTORS_LIBRARY)
      target_link_libraries(${ROOM} PRIVATE $<BUILD_INTERFACE:${GVX_VECTORS_LIBRARY}>)
      return()
    endif()
  else()
    string(REPLACE gvx_ "" name ${ROOM}_vectors)
  endif()
  set(target gvx_${name})
  add_library(${target} STATIC ${ARGN})
  target_compile_options(${target} PRIVATE ${GVX_CXX_FLAGS} ${GVX_VECTOR_FLAGS})
  if(GVX_SANITIZE STREQUAL "thread")
    # They share nothing between threads, and an instrumented loop takes minutes to compile.
    target_compile_options(${target} PRIVATE -fno-sanitize=thread)
  endif()
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON EXPORT_NAME ${name})
  target_link_libraries(${target} PUBLIC ${LIBRARIES})
  # They call back: a room and its vectors are one.
  target_link_libraries(${ROOM} PUBLIC ${target})
  target_link_libraries(${target} PUBLIC ${ROOM})
  set_property(GLOBAL APPEND PROPERTY GVX_ROOMS ${name})
endfunction()
