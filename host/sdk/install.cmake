# SPDX-License-Identifier: MIT
#
# What `cmake --install` gives beside the modules: libstrata, the command line, the SDK's headers,
# and the files with which CMake and pkg-config find it all.
include(CMakePackageConfigHelpers)
set(package_folder "${CMAKE_INSTALL_LIBDIR}/cmake/Strata")

target_include_directories(strata INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_include_directories(strata_sdk INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set_target_properties(strata_sdk PROPERTIES EXPORT_NAME sdk)
set_target_properties(strata-note PROPERTIES EXPORT_NAME note)
install(TARGETS strata strata_sdk strata-note EXPORT StrataTargets)
install(EXPORT StrataTargets NAMESPACE Strata:: DESTINATION "${package_folder}")

configure_package_config_file(host/sdk/StrataConfig.cmake.in "${PROJECT_BINARY_DIR}/StrataConfig.cmake"
  INSTALL_DESTINATION "${package_folder}" NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/StrataConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/StrataConfig.cmake"
              "${PROJECT_BINARY_DIR}/StrataConfigVersion.cmake"
              host/sdk/strata_add_module.cmake host/sdk/module.map host/cmake/embed_glsl.cmake
        DESTINATION "${package_folder}")

# Found from where the file lies, so that an installed tree can be moved.
file(RELATIVE_PATH STRATA_PC_TO_PREFIX "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" STRATA_PC_TO_PREFIX "${STRATA_PC_TO_PREFIX}")
configure_file(host/sdk/strata.pc.in "${PROJECT_BINARY_DIR}/strata.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/strata.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")

install(DIRECTORY abi/strata DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.h")
install(DIRECTORY shaders/strata DESTINATION "${CMAKE_INSTALL_DATADIR}/strata/shaders"
        FILES_MATCHING PATTERN "*.glsl")
if(TARGET strata_cli)
  set_target_properties(strata_cli PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
  install(TARGETS strata_cli)
endif()
if(EXISTS "${PROJECT_SOURCE_DIR}/host/cli/doc/strata.1")
  install(FILES host/cli/doc/strata.1 DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
  install(FILES host/cli/doc/guide.md DESTINATION "${CMAKE_INSTALL_DOCDIR}")
endif()
