# `cmake --install` and find_package(gvx).

include(CMakePackageConfigHelpers)
get_property(rooms GLOBAL PROPERTY GVX_ROOMS)
list(TRANSFORM rooms PREPEND gvx_ OUTPUT_VARIABLE room_targets)
install(TARGETS ${room_targets} EXPORT gvx-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS gvx_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY src/gvx DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h"
  PATTERN "*_test_support.h" EXCLUDE PATTERN "march_kernels.h" EXCLUDE PATTERN "march_view.h" EXCLUDE PATTERN "leaf_table.h" EXCLUDE PATTERN "simd_targets.h" EXCLUDE PATTERN "*-inl.h" EXCLUDE)
install(EXPORT gvx-targets NAMESPACE gvx:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gvx)
configure_package_config_file(cmake/gvx-config.cmake.in gvx-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gvx)
write_basic_package_version_file(gvx-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gvx-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/gvx-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gvx)
