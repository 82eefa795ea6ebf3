# SPDX-License-Identifier: MIT
#
# Builds a module; part of the installed SDK, and used for the modules in plugins/ alike.
#
#     strata_add_module(ID SOURCES a.c... [GLSL x.glsl...] [LIBRARIES target...]
#                       [NO_INSTALL])
#
# makes the target strata_module_ID, the shared object ID.so:
#   - GLSL files are embedded; the header "ID_glsl.h" declares NAME_glsl for each NAME.glsl;
#   - the one symbol it shows is strata_module_v1, and no symbol may be left undefined;
#   - its ELF note is generated from the C descriptor: the objects are linked once without it,
#     strata-note opens and checks that and writes the note, and they are linked again with it.
# ID is the name of the file; by custom the module's id in its descriptor. `cmake --install` puts it
# into lib/strata, unless NO_INSTALL is given.
include(GNUInstallDirs)
set(STRATA_MODULE_MAP "${CMAKE_CURRENT_LIST_DIR}/module.map" CACHE INTERNAL "")

function(strata_add_module id)
  cmake_parse_arguments(PARSE_ARGV 1 MODULE "NO_INSTALL" "" "SOURCES;GLSL;LIBRARIES")
  if(NOT id MATCHES "^[a-z][a-z0-9_]*$" OR NOT MODULE_SOURCES OR MODULE_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "strata_add_module(ID SOURCES a.c... [GLSL x.glsl...] [LIBRARIES t...]): "
                        "bad id, no sources, or unknown arguments \"${MODULE_UNPARSED_ARGUMENTS}\"")
  endif()
  set(target strata_module_${id})
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${id}_note")
  file(MAKE_DIRECTORY "${folder}")

  add_library(${target}_objects OBJECT ${MODULE_SOURCES})
  target_link_libraries(${target}_objects PUBLIC Strata::sdk ${MODULE_LIBRARIES})
  target_compile_features(${target}_objects PRIVATE c_std_11)
  set_target_properties(${target}_objects PROPERTIES
    POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden)
  if(MODULE_GLSL)
    strata_embed_glsl(${target}_objects ${id} ${MODULE_GLSL})
  endif()

  add_library(${target}_bare MODULE)
  add_custom_command(
    OUTPUT "${folder}/${id}_note.c"
    COMMAND Strata::note "$<TARGET_FILE:${target}_bare>" "${folder}/${id}_note.c"
    DEPENDS ${target}_bare Strata::note
    COMMENT "Writing the note of ${id}" VERBATIM)
  add_library(${target} MODULE "${folder}/${id}_note.c")
  foreach(stage IN ITEMS ${target}_bare ${target})
    target_link_libraries(${stage} PRIVATE ${target}_objects m)
    target_link_options(${stage} PRIVATE
      "LINKER:--version-script=${STRATA_MODULE_MAP}" "LINKER:-z,defs,-z,text,-z,noexecstack"
      "LINKER:--as-needed")
    set_target_properties(${stage} PROPERTIES
      PREFIX "" SUFFIX ".so" OUTPUT_NAME ${id} C_STANDARD 11
      LINK_DEPENDS "${STRATA_MODULE_MAP}")
  endforeach()
  set_target_properties(${target}_bare PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${folder}")
  if(STRATA_MODULE_OUTPUT_DIRECTORY)
    set_target_properties(${target} PROPERTIES
      LIBRARY_OUTPUT_DIRECTORY "${STRATA_MODULE_OUTPUT_DIRECTORY}")
  endif()
  if(NOT MODULE_NO_INSTALL)
    install(TARGETS ${target} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/strata")
  endif()
endfunction()
