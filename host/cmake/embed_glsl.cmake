# SPDX-License-Identifier: MIT
#
# Embeds GLSL files into C as {text, path}; part of the installed SDK.
#
#     strata_embed_glsl(TARGET ID [BASE FOLDER] FILES...)
#
# adds to TARGET a generated source and the header "ID_glsl.h", which declares for each FILE
# NAME.glsl `extern const strata_glsl NAME_glsl;` (a dot in NAME becomes _) and for all of them
# `extern const strata_glsl *const ID_glsl_all[];`, NULL-terminated. The path that compile errors
# name is FILE's, relative to BASE (default: the project's top folder). Run as a script, this file
# is the generator.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(STRATA_EMBED_SCRIPT "${CMAKE_CURRENT_LIST_FILE}" CACHE INTERNAL "")

  function(strata_embed_glsl target id)
    cmake_parse_arguments(PARSE_ARGV 2 EMBED "" "BASE" "")
    if(NOT EMBED_BASE)
      set(EMBED_BASE "${CMAKE_SOURCE_DIR}")
    endif()
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/${id}_glsl")
    set(files)
    foreach(file IN LISTS EMBED_UNPARSED_ARGUMENTS)
      get_filename_component(file "${file}" ABSOLUTE)
      list(APPEND files "${file}")
    endforeach()
    file(MAKE_DIRECTORY "${folder}")
    add_custom_command(
      OUTPUT "${folder}/${id}_glsl.c" "${folder}/${id}_glsl.h"
      COMMAND "${CMAKE_COMMAND}" "-DID=${id}" "-DBASE=${EMBED_BASE}" "-DFOLDER=${folder}"
              "-DFILES=${files}" -P "${STRATA_EMBED_SCRIPT}"
      DEPENDS ${files} "${STRATA_EMBED_SCRIPT}"
      COMMENT "Embedding GLSL of ${id}" VERBATIM)
    target_sources(${target} PRIVATE "${folder}/${id}_glsl.c" "${folder}/${id}_glsl.h")
    target_include_directories(${target} PRIVATE "${folder}")
  endfunction()
  return()
endif()

set(header "/* Generated from GLSL. */\n#pragma once\n#include \"strata/gpu.h\"\n\n")
set(source "/* Generated from GLSL. */\n#include \"${ID}_glsl.h\"\n\n")
set(all)
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME_WLE)
  string(MAKE_C_IDENTIFIER "${name}" name)
  file(RELATIVE_PATH path "${BASE}" "${file}")
  if(path MATCHES "^\\.\\./")
    get_filename_component(path "${file}" NAME)
  endif()
  file(READ "${file}" text HEX)
  # One character constant a byte: string literals of this length are beyond what C promises.
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," text "${text}")
  string(REGEX REPLACE "((.......){14})" "\\1\n    " text "${text}")
  string(APPEND source "static const char ${name}_text[] = {\n    ${text}0};\n"
                       "const strata_glsl ${name}_glsl = {${name}_text, \"${path}\"};\n\n")
  string(APPEND header "extern const strata_glsl ${name}_glsl; /* ${path} */\n")
  string(APPEND all "&${name}_glsl, ")
endforeach()
string(APPEND header "extern const strata_glsl *const ${ID}_glsl_all[]; /* NULL-terminated */\n")
string(APPEND source "const strata_glsl *const ${ID}_glsl_all[] = {${all}NULL};\n")
file(WRITE "${FOLDER}/${ID}_glsl.h" "${header}")
file(WRITE "${FOLDER}/${ID}_glsl.c" "${source}")
