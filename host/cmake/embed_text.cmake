# SPDX-License-Identifier: MIT
#
# Embeds text files into C as NUL-terminated strings.
#
#     strata_embed_text(TARGET HEADER NAME=FILE...)
#
# adds to TARGET a generated source and HEADER, which declares for each NAME
# `extern const char NAME_text[];`. An empty FILE gives "". Run as a script, this file is the generator.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(STRATA_EMBED_TEXT_SCRIPT "${CMAKE_CURRENT_LIST_FILE}" CACHE INTERNAL "")

  function(strata_embed_text target header)
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/${target}_text")
    get_filename_component(name "${header}" NAME_WE)
    set(files)
    foreach(pair IN LISTS ARGN)
      string(REGEX REPLACE "^[^=]*=" "" file "${pair}")
      if(file)
        list(APPEND files "${file}")
      endif()
    endforeach()
    file(MAKE_DIRECTORY "${folder}")
    add_custom_command(
      OUTPUT "${folder}/${name}.c" "${folder}/${name}.h"
      COMMAND "${CMAKE_COMMAND}" "-DNAME=${name}" "-DFOLDER=${folder}" "-DPAIRS=${ARGN}"
              -P "${STRATA_EMBED_TEXT_SCRIPT}"
      DEPENDS ${files} "${STRATA_EMBED_TEXT_SCRIPT}"
      COMMENT "Embedding ${name}" VERBATIM)
    target_sources(${target} PRIVATE "${folder}/${name}.c" "${folder}/${name}.h")
    target_include_directories(${target} PRIVATE "${folder}")
  endfunction()
  return()
endif()

set(header "/* Generated from text files. */\n#pragma once\n\n")
set(source "/* Generated from text files. */\n#include \"${NAME}.h\"\n\n")
foreach(pair IN LISTS PAIRS)
  string(REGEX REPLACE "=.*" "" id "${pair}")
  string(REGEX REPLACE "^[^=]*=" "" file "${pair}")
  set(text "")
  if(file)
    file(READ "${file}" text HEX)
  endif()
  # One character constant a byte: string literals of this length are beyond what C promises.
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," text "${text}")
  string(REGEX REPLACE "((.......){14})" "\\1\n    " text "${text}")
  string(APPEND source "const char ${id}_text[] = {\n    ${text}0};\n\n")
  string(APPEND header "extern const char ${id}_text[];\n")
endforeach()
file(WRITE "${FOLDER}/${NAME}.h" "${header}")
file(WRITE "${FOLDER}/${NAME}.c" "${source}")
