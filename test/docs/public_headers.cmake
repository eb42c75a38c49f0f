# Prints the public headers, one a line: cmake -DPROJECT_SOURCE_DIR=FOLDER -P public_headers.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/../../cmake/PublicHeaders.cmake)
musher_public_headers(headers)
list(JOIN headers "\n" lines)
execute_process(COMMAND ${CMAKE_COMMAND} -E echo ${lines})
