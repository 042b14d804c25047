# `cmake --install` and find_package(gvx), which also finds a build that was not installed.

include(CMakePackageConfigHelpers)
get_property(rooms GLOBAL PROPERTY GVX_ROOMS)
list(TRANSFORM rooms PREPEND gvx_ OUTPUT_VARIABLE room_targets)
install(TARGETS ${room_targets} EXPORT gvx-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS gvx_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# What a program includes by name. GvxInstallHeaders.cmake installs these and whatever they include, and nothing else.
set(public_headers
  engine/engine.h engine/renderer.h
  core/noise.h
  io/image.h io/label_table_file.h io/mesh.h io/mesh_parts.h io/raw.h io/store_build.h io/transfer_function_file.h io/volume_reader.h
  open/file_names.h open/functions.h open/nothing_seen.h open/open_scene.h
  produce/amplify_producer.h produce/deeper_producer.h produce/field_kernels.h produce/field_producer.h produce/hypertexture.h
  mesh/mesh_distance.h mesh/mesh_proxy.h mesh/mesh_voxels.h mesh/surface_store.h
  produce/kernel_producer.h produce/repeat_producer.h produce/sampled_bounds.h
  produce/sponge_producer.h produce/store_producer.h produce/terrain.h
  scene/camera_matrices.h scene/camera_path.h scene/label_table.h scene/scene_file.h scene/transfer_presets.h
  store/store_reader.h store/store_writer.h store/verify.h
  surface/stored_surface.h surface/surface_reader.h)
install(CODE "
  set(GVX_HEADERS_FROM \"${PROJECT_SOURCE_DIR}/src/gvx\")
  set(GVX_HEADERS_TO \"${CMAKE_INSTALL_INCLUDEDIR}\")
  set(GVX_PUBLIC_HEADERS \"${public_headers}\")")
install(SCRIPT cmake/GvxInstallHeaders.cmake)

install(EXPORT gvx-targets NAMESPACE gvx:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gvx)
configure_package_config_file(cmake/gvx-config.cmake.in gvx-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gvx)
write_basic_package_version_file(gvx-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gvx-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/gvx-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gvx)

# Beside gvx-config.cmake in the build folder: gvx_DIR may name that folder, with no install.
export(EXPORT gvx-targets NAMESPACE gvx:: FILE ${CMAKE_CURRENT_BINARY_DIR}/gvx-targets.cmake)
