# SPDX-License-Identifier: MIT
#
# The libraries that libstrata stands on, as imported targets. pkg-config where the distributions
# ship a file that is right; glslang by hand, because its package files leave out libraries that
# its archives need and differ from release to release.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson>=2.13)
pkg_check_modules(PNG REQUIRED IMPORTED_TARGET libpng>=1.6)
pkg_check_modules(CGLM REQUIRED IMPORTED_TARGET cglm>=0.8)
pkg_check_modules(VULKAN REQUIRED IMPORTED_TARGET vulkan>=1.3)
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)
pkg_check_modules(SPIRV_CROSS REQUIRED IMPORTED_TARGET spirv-cross-c-shared)
pkg_check_modules(TINYGLTF REQUIRED IMPORTED_TARGET tinygltf)
pkg_check_modules(OPENEXR REQUIRED IMPORTED_TARGET OpenEXR>=3.1)
find_package(meshoptimizer REQUIRED) # 0.18 or later; its package calls no later minor compatible

# Archives that depend on each other; which of them exist depends on glslang's version (12 to 15).
find_path(GLSLANG_INCLUDE glslang/Include/glslang_c_interface.h REQUIRED)
set(glslang_archives)
foreach(name IN ITEMS glslang SPIRV glslang-default-resource-limits)
  find_library(GLSLANG_${name} ${name} REQUIRED)
  list(APPEND glslang_archives ${GLSLANG_${name}})
endforeach()
foreach(name IN ITEMS MachineIndependent GenericCodeGen OSDependent OGLCompiler
                      SPIRV-Tools-opt SPIRV-Tools)
  find_library(GLSLANG_${name} ${name})
  if(GLSLANG_${name})
    list(APPEND glslang_archives ${GLSLANG_${name}})
  endif()
endforeach()
add_library(strata_glslang INTERFACE)
target_include_directories(strata_glslang SYSTEM INTERFACE ${GLSLANG_INCLUDE})
target_link_libraries(strata_glslang INTERFACE
  -Wl,--start-group ${glslang_archives} -Wl,--end-group Threads::Threads stdc++ m)

# Chart.js 3 (libjs-chart.js) draws the plots of sweeps' reports, and becomes part of them; it is
# built in. Without it, or with -DSTRATA_CHART_JS=, reports have tables alone and say so.
find_file(STRATA_CHART_JS NAMES chart.min.js Chart.min.js
  PATHS /usr/share/javascript/chart.js /usr/share/nodejs/chart.js/dist NO_DEFAULT_PATH)
if(NOT STRATA_CHART_JS)
  set(STRATA_CHART_JS "")
  message(STATUS "Chart.js was not found: reports of sweeps will have no plots")
endif()
