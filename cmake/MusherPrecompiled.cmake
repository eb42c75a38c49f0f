# Precompiled headers of the product: of the standard library, and of the libraries that most sources include
# by way of ours. A source includes what it uses nevertheless, which the preset alone shows: it has none of
# these. Nor has the preset lint, since clang-tidy cannot read those of GCC.
option(MUSHER_PRECOMPILED "Compile the headers of the standard library once for all sources" ${MUSHER_UNITY})

# musher_precompiled_headers(<target> <header>) makes the precompiled form of a header, for musher_precompile():
# for libraries, if <target> is a library, or for programs; their code differs (-fPIC, -fPIE).
function(musher_precompiled_headers target header)
  musher_target(${target})
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)
  target_precompile_headers(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:${header}>)
  # What ccache hashes instead of the precompiled headers: GCC never makes the same file of them twice. Without
  # it, it hashes them. Only Ninja lets one target depend on a file of another.
  if(NOT CCACHE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" OR NOT CMAKE_GENERATOR STREQUAL "Ninja")
    return()
  endif()
  set(precompiled ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/cmake_pch.hxx.gch)
  separate_arguments(flags NATIVE_COMMAND "${CMAKE_CXX_FLAGS}")
  set(folders $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
  add_custom_command(OUTPUT ${precompiled}.sum DEPENDS ${precompiled} VERBATIM COMMAND_EXPAND_LISTS
    COMMAND ${CMAKE_CXX_COMPILER} ${flags} "$<$<BOOL:${folders}>:-I$<JOIN:${folders},;-I>>" -std=c++20 -E -P -dD
            -include ${header} -x c++ /dev/null -o ${precompiled}.sum)
  add_custom_target(${target}_sum DEPENDS ${precompiled}.sum)
endfunction()

# musher_reuse_headers(<target> <headers>) compiles the sources of a target with the headers of another one.
function(musher_reuse_headers target headers)
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)  # for ccache
  target_precompile_headers(${target} REUSE_FROM ${headers})
  if(TARGET ${headers}_sum)
    add_dependencies(${target} ${headers}_sum)
  endif()
endfunction()

# The headers with which the sources of the targets of a folder are compiled, by the kind of target; none if
# empty. Set here for the product; test/ has others.
set(MUSHER_LIBRARY_HEADERS "")
set(MUSHER_PROGRAM_HEADERS "")

# musher_precompile(<target>), called for every target of Musher.
function(musher_precompile target)
  get_target_property(kind ${target} TYPE)
  if(kind STREQUAL "EXECUTABLE")
    set(headers ${MUSHER_PROGRAM_HEADERS})
  else()
    set(headers ${MUSHER_LIBRARY_HEADERS})
  endif()
  get_target_property(sources ${target} SOURCES)
  if(headers AND sources MATCHES "\\.cpp")  # not what is written in C alone
    musher_reuse_headers(${target} ${headers})
  endif()
endfunction()

# What most sources of the product read first, and what is dear where it is read.
set(MUSHER_PRODUCT_HEADERS
  CLI/CLI.hpp nlohmann/json.hpp
  algorithm array atomic charconv chrono cmath condition_variable deque filesystem fstream functional map memory
  mutex optional random set sstream string thread tuple unordered_map variant vector)

# musher_precompile_product() makes the headers of libraries and of programs.
macro(musher_precompile_product)
  if(MUSHER_PRECOMPILED)
    list(TRANSFORM MUSHER_PRODUCT_HEADERS REPLACE "(.+)" "#include <\\1>\n" OUTPUT_VARIABLE includes)
    list(JOIN includes "" includes)
    set(header ${PROJECT_BINARY_DIR}/precompiled.hpp)
    set(source ${PROJECT_BINARY_DIR}/precompiled.cpp)
    file(CONFIGURE OUTPUT ${header} CONTENT "#pragma once\n${includes}" @ONLY)
    file(CONFIGURE OUTPUT ${source} CONTENT "int main() {}\n" @ONLY)
    add_library(musher_library_headers STATIC ${source})
    add_executable(musher_program_headers ${source})
    set_target_properties(musher_program_headers PROPERTIES EXCLUDE_FROM_ALL TRUE)
    musher_precompiled_headers(musher_library_headers ${header})
    musher_precompiled_headers(musher_program_headers ${header})
    set(MUSHER_LIBRARY_HEADERS musher_library_headers)
    set(MUSHER_PROGRAM_HEADERS musher_program_headers)
  endif()
endmacro()
